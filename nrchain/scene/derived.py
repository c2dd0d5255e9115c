"""What follows from the keys of a scene: drag, moduli, length, wavevector, and the slip in words.

:class:`~nrchain.scene.scene.Scene` offers each as a property.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from nrchain.hydrodynamics import slip_modes
from nrchain.scene.chain_sections import ChainSpec, ElasticitySpec, RunSpec, StartSpec
from nrchain.scene.fluid_sections import LEAST_ACCURACY, SlipSpec
from nrchain.wording import span

DEFAULT_RATIO = 1e7
"""R of the stiffness rule when a scene gives no stiffness; the paper's value for its snapshots."""


class Drag(NamedTuple):
    """γ_T = 6πηa and γ_R = 8πηa³ of one sphere."""

    translation: float
    rotation: float


class Moduli(NamedTuple):
    """λ∥, λ⊥, μ∥ and μ⊥ of the elastic potential; 0 stands for a term that is absent."""

    stretch: float
    shear: float
    twist: float
    bend: float


def drag(chain: ChainSpec) -> Drag:
    """γ_T = 6πηa and γ_R = 8πηa³."""
    radius, viscosity = chain.radius, chain.viscosity
    return Drag(6 * math.pi * viscosity * radius, 8 * math.pi * viscosity * radius**3)


def moduli(chain: ChainSpec, given: ElasticitySpec) -> Moduli:
    """λ∥, λ⊥, μ∥, μ⊥, as given or by the stiffness rule (paper, Appendix D)."""
    d = chain.spacing
    translation, rotation = drag(chain)
    bend = translation * d**2 if given.bend is None else given.bend
    twist = bend if given.twist is None else given.twist
    if given.stretch is not None and given.shear is not None:
        return Moduli(given.stretch, given.shear, twist, bend)
    ratio = DEFAULT_RATIO if given.ratio is None else given.ratio
    links = float(chain.particles - 1)
    stiffness = ratio * bend * rotation / (translation * d**4 * links**4)
    return Moduli(stiffness, stiffness, twist, bend)


def length(chain: ChainSpec) -> float:
    """L = (N−1) d; of a periodic chain its period, N d."""
    links = chain.particles - (chain.ends != "periodic")
    return links * chain.spacing


def period(chain: ChainSpec) -> float:
    """The length after which a periodic chain repeats along x; 0 for open chains."""
    return length(chain) if chain.ends == "periodic" else 0.0


def pair_accuracy(slip: SlipSpec, run: RunSpec) -> float:
    """Largest relative error of sums over all pairs; 0 stands for direct sums."""
    if slip.accuracy == "direct":
        return 0.0
    accuracy = run.rtol if slip.accuracy is None else slip.accuracy
    return accuracy if accuracy >= LEAST_ACCURACY else 0.0


def wavevector(chain: ChainSpec, start: StartSpec) -> float:
    """q = wavenumber · π/L, or wavenumber · 2π/L on a periodic chain."""
    unit = 2 * math.pi if chain.ends == "periodic" else math.pi
    return start.wavenumber * unit / length(chain)


def slip_has_sum(slip: SlipSpec) -> bool:
    """Whether the slip flows of an endless chain converge: a flow of order 1/r does not."""
    flows = (
        slip_modes.find(label).flow()
        for label, mode in slip.modes.items()
        if (any(mode.strength) if isinstance(mode.strength, tuple) else mode.strength)
    )
    return not any(power == 1 for flow in flows for _, power in flow)


def modes_text(slip: SlipSpec) -> str:
    """The modes and their strengths, such as ``"2s +100, 3a −5000"``."""
    words = []
    for label, mode in slip.modes.items():
        given = mode.strength
        strengths = given if isinstance(given, tuple) else (given,)
        ends = span(f"{min(strengths):+g}", f"{max(strengths):+g}")
        words.append(f"{label} {ends}".replace("-", "−"))
    return ", ".join(words) or "passive"
