"""What the numbers of a scene foretell: its stiffness, its rates, its motion, its start.

Rates are those of the infinite straight chain (:mod:`nrchain.lattice`), for waves between one over
the chain and two spheres long, passive or active, with the friction that the scene names. Chains
whose strengths differ from sphere to sphere are judged by uniform ones, see
:func:`nrchain.regime.judged_by`.
Nothing is run.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nrchain.chain import closest_pair
from nrchain.endless import net_forces, takes_all
from nrchain.errors import SceneError
from nrchain.flow_reach import reach_of_strain
from nrchain.hydrodynamics.definiteness import is_cut, least_mobility
from nrchain.lattice import Branch, lattice_rates, steady_rotation, steady_velocity
from nrchain.regime import (
    LARGEST_STRAIN,
    growth_rates,
    judged_by,
    loads,
    remedy,
    rounding_drift,
    warnings,
)
from nrchain.scene import Scene, load_scene
from nrchain.seed import start_size
from nrchain.start import starting_poses
from nrchain.wording import span

_BENDING = [Branch.BEND_PLUS, Branch.BEND_MINUS]

SOFTENING = math.pi / 4
"""Turn of a link from which the paper's springs of twist and bend, sin² of it, get weaker."""


@dataclass(frozen=True)
class Line:
    """One quantity of a plan, its value in words, and what it means."""

    quantity: str
    value: str
    meaning: str


@dataclass(frozen=True)
class Plan:
    """What a scene will do, line by line, and what to beware of."""

    lines: list[Line]
    warnings: list[str]


def plan(scene: Scene) -> Plan:
    """The regime a scene is in, from its numbers alone.

    What needs a straight chain that stays one is left out where the scene has none, and says so.
    Raises :class:`~nrchain.errors.SceneError` for a start that a run would refuse.
    """
    positions, _ = starting_poses(scene)
    lines = [_start_line(scene, positions)]
    if is_cut(scene):
        lines.append(_mobility_line(scene, positions))
    if len(judged_by(scene)) > 1:
        what = "differ from sphere to sphere"
        meaning = "what follows is for uniform chains of the extreme ones, the worst of them"
        lines.append(Line("strengths", what, meaning))
    for part in (_stiffness_lines, _rate_lines, _motion_lines, _reach_lines):
        lines += _judged(part, scene)
    lines += [Line(*row) for row in reach_of_strain(scene, positions)]
    drift = rounding_drift(scene)
    lines.append(
        Line("rounding", f"{drift:.1e} per unit time", "drift that springs make of rounded places")
    )
    return Plan(lines, warnings(scene))


def _judged(part: Callable[[Scene], list[Line]], scene: Scene) -> list[Line]:
    """The lines of one part, or why there are none."""
    name = part.__name__.removeprefix("_").removesuffix("_lines")
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            return part(scene)
    except SceneError as error:
        return [Line(name, "not judged", f"plane waves do not tell: {error}")]
    except FloatingPointError as error:
        return [Line(name, "not judged", f"beyond the range of floats: {error}")]


def _mobility_line(scene: Scene, positions: np.ndarray) -> Line:
    return Line(
        "friction",
        f"least mobility {least_mobility(scene, positions):.2g}",
        "of a sphere's own, over all wrenches at the start; as the chain moves it must stay "
        "positive"
        + (", which friction.neighbours = 'all' always does" if takes_all(scene) else ""),
    )


def _start_line(scene: Scene, positions: np.ndarray) -> Line:
    period = scene.length if scene.chain.ends == "periodic" else 0.0
    distance, i, j = closest_pair(positions, period)
    ratio = scene.chain.radius / min(distance, scene.chain.spacing)
    return Line(
        "closest approach",
        f"{distance / scene.chain.radius:.4g} a",
        f"spheres {i} and {j} at the start; (a/r)² = {ratio**2:.1g}, and the pair laws leave out "
        "what is of that order",
    )


def _stiffness_lines(scene: Scene) -> list[Line]:
    lines = []
    for load in loads(scene):
        ratio = math.copysign(load.strain, load.prestress)
        held = f"{load.prestress:.3g}/{load.stiffness:.3g} = {ratio:.2g}"
        if not load.prestress:
            meaning = "no active prestress strains the bonds"
        elif load.holds:
            meaning = f"in the beam limit, to which up to {LARGEST_STRAIN:g} belongs"
        else:
            meaning = f"out of the beam limit; {remedy(scene, load)}"
        lines.append(Line(load.name, f"prestress/{load.symbol} = {held}", meaning))
    return lines


