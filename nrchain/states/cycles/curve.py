"""Orbits along a line of scenes, as a curve: z is all poses of a period, T and the drift.

A change is that of all stages and of the numbers γ, in one vector: (Σ_j η_j², γ²) is weighted with
the time that an orbit spends at each stage, in d and per sphere. All orbits of a curve have the
same intervals. The growth exponents are log μ/T of the multipliers that are not trivial.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nrchain.comoving.motions import fields
from nrchain.comoving.relative import RelativeChain
from nrchain.errors import SceneError
from nrchain.motion.integrators.radau_tableau import RUNGE_KUTTA
from nrchain.motion.model import Model
from nrchain.scene.scene import Scene
from nrchain.states.branches.curve import Corrected, Direction, unit
from nrchain.states.branches.events import PITCHFORK, TRANSCRITICAL
from nrchain.states.branches.steady import CURVATURE, DIFFERENCE, EVEN, carried
from nrchain.states.cycles.multipliers import multipliers, trivial_multipliers
from nrchain.states.cycles.newton import largest_change
from nrchain.states.cycles.orbit import Orbit
from nrchain.states.cycles.system import Change, Condensed, Row, System
from nrchain.states.newton import ACCEPTED, CONVERGED
from nrchain.states.search import refuse_poses_out_of_reach
from nrchain.states.varied import Line

DOUBLING, NEIMARK_SACKER = "period doubling", "Neimark–Sacker"

STEPS = 8
"""Most steps of Newton's method from a guess to a solution."""

LEAST = 1e-300
"""Multipliers below this have its exponent."""

ROUNDING = 1e-6
"""Angles of multipliers nearer to 0 and π than this are these angles."""


@dataclass(frozen=True, eq=False)
class Round:
    """A closed orbit, or a guess, where the first key of its line is p."""

    line: Line
    orbit: Orbit
    origin: np.ndarray
    value: float

    @cached_property
    def scene(self) -> Scene:
        """The scene at p."""
        return self.line.at(self.value)

    @cached_property
    def system(self) -> System:
        """The equations of the orbit."""
        chain = RelativeChain(self.scene, self.orbit.base(0), self.origin)
        return System(chain, self.orbit)

    @cached_property
    def condensed(self) -> Condensed:
        """Their factors, with p in parts of its range as a further number."""
        return Condensed(self.system, [self._slopes() * self.line.length])

    @cached_property
    def sizes(self) -> tuple[np.ndarray, float]:
        """Exponents, and the largest distance of trivial multipliers over T."""
        condensed, period = self.condensed, self.orbit.period
        trivial, neutral = trivial_multipliers(condensed)
        values = multipliers(condensed, neutral, self.system.chain.dimension)[0]
        found = np.log(np.where(np.abs(values) > LEAST, values, LEAST)) / period
        return found, trivial.error / period

    def _slopes(self) -> np.ndarray:
        """∂G/∂p (M, 3, n) at all stages, with the motion of the axes kept."""
        step = DIFFERENCE * self.line.length
        ends = [self._left_over(self.value + sign * step) for sign in (1.0, -1.0)]
        return (ends[0] - ends[1]) / (2.0 * step)

    def _left_over(self, value: float) -> np.ndarray:
        """w − g (M, 3, n) of a scene nearby."""
        scene, chain, orbit = self.line.at(value), self.system.chain, self.orbit
        model, found = Model(scene), []
        for pose in zip(orbit.positions, orbit.frames, strict=True):
            for stage in zip(*pose, strict=True):
                poses = carried(stage, self.scene, scene)
                elementary = fields(*poses, chain.origin, chain.length)
                motion = np.tensordot(orbit.elementary, elementary, 1)
                found.append(chain.coordinates(model.twists(*poses) - motion))
        return np.stack(found).reshape(orbit.count, 3, -1)


