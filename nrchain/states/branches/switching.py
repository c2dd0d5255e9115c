"""X* ⊕ ε v: the branches of states that leave a branch point, or a Hopf point with rotations.

At a branch point J has null vectors v. A solution with a part ε along one of them, and any p, lies
on another branch. A rate of two null vectors comes from a symmetry, such as rotations about x:
branches leave along some directions of their plane, and those that a symmetry maps to each other
have the same rates and are taken once.

At a Hopf point of a straight chain of isotropic measure the modes may be taken as rotating ones,
u_z = ±i u_y. Such a wave is a shape that goes round steadily, which is a state.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from nrchain.states.branches.curve import Direction, unit
from nrchain.states.branches.events import HOPF, Event
from nrchain.states.branches.steady import Steady, SteadyCurve, critical_vectors

AWAY = tuple(0.02 * 0.5**k for k in range(7))
"""ε that are tried, in the units of the curve: displacements in d. p − p* grows as ε²."""

ANGLES = 4
"""Directions that are tried in a quarter of the plane of two null vectors."""

SAME = 1e-5
"""Solutions whose rates differ by less than this fraction are images of each other."""

COMPARED = 6
"""Leading rates that are compared."""


class Start(NamedTuple):
    """The first solution of a new branch, the direction in which it leaves, and leading rates."""

    solution: Steady
    direction: Direction
    rates: np.ndarray


def leaving(curve: SteadyCurve, event: Event[Steady]) -> list[Start]:
    """The starts of the branches that leave an event, one of each set of images."""
    directions = list(_directions(curve, event))
    best: list[Start] = []
    for away in AWAY:
        tried = [_start(curve, event.place.solution, one, away) for one in directions]
        starts = [start for start in tried if start is not None]
        if len(starts) > len(best):
            best = starts
        if len(best) == len(directions):
            break
    found: list[Start] = []
    for start in best:
        if not any(_same(curve, start, other, event) for other in found):
            found.append(start)
    return found


def _directions(curve: SteadyCurve, event: Event[Steady]) -> Iterator[Direction]:
    """Changes of shape of length 1 along which branches may leave."""
    place = event.place
    vectors, _ = critical_vectors(
        place.solution, place.exponents, event.multiplicity, turning=event.kind == HOPF
    )
    if event.kind == HOPF:
        if len(vectors) == 2:
            vectors = _rotating(event.place.solution, vectors)
            yield from (unit(curve, Direction(v.real.copy(), 0.0)) for v in vectors)
        return
    if len(vectors) == 1:
        yield from (unit(curve, Direction(sign * vectors[0].real, 0.0)) for sign in (1.0, -1.0))
    if len(vectors) == 2:
        first, second = _along_axes(event.place.solution, vectors.real)
        for angle in 0.5 * math.pi * np.arange(4 * ANGLES) / ANGLES:
            mixed = math.cos(angle) * first + math.sin(angle) * second
            yield unit(curve, Direction(mixed, 0.0))


def _along_axes(solution: Steady, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same plane of null vectors; the first has its displacements along y as far as it can."""
    across = [solution.point.chain.poses(vector)[:, 1] for vector in vectors]
    gram = np.array([[a @ b for b in across] for a in across])
    _, turned = np.linalg.eigh(gram)
    return turned[:, 1] @ vectors, turned[:, 0] @ vectors


def _rotating(solution: Steady, vectors: np.ndarray) -> np.ndarray:
    """The combinations of two modes that a rotation about x multiplies by a phase."""
    chain = solution.point.chain
    columns = []
    for vector in vectors:
        poses = chain.poses(vector)
        turned = np.zeros_like(poses)
        for part in (slice(0, 3), slice(3, 6)):
            turned[:, part] = np.cross([1.0, 0.0, 0.0], poses[:, part])
        columns.append(chain.coordinates(turned))
    generator = np.linalg.lstsq(vectors.T, np.array(columns).T, rcond=None)[0]
    _, mixed = np.linalg.eig(generator)
    return mixed.T @ vectors


def _start(curve: SteadyCurve, begin: Steady, direction: Direction, away: float) -> Start | None:
    """The solution a little along a direction; None if none is found."""
    try:
        guess = curve.moved(begin, direction.times(away))
        solution, _, _, moved = curve.corrected(guess, direction)
        tangent = curve.tangent(solution, direction)
    except FloatingPointError:
        return None
    if moved > away:
        return None
    return Start(solution, tangent, curve.exponents(solution)[:COMPARED])


def _same(curve: SteadyCurve, one: Start, other: Start, event: Event[Steady]) -> bool:
    """Whether two starts have the same p and the same rates."""
    scale = abs(one.solution.value - event.value)
    if abs(one.solution.value - other.solution.value) > 1e-3 * scale + event.error:
        return False
    rounding = 10.0 * curve.noise(one.solution)
    return bool(np.all(np.abs(one.rates - other.rates) <= SAME * np.abs(one.rates) + rounding))
