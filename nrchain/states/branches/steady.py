"""G(X, p) = 0: states of rest and of steady motion along a line of scenes.

A step of Newton's method solves J δ + Q m + G_p q = −G with Qᵀ δ = 0 and no part along a given
direction (δ₀, q₀), so that folds are passed. G_p is a central difference between scenes. Poses that
go with another p are stretched along x if the spacing varies and held spheres or the period tie the
chain to it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.comoving import dense, krylov
from nrchain.comoving.bordered import Bordered, Edge
from nrchain.comoving.motions import fields, moved
from nrchain.comoving.relative import Point, RelativeChain
from nrchain.errors import SceneError
from nrchain.motion.model import Model
from nrchain.scene.scene import Scene
from nrchain.states.branches.curve import Corrected, Direction, unit
from nrchain.states.branches.events import BRANCHING, HOPF, PITCHFORK, TRANSCRITICAL
from nrchain.states.modes import NOISE, modes_of
from nrchain.states.newton import ACCEPTED, CONVERGED, SteadyState, largest_change
from nrchain.states.search import refuse_out_of_reach
from nrchain.states.varied import Line
from nrchain.types import Poses

STEPS = 8
"""Most steps of Newton's method from a guess to a solution."""

DIFFERENCE = 1e-4
"""Change of p, as a part of its range, by which G_p is found."""

DENSE = 120
"""Spheres of the longest chain of which all rates are computed at every solution."""

LEADING = 12
"""Rates of longer chains."""


CURVATURE, EVEN = 1e-3, 1e-4
"""Displacement, in d, by which the even part of G is found, and the fraction of it, along the null
vectors, above which a branch point is transcritical."""

REAL = 1e3
"""A frequency below so many times the rounding of rates is none."""


@dataclass(frozen=True, eq=False)
class Steady:
    """A chain in a state, or close to one, where the first key of its line is p."""

    point: Point
    value: float

    @property
    def scene(self) -> Scene:
        """The scene at p."""
        return self.point.chain.scene


