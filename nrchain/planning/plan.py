"""What the numbers of a scene say about its run: loads, growth, motion and start. Nothing is run.

The finite chain is judged about its own straight state (:mod:`nrchain.planning.soundness`). Rates
of the infinite straight chain (:mod:`nrchain.planning.plan_waves`) stand beside it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.effects.shared.image_sums import takes_all
from nrchain.geometry.near_pairs import closest_pair
from nrchain.motion.definiteness import CutFriction, is_cut
from nrchain.notebook import table_html
from nrchain.planning.checked_start import starting_poses
from nrchain.planning.pair_sums import pair_sum_errors
from nrchain.planning.plan_line import Line
from nrchain.planning.plan_waves import wave_lines
from nrchain.planning.regime import rounding_drift, try_judge, warnings
from nrchain.planning.soundness import Judgement
from nrchain.planning.strain_reach import strain_reach_rows
from nrchain.planning.weaknesses import LARGEST_STRAIN, LARGEST_TURN, bond_loads
from nrchain.scene.scene import Scene
from nrchain.theory.straight_growth import REACH, StraightGrowth
from nrchain.watch.seed import seed_amplitude
from nrchain.wording import brief

ROUNDING = 1e-12
"""A motion below this part of what the largest load would give one sphere is rounding."""


@dataclass(frozen=True)
class Plan:
    """What a scene will do, line by line, with warnings."""

    lines: list[Line]
    warnings: list[str]

    __repr__ = brief

    def _repr_html_(self) -> str:
        rows = [(line.quantity, line.value, line.meaning) for line in self.lines]
        rows += [("warning", "", text) for text in self.warnings]
        return table_html("Plan", rows, ("quantity", "value", "meaning"))


def plan(scene: Scene) -> Plan:
    """What the chain of a scene will do, from its numbers alone.

    Lines that need a straight chain say so where the chain does not stay straight.
    Raises :class:`~nrchain.errors.SceneError` for a start that a run would refuse.
    """
    positions, frames = starting_poses(scene)
    lines = [_units_line(scene), _start_line(scene, positions)]
    lines += [error.line() for error in pair_sum_errors(scene, positions, frames)]
    if is_cut(scene):
        lines.append(_mobility_line(scene, positions))
    found = try_judge(scene)
    if isinstance(found, Judgement):
        lines += [*_load_lines(scene, found), *_motion_lines(scene, found)]
        lines += _growth_lines(scene, found, seed_amplitude(scene, positions, frames))
    else:
        lines.append(Line("chain", "not judged", str(found)))
    lines += wave_lines(scene)
    lines += [Line(*row) for row in strain_reach_rows(scene, positions)]
    drift = rounding_drift(scene)
    lines.append(
        Line(
            "rounding",
            f"drift = {drift:.1e}",
            "velocity of a sphere from the rounding of positions",
        )
    )
    return Plan(lines, warnings(scene, found))


def _units_line(scene: Scene) -> Line:
    return Line(
        "units",
        f"a = {scene.chain.radius:g}, η = {scene.chain.viscosity:g}",
        "every number is in the units of the scene, with radius a and viscosity η",
    )


def _mobility_line(scene: Scene, positions: np.ndarray) -> Line:
    return Line(
        "friction",
        f"least mobility = {CutFriction(scene).least_mobility(positions):.2g}",
        "mobility of the wrench that moves the start least, over that of one sphere; it must stay "
        "positive as the chain moves"
        + (", as it always is with friction.neighbours = 'all'" if takes_all(scene) else ""),
    )


def _start_line(scene: Scene, positions: np.ndarray) -> Line:
    distance, i, j = closest_pair(positions, scene.period)
    ratio = scene.chain.radius / min(distance, scene.chain.spacing)
    return Line(
        "closest approach",
        f"r = {distance / scene.chain.radius:.4g} a",
        f"spheres {i} and {j} at the start; the pair laws leave out terms of order"
        f" (a/r)² = {ratio**2:.1g}",
    )


def _load_lines(scene: Scene, found: Judgement) -> list[Line]:
    """The loads of the links, and how far they strain the bonds."""
    straight = found.loads.tension
    most = int(np.argmax(np.abs(straight)))
    lines = [Line("tension", "T = 0", "no link of the straight chain carries a force")]
    if straight[most]:
        meaning = "the largest force in a link of the straight chain; positive if the link pulls"
        lines = [Line("tension", f"T = {straight[most]:.4g} in link {most}", meaning)]
    for load in bond_loads(scene, found.carried):
        ratio = math.copysign(load.strain, load.tension)
        held = f"{load.tension:.3g}/{load.stiffness:.3g} = {ratio:.2g}"
        if not load.tension:
            meaning = "no tension strains the bonds"
        elif load.holds:
            meaning = f"in the beam limit, which reaches up to {LARGEST_STRAIN:g}"
        else:
            meaning = f"out of the beam limit, which reaches up to {LARGEST_STRAIN:g}"
        if found.carried is not found.loads and load.tension:
            meaning += "; the largest that bends may cause"
        lines.append(Line(load.name, f"T/{load.symbol} = {held}", meaning))
    moment = float(np.abs(found.carried.moment).max())
    if moment:
        twist = float(np.abs(found.state.turns).max())
        meaning = (
            f"the largest moment of a link; links of the straight chain twist by {twist:.2g} rad"
        )
        lines.append(Line("moment", f"M = {moment:.4g}", meaning))
    return lines


def _growth_lines(scene: Scene, found: Judgement, seed: float) -> list[Line]:
    """How bends of the finite chain grow."""
    growth = found.growth
    if growth is None:
        meaning = f"the chain is straight until t = {found.state.time:.3g} only"
        return [Line("growth", "not judged", meaning)]
    cut = f"; judged with one-body friction and slip of at most {REACH} neighbours"
    across, part = growth.across, "" if growth.whole else cut
    if not across.rate and not growth.along.rate:
        return [Line("growth", "none", f"the straight state of this chain is stable{part}")]
    if not across.rate:
        meaning = f"growth rate of stretch along the chain{part}"
        return [Line("growth", f"Re Λ = {growth.along.rate:.3e}", meaning)]
    lines = [
        Line("growth", f"Re Λ = {across.rate:.3e}", _growth_meaning(scene, growth, seed) + part)
    ]
    if found.bends:
        meaning = f"when the bend reaches slopes of 1; links hold up to {LARGEST_TURN:g} rad"
        lines.append(Line("turns", f"{across.phase:.2g} rad a link", meaning))
    return lines


def _growth_meaning(scene: Scene, growth: StraightGrowth, seed: float) -> str:
    rate = growth.across.rate
    meaning = (
        f"growth rate of bends: {rate * scene.run.end / math.log(10):.3g} factors of ten by the end"
    )
    offset = seed * scene.chain.radius
    if 0.0 < offset < scene.chain.spacing:
        large = math.log(scene.chain.spacing / offset) / rate
        meaning += f"; the start grows to the size of d by t = {large:.3g}"
    return meaning


def _motion(scene: Scene, found: Judgement) -> tuple[np.ndarray, float]:
    """V (3,) and Ω of the straight chain; 0 where only the rounding of its loads is left."""
    loads, drag = found.loads, scene.drag
    least = ROUNDING * np.abs(loads.tension).max() / drag.translation
    least_spin = ROUNDING * np.abs(loads.moment).max() / drag.rotation
    velocity = np.where(np.abs(loads.velocity) > least, loads.velocity, 0.0)
    return velocity, loads.spin if abs(loads.spin) > least_spin else 0.0


def _motion_lines(scene: Scene, found: Judgement) -> list[Line]:
    """How the straight chain swims and spins."""
    velocity, spin = _motion(scene, found)
    end = scene.run.end
    lines = []
    if velocity.any():
        along = f"{velocity[0]:.4g}"
        across = f"({along}, {velocity[1]:.4g}, {velocity[2]:.4g})"
        way = float(np.linalg.norm(velocity)) * end / scene.chain.spacing
        text = f"V = {across if velocity[1:].any() else along}"
        lines.append(Line("swims", text, f"{way:.3g} spacings by the end"))
    if scene.chain.ends == "clamped":
        lines.append(Line("spins", "Ω = 0", "its ends are held"))
    else:
        turns = spin * end / (2.0 * math.pi)
        lines.append(Line("spins", f"Ω = {spin:.4g}", f"{turns:.4g} turns by the end"))
    return lines