class CycleCurve:
    """Cycles along a line of scenes, as a :class:`~nrchain.states.branches.curve.Curve`."""

    def __init__(self, line: Line, widths: np.ndarray) -> None:
        self.line, self.widths = line, widths
        scene = line.at(line.low)
        self._weight = 1.0 / (scene.chain.particles * scene.chain.spacing**2)
        self._times = widths[:, None] * RUNGE_KUTTA[2]

    def at(self, orbit: Orbit, origin: np.ndarray, value: float) -> Round:
        """A guess with the intervals of the curve."""
        return Round(self.line, orbit.remeshed(self.widths), origin, float(value))

    def direction(self, change: Change, value: float) -> Direction:
        """A change as one vector, and that of p."""
        return Direction(np.concatenate([change.stages.ravel(), change.numbers]), value)

    def inner(self, first: Direction, second: Direction) -> float:
        """Mean product of displacements in d over the period, and that of p in its range."""
        changes = float((self._weights(first) * first.change) @ second.change)
        return changes + first.value * second.value / self.line.length**2

    def size(self, stages: np.ndarray) -> float:
        """Length of a change (M, 3, n) of all stages."""
        return math.sqrt(self._weight * float(np.einsum("kj,kjn->", self._times, stages**2)))

    def _weights(self, direction: Direction) -> np.ndarray:
        """Of every element of a change."""
        stages, numbers = self._parts(direction.change)
        times = np.broadcast_to(self._times[:, :, None], stages.shape)
        return self._weight * np.concatenate([times.ravel(), np.ones(len(numbers))])

    def _parts(self, change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Stages (M, 3, n) and numbers of a change."""
        each = 3 * len(self.widths)
        size = len(change) // each
        size -= size % 6
        return change[: each * size].reshape(-1, 3, size), change[each * size :]

    def moved(self, solution: Round, direction: Direction) -> Round:
        """All poses displaced and rotated, with another T, drift and p."""
        change = Change(*self._parts(direction.change))
        orbit, value = solution.system.changed(change), solution.value + direction.value
        scene = self.line.at(value)
        if scene.chain.spacing != solution.scene.chain.spacing:
            orbit = orbit_carried(orbit, solution.scene, scene)
        return Round(self.line, orbit, solution.origin, value)

    def corrected(self, guess: Round, direction: Direction) -> Corrected[Round]:
        """Newton's method across ``direction``."""
        spacing, size = self.line.scene.chain.spacing, math.inf
        across, total = unit(self, direction), direction.times(0.0)
        for steps in range(STEPS):
            step = self._solved(guess, across, guess.system.defects, 0.0)
            if not across.change.any():
                # p is given, to the last bit
                step = Direction(step.change, 0.0)
            total = Direction(total.change + step.change, total.value + step.value)
            before, size = size, self._size(guess, step)
            extent = max(float(np.ptp(guess.orbit.positions, axis=(0, 1, 2)).max()), spacing)
            if size <= CONVERGED * extent or (size <= ACCEPTED * spacing and size > 0.25 * before):
                away = math.sqrt(self.inner(total, total))
                return Corrected(self.moved(guess, step), steps + 1, size, away)
            if not size <= spacing or size > 2.0 * before:
                break
            guess = self.moved(guess, step)
        raise FloatingPointError(f"Newton's method leaves a correction of {size:.3g}")

    def _solved(
        self, solution: Round, across: Direction, defects: np.ndarray, length: float
    ) -> Direction:
        """The change that takes defects away, with a part ``length`` along a direction."""
        weights = self._weights(across) * across.change
        stages, numbers = self._parts(weights)
        corner = across.value / self.line.length
        row = Row(stages, np.append(numbers, corner))
        found = solution.condensed.solve(defects, [row], [-length])
        value = float(found.numbers[-1]) * self.line.length
        return self.direction(Change(found.stages, found.numbers[:-1]), value)

    def tangent(self, solution: Round, along: Direction) -> Direction:
        """The direction of the curve."""
        nothing = np.zeros_like(solution.system.defects)
        return unit(self, self._solved(solution, unit(self, along), nothing, 1.0))

    def exponents(self, solution: Round) -> np.ndarray:
        """log μ/T of all multipliers that are not trivial, from the largest real part on."""
        return solution.sizes[0]

    def noise(self, solution: Round) -> float:
        """The distance of the trivial multipliers from what they are, over T."""
        return solution.sizes[1]

    def is_real(self, solution: Round, exponent: complex) -> bool:
        """Whether the multiplier is positive."""
        return abs(exponent.imag) * solution.orbit.period <= ROUNDING

    def oscillation(self, solution: Round, exponent: complex) -> tuple[str, int]:
        """Period doubling where a multiplier is −1, Neimark–Sacker where a pair crosses."""
        if abs(abs(exponent.imag) * solution.orbit.period - math.pi) <= ROUNDING:
            return DOUBLING, 1
        return NEIMARK_SACKER, 2

    def branching(self, solution: Round, exponents: np.ndarray, multiplicity: int) -> str:
        """A pitchfork where ℓ·r(ε) is odd in ε: r of the orbit displaced along null vectors x."""
        condensed = solution.condensed
        neutral = trivial_multipliers(condensed)[1]
        size = len(condensed.monodromy)
        across = np.linalg.qr(neutral, mode="complete")[0][:, neutral.shape[1] :]
        own = across.T @ condensed.monodromy @ across
        u, _, v = np.linalg.svd(own - np.eye(size - neutral.shape[1]))
        right, left = across @ v[-multiplicity:].T, across @ u[:, -multiplicity:]
        change = condensed.spread(right.sum(axis=1))
        numbers = np.zeros(condensed.numbers - 1)
        direction = unit(self, self.direction(Change(change, numbers), 0.0)).times(CURVATURE)
        ends = [
            condensed.residual(self.moved(solution, direction.times(sign)).system.defects)
            for sign in (1.0, -1.0, 0.0)
        ]
        even = np.abs(left.T @ (ends[0] + ends[1] - 2.0 * ends[2])).max()
        return TRANSCRITICAL if even > EVEN * np.linalg.norm(ends[0] - ends[1]) else PITCHFORK

    def distance(self, first: Round, second: Round) -> float:
        """By positions, period and p."""
        away = second.orbit.positions - first.orbit.positions
        later = first.system.speed * (second.orbit.period - first.orbit.period)
        squares = float(np.einsum("kj,kjnp->", self._times, away**2)) + later**2
        value = (second.value - first.value) / self.line.length
        return math.sqrt(self._weight * squares + value**2)

    def gone(self, solution: Round) -> str:
        """Spheres that overlap, or a link that has turned by a quarter."""
        try:
            for pose in zip(*solution.orbit.bases(), strict=True):
                refuse_poses_out_of_reach(solution.scene, *pose)
        except SceneError as error:
            return f"{error.value}: {error.allowed}"
        return ""

    def _size(self, guess: Round, step: Direction) -> float:
        """The largest displacement, rotation times d, or part of the range of p times d."""
        change = Change(*self._parts(step.change))
        spacing = self.line.scene.chain.spacing
        return max(
            largest_change(guess.system, change), abs(step.value) / self.line.length * spacing
        )


def orbit_carried(orbit: Orbit, before: Scene, after: Scene) -> Orbit:
    """An orbit for a scene with another spacing."""
    positions = orbit.positions.copy()
    for k, row in enumerate(orbit.positions):
        for j, one in enumerate(row):
            positions[k, j] = carried((one, orbit.frames[k, j]), before, after)[0]
    return Orbit(orbit.period, orbit.elementary, orbit.widths, positions, orbit.frames)