class SteadyCurve:
    """States along a line of scenes, as a :class:`~nrchain.states.branches.curve.Curve`."""

    def __init__(self, line: Line) -> None:
        self.line = line
        scene = line.at(line.low)
        self._weight = 1.0 / (scene.chain.particles * scene.chain.spacing**2)

    def at(self, poses: Poses, value: float) -> Steady:
        """A guess with these poses."""
        return Steady(RelativeChain(self.line.at(value), poses).at(poses), float(value))

    def inner(self, first: Direction, second: Direction) -> float:
        """Mean product of displacements in d, plus that of p in the length of its range."""
        changes = self._weight * float(first.change @ second.change)
        return changes + first.value * second.value / self.line.length**2

    def moved(self, solution: Steady, direction: Direction) -> Steady:
        """Poses displaced and rotated, at another p."""
        value = solution.value + direction.value
        scene = self._scene(value) if direction.value else solution.scene
        poses = moved(
            *carried(solution.point.poses, solution.scene, scene),
            solution.point.chain.poses(direction.change),
        )
        if not direction.value:
            return Steady(solution.point.chain.at(poses), value)
        return Steady(RelativeChain(scene, poses).at(poses), value)

    def corrected(self, guess: Steady, direction: Direction) -> Corrected[Steady]:
        """Newton's method across ``direction``; see :mod:`nrchain.states.newton` for its end."""
        spacing, size = self.line.scene.chain.spacing, math.inf
        across, total = unit(self, direction), direction.times(0.0)
        for steps in range(STEPS):
            factors = Bordered(guess.point, by_products=True, edge=self._edge(guess, across))
            step = Direction(*factors.solve_with(-guess.point.residual, 0.0))
            if not across.change.any():
                # p is given, to the last bit
                step = Direction(step.change, 0.0)
            total = Direction(total.change + step.change, total.value + step.value)
            before, size = size, self._size(guess, step)
            extent = max(float(np.ptp(guess.point.positions, axis=0).max()), spacing)
            if size <= CONVERGED * extent or (size <= ACCEPTED * spacing and size > 0.25 * before):
                away = math.sqrt(self.inner(total, total))
                return Corrected(self.moved(guess, step), steps + 1, size, away)
            if not size <= spacing or size > 2.0 * before:
                break
            guess = self.moved(guess, step)
        raise FloatingPointError(f"Newton's method leaves a correction of {size:.3g}")

    def tangent(self, solution: Steady, along: Direction) -> Direction:
        """The null vector of [J, G_p] without motions as a whole."""
        across = unit(self, along)
        edge = self._edge(solution, across)
        factors = Bordered(solution.point, by_products=True, edge=edge)
        return unit(self, Direction(*factors.solve_with(np.zeros(len(edge.column)), 1.0)))

    def exponents(self, solution: Steady) -> np.ndarray:
        """The rates: all of them for up to :data:`DENSE` spheres, else the leading ones."""
        point = solution.point
        if point.chain.model.count <= DENSE:
            return dense.all_rates(point)
        return krylov.leading_rates(point, LEADING, krylov.numerical_abscissa(point))

    def is_real(self, solution: Steady, exponent: complex) -> bool:
        """Whether a frequency is rounding."""
        return abs(exponent.imag) <= REAL * self.noise(solution)

    def oscillation(self, solution: Steady, exponent: complex) -> tuple[str, int]:
        """A Hopf point: pairs cross."""
        return HOPF, 2

    def branching(self, solution: Steady, exponents: np.ndarray, multiplicity: int) -> str:
        """A pitchfork where ℓ·G(X ⊕ εx) is odd in ε for the null vectors x and ℓ."""
        try:
            right, left = critical_vectors(solution, exponents, multiplicity, turning=False)
        except (FloatingPointError, np.linalg.LinAlgError):
            return BRANCHING
        direction = unit(self, Direction(right.real.sum(axis=0), 0.0)).times(CURVATURE)
        ends = [self.moved(solution, direction.times(sign)).point.residual for sign in (1.0, -1.0)]
        even = np.abs(left @ (ends[0] + ends[1])).max()
        size = np.linalg.norm(ends[0] + ends[1]) * np.linalg.norm(left, axis=1).max()
        return TRANSCRITICAL if even > EVEN * size else PITCHFORK

    def distance(self, first: Steady, second: Steady) -> float:
        """By positions and p."""
        away = second.point.positions - first.point.positions
        value = (second.value - first.value) / self.line.length
        return math.sqrt(self._weight * float(np.sum(away**2)) + value**2)

    def noise(self, solution: Steady) -> float:
        """Rounding of rates, by the size of the entries of J."""
        return NOISE * float(abs(solution.point.near).sum(axis=0).max(initial=0.0))

    def gone(self, solution: Steady) -> str:
        """Spheres that overlap, or a link that has turned by a quarter."""
        try:
            refuse_out_of_reach(solution.scene, steady_state(solution, 0, 0.0))
        except SceneError as error:
            return f"{error.value}: {error.allowed}"
        return ""

    def _edge(self, solution: Steady, across: Direction) -> Edge:
        """∂G/∂p, and the row of ⟨across, ·⟩."""
        row = self._weight * across.change
        return Edge(self._slope(solution), row, across.value / self.line.length**2)

    def _slope(self, solution: Steady) -> np.ndarray:
        """∂G/∂p (n,) with the motion as a whole kept; from one side at the ends of the range."""
        step, value = DIFFERENCE * self.line.length, solution.value
        sides = [side for side in (value + step, value - step) if self.line.holds(side)]
        first, second = sides if len(sides) == 2 else (*sides, value, value)[:2]
        if first == second:
            raise FloatingPointError(f"{value:.6g} is beyond the range")
        ends = [self._left_over(solution, side) for side in (first, second)]
        return (ends[0] - ends[1]) / (first - second)

    def _scene(self, value: float) -> Scene:
        """The scene at p; a step that leaves what a scene allows is too long."""
        try:
            return self.line.at(value)
        except SceneError as error:
            raise FloatingPointError(str(error)) from None

    def _left_over(self, solution: Steady, value: float) -> np.ndarray:
        """w − g (n,) of a scene nearby, in the coordinates of the solution."""
        point, scene = solution.point, self._scene(value)
        poses = carried(point.poses, solution.scene, scene)
        chain = point.chain
        elementary = fields(*poses, chain.origin, chain.length)
        motion = np.tensordot(point.elementary, elementary, 1)
        return chain.coordinates(Model(scene).twists(*poses) - motion)

    def _size(self, guess: Steady, step: Direction) -> float:
        """The largest displacement, or rotation times d, or part of the range of p, times d."""
        spacing = self.line.scene.chain.spacing
        return max(
            largest_change(guess.point, step.change),
            abs(step.value) / self.line.length * spacing,
        )


def critical_vectors(
    solution: Steady, exponents: np.ndarray, multiplicity: int, *, turning: bool
) -> tuple[np.ndarray, np.ndarray]:
    """(m, n) right and left modes of the rates that cross: those nearest to 0, or to the axis.

    ``turning`` rates are pairs, of which the one with Im Λ > 0 is taken.
    """
    chosen = exponents[exponents.imag > 0.0] if turning else exponents
    order = np.argsort(np.abs(chosen.real if turning else chosen), kind="stable")
    chosen = chosen[order[:multiplicity]]
    # the fastest rate sets what is rounding
    fastest = exponents[np.abs(exponents).argmax()]
    counted = (2 if turning else 1) * len(chosen)
    modes = modes_of(solution.point, np.append(chosen, fastest), counted)
    nearest = sorted(modes, key=lambda mode: abs(mode.growth if turning else mode.rate))
    right, left = (np.hstack([mode.vectors[k] for mode in nearest]).T for k in (0, 1))
    return right[:multiplicity], left[:multiplicity]


def carried(poses: Poses, before: Scene, after: Scene) -> Poses:
    """Poses for a scene with another spacing: stretched along x where ends or period are tied."""
    positions, frames = poses
    ratio = after.chain.spacing / before.chain.spacing
    if ratio == 1.0 or before.chain.ends == "free":
        return poses
    positions = positions.copy()
    positions[:, 0] = positions[0, 0] + ratio * (positions[:, 0] - positions[0, 0])
    return positions, frames


def steady_state(solution: Steady, steps: int, error: float) -> SteadyState:
    """The solution as the result of a search."""
    point = solution.point
    return SteadyState(
        point.positions,
        point.frames,
        point.motion,
        point.chain.origin,
        point.largest,
        error,
        steps,
        True,
    )
