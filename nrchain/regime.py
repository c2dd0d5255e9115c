"""Is λd well above the active prestress? What a scene's numbers say before it runs.

The paper's laws, and the picture of a bending chain, hold in the beam limit: bonds that neither
stretch nor shear. The stiffness rule λ ∝ (N−1)⁻⁴ loses it quickly as chains grow. With R = 1e7,
N = 64 and 2s at V = 100, λd is 1.6 against a prestress of −44, and a free chain tears itself apart
within 80 time units.

Chains whose strengths differ from sphere to sphere are judged by three uniform chains: each mode at
its least, each at its greatest, and each at its strongest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.arguments import a_scene
from nrchain.chain import initial_poses
from nrchain.effects.slip import active_modes
from nrchain.errors import SceneError
from nrchain.flow_forces import stokeslet_warning
from nrchain.lattice import Branch, lattice_rates, steady_stress
from nrchain.scene import DEFAULT_RATIO, Scene, load_scene
from nrchain.seed import BARELY, seed_warning

LARGEST_STRAIN = 0.3
"""Prestress over λ∥d or λ⊥d beyond which a scene is called out of the beam limit."""

WAVENUMBERS = 64
"""How many waves, from one over the chain to two spheres long, are tried for growth."""

STEPS_PER_NOISE = 0.3
"""Steps CVODE takes for every ``atol`` by which rounding moves a sphere: measured, N = 64."""

NOISE_STEPS = 5000
"""More steps than this for the rounding of stiff springs alone are worth a warning."""


@dataclass(frozen=True)
class Load:
    """The active prestress against one of the two moduli that hold the bonds, times d."""

    name: str
    symbol: str
    prestress: float
    stiffness: float

    @property
    def strain(self) -> float:
        """|prestress|/λd: how far bonds give way, while that is little."""
        if not self.prestress:
            return 0.0
        return abs(self.prestress) / self.stiffness if self.stiffness else math.inf

    @property
    def holds(self) -> bool:
        """Whether that is little."""
        return self.strain <= LARGEST_STRAIN


def warnings(scene: Scene) -> list[str]:
    """What to know before a scene runs, one sentence each with its numbers and a remedy.

    Empty for a scene in the beam limit whose tolerance is above the rounding of its springs, whose
    start is above that tolerance where it grows, and which keeps no smaller flow beside a larger
    one that it drops. A scene that no plane wave describes (axes that turn the chain across itself,
    a flow whose sum over an endless chain diverges) cannot be judged, which is said instead.
    """
    told = [*_beam_warnings(a_scene(scene)), _rounding_warning(scene), _start_warning(scene)]
    told.append(stokeslet_warning(scene, *initial_poses(scene)))
    return [text for text in told if text]


def judged_by(scene: Scene) -> list[Scene]:
    """Uniform chains to judge a scene by: of its least, greatest and strongest; or itself."""
    differing = {
        f"slip.{label}.strength": slip.strength
        for label, slip in scene.slip.modes.items()
        if isinstance(slip.strength, tuple)
    }
    chosen: list[dict[str, float]] = []
    for choose in (min, max, lambda strengths: max(strengths, key=abs)):
        strengths = {key: choose(each) for key, each in differing.items()}
        if strengths not in chosen:
            chosen.append(strengths)
    return [load_scene(scene, **strengths) for strengths in chosen] if differing else [scene]


def loads(scene: Scene) -> tuple[Load, Load]:
    """The loads on stretch and on shear, under the largest prestress of any part of the chain.

    Raises :class:`~nrchain.errors.SceneError` for a straight chain that is no steady state.
    """
    half = max(scene.chain.particles // 2, 1)
    stresses = [float(steady_stress(_one_body(s), spheres=half)[0]) for s in judged_by(scene)]
    prestress, d = max(stresses, key=abs), scene.chain.spacing
    moduli = scene.moduli
    return (
        Load("stretch", "λ∥d", prestress, moduli.stretch * d),
        Load("shear", "λ⊥d", prestress, moduli.shear * d),
    )


def remedy(scene: Scene, load: Load) -> str:
    """What of the scene would hold the bonds under a load that they do not hold now."""
    needed = abs(load.prestress) / (LARGEST_STRAIN * scene.chain.spacing)
    modulus = load.stiffness / scene.chain.spacing
    if scene.elasticity.stretch is not None:
        return f"elasticity.{load.name} of {_up(needed)} or more holds them"
    if not modulus:
        return "elasticity.bend is 0, and with it the stiffness that elasticity.ratio gives"
    ratio = scene.elasticity.ratio or DEFAULT_RATIO
    text = f"elasticity.ratio of {_up(ratio * needed / modulus)} or more holds them"
    links = (scene.chain.particles - 1) * (modulus / needed) ** 0.25
    if links >= 2:
        text += f", as do {math.floor(links) + 1} spheres or fewer at this ratio"
    return text


def growth_rates(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Waves q (Q,) and the rates (S, Q, 6) of the S chains that the scene is judged by.

    Growth does not depend on the axes in which it is seen: they spin with the chain. Errors as for
    :func:`~nrchain.lattice.lattice_rates`.
    """
    count, d = scene.chain.particles, scene.chain.spacing
    waves = np.linspace(math.pi / (count * d), math.pi / d, WAVENUMBERS)
    return waves, np.stack([lattice_rates(s, waves, frame="spinning") for s in judged_by(scene)])


