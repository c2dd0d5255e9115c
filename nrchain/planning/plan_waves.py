"""Λ(q) of the infinite chain: the lines of a plan that compare a scene with plane waves.

The waves lie between one over the whole chain and two spheres long. They exist where one strength
holds for all spheres.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from nrchain.effects.shared.image_sums import net_forces, takes_all
from nrchain.effects.shared.slip_flow import reach_text
from nrchain.errors import SceneError
from nrchain.planning.plan_line import Line
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.theory.lattice import (
    Branch,
    chain_waves,
    lattice_rates,
    steady_rotation,
    steady_velocity,
)
from nrchain.wording import span

_BENDING = [Branch.BEND_PLUS, Branch.BEND_MINUS]

_INFINITE = "of the infinite chain"


def wave_lines(scene: Scene) -> list[Line]:
    """The lines on waves and on the reach of flows; where there are none, the reason, once."""
    waves = _compared("waves", _wave_lines, scene)
    reach = _compared("reach", _reach_lines, scene)
    shown = {line.meaning for line in waves}
    return [*waves, *(line for line in reach if line.meaning not in shown)]


def _compared(name: str, part: Callable[[Scene], list[Line]], scene: Scene) -> list[Line]:
    """The lines of one part, or one that says why there are none."""
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            return part(scene)
    except SceneError as error:
        # a list of strengths would fill the table
        listed = isinstance(error.value, tuple)
        reason = f"{error.key} {error.allowed}" if listed else str(error)
        return [Line(name, "not compared", f"the chain has no plane waves: {reason}")]
    except FloatingPointError as error:
        return [Line(name, "not compared", f"beyond the range of floating point: {error}")]


def _wave_lines(scene: Scene) -> list[Line]:
    """Growth, rates and motion of the infinite chain."""
    waves, end = chain_waves(scene), scene.run.end
    rates = lattice_rates(scene, waves, frame="spinning")
    sizes, growth = np.abs(rates), rates.real.max(axis=1)
    fastest, slowest = sizes.max(), sizes[sizes > 0].min() if sizes.any() else 0.0
    stiffness = f"stiffness |Λ|·t = {fastest * end:.1e} over the run"
    bending = float(rates[0, _BENDING].real.max())
    best = int(np.argmax(growth))
    grows = Line("waves: growth", "none", f"every wave {_INFINITE} decays")
    if growth[best] > 1e-12 * fastest:
        at = f"Re Λ = {growth[best]:.3e} at qd = {waves[best] * scene.chain.spacing:.3g}"
        grows = Line("waves: growth", at, f"of the fastest wave {_INFINITE}")
    lines = [
        Line(
            "waves: rates",
            "|Λ| = " + span(f"{slowest:.2e}", f"{fastest:.2e}"),
            f"the slowest and the fastest wave {_INFINITE}; {stiffness}",
        ),
        Line(
            "waves: longest", f"Re Λ = {bending:+.3e}", f"of the longest bending wave {_INFINITE}"
        ),
        grows,
    ]
    velocity, spin = steady_velocity(scene)[0], steady_rotation(scene)[0]
    if velocity:
        lines.append(Line("waves: swims", f"V₀ = {velocity:.4g}", _INFINITE))
    if spin:
        lines.append(Line("waves: spins", f"Ω₀ = {spin:.4g}", _INFINITE))
    return lines


def _reach_lines(scene: Scene) -> list[Line]:
    """The part of the rates of the infinite chain that the reach of flows leaves out."""
    lines = []
    slip, friction = scene.slip, scene.friction
    active = any(np.any(mode.strength) for mode in slip.modes.values())
    if active and slip.neighbours != "all":
        slack = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "twist", "bend")}
        loose = load_scene(scene, friction="one-body", **slack, **{"elasticity.ratio": None})
        left = _left_out(loose, "slip.neighbours")
        lines.append(
            Line(
                "reach of slip",
                f"{100.0 * left:.3g} % left out",
                f"of the rates that slip gives the longest wave {_INFINITE}, beyond "
                f"{reach_text(slip.neighbours)}; slip.neighbours = 'all' keeps it",
            )
        )
    if friction.kind == "pairwise" and friction.neighbours != "all":
        passive = load_scene(scene, slip=None)
        passive = load_scene(passive, **{f"slip.{label}": None for label in slip.modes})
        for effect in net_forces(passive):
            passive = effect.without(passive)
        lines.append(
            Line(
                "reach of friction",
                f"{100.0 * _left_out(passive, 'friction.neighbours'):.3g} % left out",
                f"of the passive decay of the longest bending wave {_INFINITE}, beyond "
                f"{reach_text(friction.neighbours)}"
                + ("; friction.neighbours = 'all' keeps it" if takes_all(scene) else ""),
            )
        )
    return lines


def _left_out(scene: Scene, key: str) -> float:
    """The part of the rates of the longest wave that all pairs would change."""
    wave = [math.pi / (scene.chain.particles * scene.chain.spacing)]
    near = lattice_rates(scene, wave)[0]
    every = lattice_rates(load_scene(scene, **{key: "all"}), wave)[0]
    if key == "friction.neighbours":
        near, every = near[_BENDING], every[_BENDING]
    largest = float(np.abs(every).max())
    return float(np.abs(every - near).max()) / largest if largest else 0.0