def _rate_lines(scene: Scene) -> list[Line]:
    d, end = scene.chain.spacing, scene.run.end
    waves, rates = growth_rates(scene)
    sizes = np.abs(rates)
    fastest, slowest = sizes.max(), sizes[sizes > 0].min() if sizes.any() else 0.0
    growth = rates.real.max(axis=(0, 2))
    best = int(np.argmax(growth))
    stiffness = f"a stiffness of {fastest * end:.1e} over the run"
    bending = float(rates[:, 0, _BENDING].real.max())
    lines = [
        Line(
            "rates",
            span(f"{slowest:.2e}", f"{fastest:.2e}"),
            f"|Λ| of the slowest and the fastest wave; {stiffness}",
        ),
        Line("longest wave", f"{bending:+.3e}", "growth rate of bending over the chain"),
    ]
    if growth[best] <= 1e-12 * fastest:
        return [*lines, Line("growth", "none", "every wave decays")]
    tens = growth[best] * end / math.log(10)
    meaning = f"{tens:.3g} factors of ten by the end"
    if 0.0 < (size := start_size(scene)) < d:
        large = math.log(d / size) / growth[best]
        meaning += f"; the start grows to the size of d by t = {large:.3g}"
    lines.append(Line("growth", f"{growth[best]:.3e} at qd = {waves[best] * d:.3g}", meaning))
    if tens > 1.0 and scene.elasticity.measure == "paper":
        lines.append(_turn_line(scene, waves[best] * d))
    return lines


def _turn_line(scene: Scene, phase: float) -> Line:
    return Line(
        "turns",
        f"of {phase:.2g} rad a link",
        f"when the slopes of that wave reach 1; from {SOFTENING:.2g} rad on the paper's springs "
        "soften and links may snap over, which elasticity.measure = 'isotropic' puts off",
    )


def _motion_lines(scene: Scene) -> list[Line]:
    velocity = max((steady_velocity(s) for s in judged_by(scene)), key=lambda v: float(v @ v))
    rotation = max((float(steady_rotation(s)[0]) for s in judged_by(scene)), key=abs)
    lines = []
    if velocity.any():
        along = f"{velocity[0]:.4g}"
        across = f"({along}, {velocity[1]:.4g}, {velocity[2]:.4g})"
        way = float(np.linalg.norm(velocity)) * scene.run.end / scene.chain.spacing
        text = f"V₀ = {across if velocity[1:].any() else along}"
        held = scene.chain.ends == "clamped"
        meaning = "if its ends were not held" if held else f"{way:.3g} spacings by the end"
        lines.append(Line("swims", text, meaning))
    turns = rotation * scene.run.end / (2.0 * math.pi)
    meaning = f"{turns:.4g} turns by the end"
    if rotation and scene.chain.ends == "clamped":
        meaning = "if its ends were not held"
    lines.append(Line("spins", f"Ω₀ = {rotation:.4g}", meaning))
    return lines


def _reach_lines(scene: Scene) -> list[Line]:
    """What lies beyond the neighbours that count, of the rates of the longest wave."""
    lines = []
    slip, friction = scene.slip, scene.friction
    active = any(np.any(mode.strength) for mode in slip.modes.values())
    if active and slip.neighbours != "all":
        slack = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "twist", "bend")}
        loose = load_scene(scene, friction="one-body", **slack, **{"elasticity.ratio": None})
        left = max(_left_out(bound, "slip.neighbours") for bound in judged_by(loose))
        lines.append(
            Line(
                "reach of slip",
                f"{100.0 * left:.3g} % left out",
                f"of the rates that slip gives the longest wave, beyond {slip.neighbours} "
                "a side; slip.neighbours = 'all' keeps it",
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
                f"of the passive decay of the longest bending wave, beyond {friction.neighbours} "
                "a side" + ("; friction.neighbours = 'all' keeps it" if takes_all(scene) else ""),
            )
        )
    return lines


def _left_out(scene: Scene, key: str) -> float:
    """The share of the rates of the longest wave that all pairs would change."""
    wave = [math.pi / (scene.chain.particles * scene.chain.spacing)]
    near = lattice_rates(scene, wave)[0]
    every = lattice_rates(load_scene(scene, **{key: "all"}), wave)[0]
    if key == "friction.neighbours":
        near, every = near[_BENDING], every[_BENDING]
    largest = float(np.abs(every).max())
    return float(np.abs(every - near).max()) / largest if largest else 0.0
