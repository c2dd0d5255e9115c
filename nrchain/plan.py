"""What the numbers of a scene foretell: its stiffness, its rates, its motion, its start.

Rates are those of the infinite straight chain (:mod:`nrchain.lattice`), for waves between one over
the chain and two spheres long. Nothing is run.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.chain import closest_pair
from nrchain.errors import SceneError
from nrchain.lattice import (
    Branch,
    lattice_rates,
    steady_rotation,
    steady_stress,
    steady_velocity,
)
from nrchain.regime import LARGEST_STRAIN, WAVENUMBERS, rounding_drift, warnings
from nrchain.scene import Scene, load_scene
from nrchain.start import starting_poses

_BENDING = [Branch.BEND_PLUS, Branch.BEND_MINUS]


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

    Lines that need a uniform straight chain are left out where the scene has none, and say so.
    Raises :class:`~nrchain.errors.SceneError` for a start that a run would refuse.
    """
    lines = [_start_line(scene)]
    try:
        lines += [*_stiffness_lines(scene), *_rate_lines(scene), *_motion_lines(scene)]
        lines += _reach_lines(scene)
    except SceneError as error:
        lines.append(Line("straight chain", "none", f"no plane waves to judge by: {error}"))
    except FloatingPointError as error:
        lines.append(Line("straight chain", "beyond range", str(error)))
    drift = rounding_drift(scene)
    lines.append(
        Line("rounding", f"{drift:.1e} per unit time", "drift that springs make of rounded places")
    )
    return Plan(lines, warnings(scene))


def _start_line(scene: Scene) -> Line:
    positions, _ = starting_poses(scene)
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
    stress = steady_stress(_one_body(scene), spheres=max(scene.chain.particles // 2, 1))
    prestress, tension = float(stress[0]), scene.moduli.stretch * scene.chain.spacing
    shear = scene.moduli.shear * scene.chain.spacing
    if prestress == 0.0:
        return [Line("stiffness", f"λ∥d = {tension:.4g}", "no active prestress strains the bonds")]
    strain = abs(prestress) / tension if tension else math.inf
    holds = strain <= LARGEST_STRAIN
    return [
        Line(
            "stretch",
            f"prestress/λ∥d = {prestress:.3g}/{tension:.3g} = {strain:.2g}",
            "in the beam limit" if holds else "bonds give way: see the warning",
        ),
        Line(
            "shear",
            f"prestress/λ⊥d = {abs(prestress) / shear if shear else math.inf:.2g}",
            "tangents follow e₁ as far as this is small",
        ),
    ]


def _rate_lines(scene: Scene) -> list[Line]:
    d, count = scene.chain.spacing, scene.chain.particles
    waves = np.linspace(math.pi / (count * d), math.pi / d, WAVENUMBERS)
    rates = lattice_rates(scene, waves, frame="spinning")
    sizes = np.abs(rates)
    fastest, slowest = sizes.max(), sizes[sizes > 0].min() if sizes.any() else 0.0
    growth = rates.real.max(axis=1)
    best = int(np.argmax(growth))
    lines = [
        Line(
            "rates",
            f"{slowest:.2e} to {fastest:.2e}",
            f"a stiffness of {fastest * scene.run.end:.1e} over the run",
        )
    ]
    bending = rates[:, _BENDING].real
    decay = float(bending[0].max())
    lines.append(Line("longest wave", f"{decay:+.3e}", "growth rate of bending over the chain"))
    if growth[best] <= 0.0:
        lines.append(Line("growth", "none", "every wave decays"))
        return lines
    tens = growth[best] * scene.run.end / math.log(10)
    meaning = f"{tens:.3g} factors of ten by the end"
    if scene.start.shape != "straight" and 0.0 < scene.start.amplitude < d:
        large = math.log(d / scene.start.amplitude) / growth[best]
        meaning += f"; the start grows to the size of d by t = {large:.3g}"
    lines.append(Line("growth", f"{growth[best]:.3e} at qd = {waves[best] * d:.3g}", meaning))
    return lines


def _motion_lines(scene: Scene) -> list[Line]:
    velocity, rotation = steady_velocity(scene), steady_rotation(scene)
    lines = []
    if np.any(velocity):
        way = velocity[0] * scene.run.end / scene.chain.spacing
        lines.append(Line("swims", f"V₀ = {velocity[0]:.4g}", f"{way:.3g} spacings by the end"))
    if np.any(rotation):
        turns = rotation[0] * scene.run.end / (2.0 * math.pi)
        lines.append(Line("spins", f"Ω₀ = {rotation[0]:.4g}", f"{turns:.4g} turns by the end"))
    return lines


def _reach_lines(scene: Scene) -> list[Line]:
    if not scene.slip.modes or scene.slip.neighbours == "all":
        return []
    d = scene.chain.spacing
    wave = np.array([math.pi / (scene.chain.particles * d)])
    slack = {"elasticity.ratio": None, "elasticity.twist": 0.0, "elasticity.bend": 0.0}
    slack |= {"elasticity.stretch": 0.0, "elasticity.shear": 0.0}
    near, every = (
        lattice_rates(load_scene(scene, **slack, **{"slip.neighbours": reach}), wave)[0]
        for reach in (scene.slip.neighbours, "all")
    )
    left = np.abs(every - near).max() / max(float(np.abs(every).max()), 1e-300)
    return [
        Line(
            "reach",
            f"{100.0 * left:.3g} % left out",
            f"of the rates that slip gives the longest wave, beyond {scene.slip.neighbours} "
            "neighbours; slip.neighbours = 'all' keeps it",
        )
    ]


def _one_body(scene: Scene) -> Scene:
    return load_scene(scene, friction="one-body")