def rounding_drift(scene: Scene) -> float:
    """ε λ L/γ_T: the velocity that the rounding of coordinates gives a sphere through its springs.

    A coordinate of size L is known to εL, a link strains by as much over d, and its springs, of
    stiffness λ, answer with a force that no step can resolve.
    """
    stiffness = max(scene.moduli.stretch, scene.moduli.shear)
    return float(np.finfo(float).eps) * stiffness * scene.length / scene.drag.translation


def _beam_warnings(scene: Scene) -> list[str]:
    told = []
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            stretch, shear = loads(scene)
            told.append(_strain_warning(scene, stretch))
            if stretch.holds or shear.stiffness != stretch.stiffness:
                told.append(_strain_warning(scene, shear))
            told.append(_growth_warning(scene))
    except (SceneError, FloatingPointError) as error:
        if active_modes(scene):
            told.append(f"what the slip does to the bonds cannot be judged beforehand: {error}")
    return told


def _rounding_warning(scene: Scene) -> str:
    moved = STEPS_PER_NOISE * rounding_drift(scene) * scene.run.end / scene.chain.radius
    steps = moved / scene.run.atol
    if steps <= NOISE_STEPS:
        return ""
    return (
        f"run.atol = {scene.run.atol:g} is below what rounding leaves of springs this stiff, and "
        f"takes some {steps:.1g} steps; no more accuracy is to be had below run.atol = "
        f"{moved / NOISE_STEPS:.1g}"
    )


def _start_warning(scene: Scene) -> str:
    start = scene.start
    large = abs(start.amplitude) >= BARELY * scene.run.atol * scene.chain.radius
    if start.shape not in ("straight", "given") and large:
        return ""
    return seed_warning(scene, *initial_poses(scene))


def _one_body(scene: Scene) -> Scene:
    """The scene with one-body friction: forces between spheres do not depend on it."""
    return load_scene(scene, friction="one-body")


def _up(number: float) -> str:
    """Two digits, and no less than the number."""
    if not math.isfinite(number):
        return "more than a float holds"
    step = 10.0 ** (math.floor(math.log10(number)) - 1)
    return f"{math.ceil(number / step * (1.0 - 1e-12)) * step:.2g}"


def _strain_warning(scene: Scene, load: Load) -> str:
    if load.holds:
        return ""
    what = "bonds give way" if load.name == "stretch" else "tangents turn away from e₁"
    part = f"is {load.strain:.2g} of {load.symbol} = {load.stiffness:.3g}, and"
    if not load.stiffness:
        part = f"meets no {load.symbol}:"
    return (
        f"out of the beam limit: the active prestress {abs(load.prestress):.3g} {part} {what}; "
        f"{remedy(scene, load)}"
    )


def _growth_warning(scene: Scene) -> str:
    rates = growth_rates(scene)[1].real
    fast = rates[..., [Branch.STRETCH, Branch.SHEAR_PLUS, Branch.SHEAR_MINUS]]
    growth = float(fast.max())
    if growth * scene.run.end < 1.0:
        return ""
    return (
        f"bonds stretch or shear by themselves, tenfold every {math.log(10) / growth:.3g} time "
        "units, until the chain comes apart; stiffen it, or weaken "
        + ("the slip" if scene.slip.modes else "what acts on it")
    )
