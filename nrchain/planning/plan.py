"""What the numbers of a scene foretell: its loads, its growth, its motion, its start.

The finite chain is judged as it is, about its own straight state
(:mod:`nrchain.planning.soundness`). Rates of the infinite straight chain (:mod:`nrchain.lattice`),
for waves between one over the chain and two spheres long, stand beside them as a comparison, where
one strength holds for all spheres. Nothing is run.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nrchain.effects.shared.image_sums import net_forces, takes_all
from nrchain.errors import SceneError
from nrchain.geometry.near_pairs import closest_pair
from nrchain.motion.definiteness import is_cut, least_mobility
from nrchain.planning.flow_reach import reach_of_strain
from nrchain.planning.regime import judged, rounding_drift, warnings
from nrchain.planning.soundness import LARGEST_STRAIN, LARGEST_TURN, Judgement, bond_loads
from nrchain.planning.start import starting_poses
from nrchain.scene.scene import Scene, load_scene
from nrchain.theory.lattice import (
    Branch,
    chain_waves,
    lattice_rates,
    steady_rotation,
    steady_velocity,
)
from nrchain.theory.straight_growth import REACH, StraightGrowth
from nrchain.watch.seed import seed_amplitude
from nrchain.wording import brief, span

_BENDING = [Branch.BEND_PLUS, Branch.BEND_MINUS]

_OF_THE_INFINITE = "of the infinite chain"


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

    __repr__ = brief


def plan(scene: Scene) -> Plan:
    """What becomes of the chain of a scene, from its numbers alone.

    What needs a straight chain that stays one is left out where the scene has none, and says so.
    Raises :class:`~nrchain.errors.SceneError` for a start that a run would refuse.
    """
    positions, frames = starting_poses(scene)
    lines = [_start_line(scene, positions)]
    if is_cut(scene):
        lines.append(_mobility_line(scene, positions))
    found = judged(scene)
    if isinstance(found, Judgement):
        lines += [*_load_lines(scene, found), *_motion_lines(scene, found)]
        lines += _growth_lines(scene, found, seed_amplitude(scene, positions, frames))
    else:
        lines.append(Line("chain", "not judged", str(found)))
    for part in (_wave_lines, _reach_lines):
        lines += _compared(part, scene)
    lines += [Line(*row) for row in reach_of_strain(scene, positions)]
    drift = rounding_drift(scene)
    lines.append(Line("rounding", f"{drift:.1e}", "position drift from rounding, per unit time"))
    return Plan(lines, warnings(scene, found))


def _compared(part: Callable[[Scene], list[Line]], scene: Scene) -> list[Line]:
    """The lines of one part, or why there are none."""
    name = part.__name__.removeprefix("_").removesuffix("_lines")
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            return part(scene)
    except SceneError as error:
        return [Line(name, "not compared", f"plane waves do not tell: {error}")]
    except FloatingPointError as error:
        return [Line(name, "not compared", f"beyond the range of floats: {error}")]


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


def _load_lines(scene: Scene, found: Judgement) -> list[Line]:
    """What the links carry, and how far that strains them."""
    straight = found.loads.tension
    most = int(np.argmax(np.abs(straight)))
    lines = [Line("tension", "0", "no link of the straight chain carries a force")]
    if straight[most]:
        meaning = "the largest of the straight chain; positive where a link pulls"
        lines = [Line("tension", f"{straight[most]:.4g} in link {most}", meaning)]
    for load in bond_loads(scene, found.carried):
        ratio = math.copysign(load.strain, load.tension)
        held = f"{load.tension:.3g}/{load.stiffness:.3g} = {ratio:.2g}"
        if not load.tension:
            meaning = "no tension strains the bonds"
        elif load.holds:
            meaning = f"in the beam limit, to which up to {LARGEST_STRAIN:g} belongs"
        else:
            meaning = f"out of the beam limit, to which up to {LARGEST_STRAIN:g} belongs"
        if found.carried is not found.loads and load.tension:
            meaning += "; as much as bends may bring about"
        lines.append(Line(load.name, f"tension/{load.symbol} = {held}", meaning))
    moment = float(np.abs(found.carried.moment).max())
    if moment:
        twist = float(np.abs(found.state.turns).max())
        meaning = f"the largest about the chain; links of the straight one twist by {twist:.2g} rad"
        lines.append(Line("moment", f"{moment:.4g}", meaning))
    return lines


def _growth_lines(scene: Scene, found: Judgement, seed: float) -> list[Line]:
    """How the finite chain leaves its straight state."""
    growth = found.growth
    if growth is None:
        meaning = f"the straight chain goes on until t = {found.state.time:.3g} only"
        return [Line("growth", "not judged", meaning)]
    cut = f"; judged with one-body friction and slip of {REACH} places at most"
    across, part = growth.across, "" if growth.whole else cut
    if not across.rate and not growth.along.rate:
        return [Line("growth", "none", f"the straight state of this chain decays to{part}")]
    if not across.rate:
        return [Line("growth", f"{growth.along.rate:.3e}", f"of stretch along the chain{part}")]
    lines = [Line("growth", f"{across.rate:.3e}", _growth_meaning(scene, growth, seed) + part)]
    if found.bends:
        meaning = f"at slopes of 1 of the bend that grows; links hold up to {LARGEST_TURN:g} rad"
        lines.append(Line("turns", f"of {across.phase:.2g} rad a link", meaning))
    return lines


def _growth_meaning(scene: Scene, growth: StraightGrowth, seed: float) -> str:
    rate = growth.across.rate
    meaning = f"of bends of this chain: {rate * scene.run.end / math.log(10):.3g} factors of ten"
    offset = seed * scene.chain.radius
    if 0.0 < offset < scene.chain.spacing:
        large = math.log(scene.chain.spacing / offset) / rate
        meaning += f" by the end; the start grows to the size of d by t = {large:.3g}"
    return meaning


def _motion_lines(scene: Scene, found: Judgement) -> list[Line]:
    """How the straight chain swims and spins, and the infinite one."""
    velocity, spin, end = found.loads.velocity, found.loads.spin, scene.run.end
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


def _wave_lines(scene: Scene) -> list[Line]:
    """The laws of the infinite chain, to compare with those of this one."""
    waves, end = chain_waves(scene), scene.run.end
    rates = lattice_rates(scene, waves, frame="spinning")
    sizes, growth = np.abs(rates), rates.real.max(axis=1)
    fastest, slowest = sizes.max(), sizes[sizes > 0].min() if sizes.any() else 0.0
    stiffness = f"a stiffness of {fastest * end:.1e} over the run"
    bending = float(rates[0, _BENDING].real.max())
    best = int(np.argmax(growth))
    grows = Line("waves: growth", "none", f"every wave {_OF_THE_INFINITE} decays")
    if growth[best] > 1e-12 * fastest:
        at = f"{growth[best]:.3e} at qd = {waves[best] * scene.chain.spacing:.3g}"
        grows = Line("waves: growth", at, f"of the fastest wave {_OF_THE_INFINITE}")
    lines = [
        Line(
            "waves: rates",
            span(f"{slowest:.2e}", f"{fastest:.2e}"),
            f"|Λ| of the slowest and the fastest wave {_OF_THE_INFINITE}; {stiffness}",
        ),
        Line("waves: longest", f"{bending:+.3e}", f"growth of bending {_OF_THE_INFINITE}"),
        grows,
    ]
    velocity, spin = steady_velocity(scene)[0], steady_rotation(scene)[0]
    if velocity:
        lines.append(Line("waves: swims", f"V₀ = {velocity:.4g}", _OF_THE_INFINITE))
    if spin:
        lines.append(Line("waves: spins", f"Ω₀ = {spin:.4g}", _OF_THE_INFINITE))
    return lines


def _reach_lines(scene: Scene) -> list[Line]:
    """What lies beyond the neighbours that count, of the rates of the infinite chain."""
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
                f"of the rates that slip gives the longest wave {_OF_THE_INFINITE}, beyond "
                f"{slip.neighbours} a side; slip.neighbours = 'all' keeps it",
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
                f"of the passive decay of the longest bending wave {_OF_THE_INFINITE}, beyond "
                f"{friction.neighbours} a side"
                + ("; friction.neighbours = 'all' keeps it" if takes_all(scene) else ""),
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
