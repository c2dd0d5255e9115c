"""X* ⊕ ε Re(x exp(2πi s)), T = 2π/ω: the orbits that leave a Hopf point.

A straight chain may oscillate in any plane at one frequency, if its law does not prefer one. The
modes of a Hopf point are then two, and the orbits that leave are oscillations along a line (in y,
or between y and z) and those that go round.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from nrchain.comoving.dense import all_rates
from nrchain.motion.integrators.radau_tableau import NODES
from nrchain.states.branches.curve import Direction
from nrchain.states.branches.steady import Steady, critical_vectors
from nrchain.states.cycles.curve import CycleCurve, Round
from nrchain.states.cycles.orbit import Orbit
from nrchain.states.cycles.system import Change, displaced

AWAY = 0.02, 0.01, 0.04
"""ε that are tried: mean displacement of a sphere, in d."""

ALIKE = 0.9
"""Least cosine between displacements of an orbit and of its mode."""

SAME = 1e-2
"""Orbits whose distances in p, and of multipliers from 1, differ by less than this fraction are
images of each other."""

COMPARED = 3
"""Leading multipliers that are compared."""


def orbits_leaving(
    curve: CycleCurve, state: Steady, frequency: float, multiplicity: int
) -> list[tuple[Round, Direction]]:
    """The first orbit of each branch that leaves a Hopf point, and the direction it goes on in."""
    found: list[tuple[Round, Direction]] = []
    begin = _still(curve, state, frequency)
    for vector in _vectors(state, multiplicity):
        start = next(
            (one for one in (_start(curve, begin, vector, away) for away in AWAY) if one), None
        )
        if start is not None and not any(
            _same(curve, start[0], other, state.value) for other, _ in found
        ):
            found.append(start)
    return found


def _still(curve: CycleCurve, state: Steady, frequency: float) -> Round:
    """The state as an orbit of the period of its mode."""
    point, count = state.point, len(curve.widths)
    positions = np.broadcast_to(point.positions, (count, 3, *point.positions.shape)).copy()
    frames = np.broadcast_to(point.frames, (count, 3, *point.frames.shape)).copy()
    period = 2.0 * math.pi / frequency
    orbit = Orbit(period, point.elementary, curve.widths, positions, frames)
    return Round(curve.line, orbit, point.chain.origin, state.value)


def _vectors(state: Steady, multiplicity: int) -> Iterator[np.ndarray]:
    """Complex modes (n,), from which orbits may leave."""
    rates = all_rates(state.point)
    vectors, _ = critical_vectors(state, rates, multiplicity, turning=True)
    if len(vectors) != 2:
        yield from vectors[:1]
        return
    first, second = _along_axes(state, vectors)
    yield first
    yield first + second
    yield first + 1j * second


def _along_axes(state: Steady, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Modes of the same plane in phase, with displacements along y, and along z."""
    across = np.stack([state.point.chain.poses(vector)[:, 1:3] for vector in vectors])
    place = int(np.abs(across).sum(axis=(0, 2)).argmax())
    # the combinations whose displacement of one sphere is a unit along y, and along z
    mixed = np.linalg.solve(across[:, place].T, np.eye(2))
    first, second = mixed.T @ vectors
    return first, second


def _start(
    curve: CycleCurve, begin: Round, vector: np.ndarray, away: float
) -> tuple[Round, Direction] | None:
    """The orbit X* ⊕ ε Re(x exp(2πi s)) leads to, and the way on; None if none is found."""
    orbit, chain = begin.orbit, begin.system.chain
    fractions = orbit.starts[:, None] + curve.widths[:, None] * NODES
    stages = (np.exp(2j * math.pi * fractions)[:, :, None] * vector).real
    stages /= curve.size(stages)
    try:
        positions, frames = displaced(chain, orbit, away * stages)
        guess = replace(begin, orbit=replace(orbit, positions=positions, frames=frames))
        numbers = np.zeros(1 + guess.system.motions.shape[1])
        direction = curve.direction(Change(stages, numbers), 0.0)
        found = curve.corrected(guess, direction)
        tangent = curve.tangent(found.solution, direction)
    except (FloatingPointError, np.linalg.LinAlgError):
        return None
    before, after = guess.orbit.excursions.ravel(), found.solution.orbit.excursions.ravel()
    alike = before @ after >= ALIKE * np.linalg.norm(before) * np.linalg.norm(after)
    return (found.solution, tangent) if alike else None


def _same(curve: CycleCurve, one: Round, other: Round, onset: float) -> bool:
    """Whether two orbits are images of each other: their p and multipliers leave alike."""
    sizes = [curve.exponents(each)[:COMPARED] * each.orbit.period for each in (one, other)]
    first, second = np.exp(sizes[0]), np.exp(sizes[1])
    alike = abs(one.value - other.value) <= SAME * abs(one.value - onset)
    return alike and bool(np.abs(first - second).max() <= SAME * np.abs(first - 1.0).max())
