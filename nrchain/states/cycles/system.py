"""δ_(k+1) = A_k δ_k + c_k γ + r_k: all intervals of an orbit, condensed to its first pose.

The stages of an interval follow from its first pose and from the numbers γ: the period, the drift
of the axes, and further ones such as a key of the scene. What is left is

    (Φ − 1) δ_0 + Γ γ = −r,   Σ_k F_kᵀ δ_k = 0,   Σ_k Q_kᵀ δ_k = 0,

with Φ = A_(M−1) … A_0, the derivative of the flow over a period: no change of the orbit is along
itself (F = Ẋ) or a motion of the chain as a whole (Q). Further numbers need further rows.

γ is in lengths: it moves the orbit by about so much. γ_0 is F T dT/T, and the next ones are T times
a motion of the axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from nrchain.comoving.motions import moved
from nrchain.comoving.relative import RelativeChain, orthonormal_motions
from nrchain.motion.integrators.radau_tableau import RUNGE_KUTTA
from nrchain.states.cycles.interval import Interval
from nrchain.states.cycles.orbit import Orbit
from nrchain.types import Poses


class Change(NamedTuple):
    """A change of an orbit: of all stages (M, 3, n) in the lab, and of the numbers γ."""

    stages: np.ndarray
    numbers: np.ndarray

    @property
    def size(self) -> float:
        """√(mean ‖η‖² + ‖γ‖²)."""
        return float(np.sqrt((self.stages**2).sum(axis=2).mean() + self.numbers @ self.numbers))


class Row(NamedTuple):
    """A further equation: Σ stages · η + numbers · γ = −(what is left).

    Attributes
    ----------
    stages
        (M, 3, n).
    numbers
        (c,) of all numbers: the period, the motions of the axes, the further ones.
    """

    stages: np.ndarray
    numbers: np.ndarray


class System:
    """The equations of an orbit.

    Attributes
    ----------
    defects
        (M, 3, n) y − h A f.
    motions
        (7, r) the motions of the axes per unit of γ/T.
    speed
        √(mean ‖F‖²) over the intervals.
    """

    def __init__(self, chain: RelativeChain, orbit: Orbit) -> None:
        self.chain, self.orbit = chain, orbit
        steps = orbit.period * orbit.widths
        self.intervals = [
            Interval(
                chain,
                orbit.base(k),
                (orbit.positions[k], orbit.frames[k]),
                float(steps[k]),
                orbit.elementary,
            )
            for k in range(orbit.count)
        ]
        self.defects = np.stack([one.defect for one in self.intervals])
        last = [one.points[2] for one in self.intervals]
        columns = np.concatenate([point.columns for point in last])
        root = np.sqrt(orbit.count)
        self.motions = root * orthonormal_motions(columns, chain.allowed, chain.length)[1]
        self.flow = np.stack([point.residual for point in last])
        self.speed = float(np.sqrt((self.flow**2).sum(axis=1).mean()))

    def moved(self, change: Change, damping: float = 1.0) -> System:
        """The equations of a changed orbit."""
        return System(self.chain, self.changed(change, damping))

    def changed(self, change: Change, damping: float = 1.0) -> Orbit:
        """The orbit moved by a change."""
        orbit, numbers = self.orbit, damping * change.numbers
        positions, frames = displaced(self.chain, orbit, damping * change.stages)
        period = orbit.period + float(numbers[0]) / self.speed
        drift = self.motions @ numbers[1 : 1 + self.motions.shape[1]] / orbit.period
        return Orbit(period, orbit.elementary + drift, orbit.widths, positions, frames)


def displaced(chain: RelativeChain, orbit: Orbit, stages: np.ndarray) -> Poses:
    """The poses of an orbit, changed by coordinates (M, 3, n)."""
    positions, frames = np.empty_like(orbit.positions), np.empty_like(orbit.frames)
    for k, row in enumerate(stages):
        for j, stage in enumerate(row):
            pose = orbit.positions[k, j], orbit.frames[k, j]
            positions[k, j], frames[k, j] = moved(*pose, chain.poses(stage))
    return positions, frames


class Condensed:
    """The factors of a system, for several right-hand sides.

    ``sources`` (M, 3, n) are ∂G/∂p at the stages for each further number p.

    Attributes
    ----------
    monodromy
        Φ (n, n), from the first pose of the orbit to the first of the next period.
    """

    def __init__(self, system: System, sources: Sequence[np.ndarray] = ()) -> None:
        self.system, self._sources = system, sources
        count, n = system.orbit.count, system.chain.dimension
        self.numbers = 1 + system.motions.shape[1] + len(sources)
        self._factors, self._maps = [], np.empty((count, 3 * n, n + self.numbers))
        for k, interval in enumerate(system.intervals):
            factors, begin = interval.factorise()
            right = np.concatenate([begin, self._columns(k, interval)], axis=1)
            self._factors.append(factors)
            self._maps[k] = factors.solve(right)
        # the first poses of all intervals, as (δ_0, γ) changes them
        state = np.eye(n, n + self.numbers)
        self._states = np.empty((count, n, n + self.numbers))
        for k in range(count):
            self._states[k] = state
            state = self._following(k, state)
        self.monodromy = state[:, :n]
        whole = state.copy()
        whole[:, :n] -= np.eye(n)
        self._whole = np.concatenate([whole, self._fixed()])

    def _columns(self, k: int, interval: Interval) -> np.ndarray:
        """(3n, c): what a unit of each number adds to the right-hand side of an interval."""
        system, orbit = self.system, self.system.orbit
        motions = [-(point.columns @ system.motions) / orbit.period for point in interval.points]
        further = [source[k][:, :, None] for source in self._sources]
        sources = np.concatenate([np.stack(motions), *further], axis=2)
        period = orbit.widths[k] / system.speed * interval.rates[:, :, None]
        rates = np.concatenate([period, interval.step * interval.turned(sources)], axis=2)
        return np.einsum("ji,inc->jnc", RUNGE_KUTTA, rates).reshape(-1, self.numbers)

    def _following(self, k: int, state: np.ndarray) -> np.ndarray:
        """The first pose of the next interval."""
        n = self.system.chain.dimension
        last = self._maps[k, 2 * n :]
        out = last[:, :n] @ state
        out[:, n:] += last[:, n:]
        return out

    @cached_property
    def _weights(self) -> list[np.ndarray]:
        """The rows (M, n) on the first poses of intervals: along the orbit, and as a whole."""
        system = self.system
        columns = np.stack([one.points[2].columns @ system.motions for one in system.intervals])
        rows = [system.flow / system.speed, *columns.transpose(2, 0, 1)]
        # the last stage of an interval is the first pose of the next
        return [np.roll(row, 1, axis=0) / system.orbit.count for row in rows]

    def _fixed(self) -> np.ndarray:
        """These rows on (δ_0, γ)."""
        rows = [np.einsum("kn,knc->c", weights, self._states) for weights in self._weights]
        return np.stack(rows)

    def _along(self, row: Row) -> np.ndarray:
        """A further row on (δ_0, γ)."""
        n = self.system.chain.dimension
        weights = row.stages.reshape(len(row.stages), 1, -1)
        through = (weights @ self._maps)[:, 0]
        out = np.einsum("kn,knc->c", through[:, :n], self._states)
        out[n:] += through[:, n:].sum(axis=0) + row.numbers
        return out

    def solve(
        self, defects: np.ndarray, rows: Sequence[Row] = (), left: Sequence[float] = ()
    ) -> Change:
        """The change that takes these defects (M, 3, n), and those of further rows, away."""
        n, count = self.system.chain.dimension, len(defects)
        own = np.stack(
            [-one.solve(row.ravel()) for one, row in zip(self._factors, defects, strict=True)]
        )
        states, rest = self._forced(own)
        fixed = [np.sum(weights * states) for weights in self._weights]
        stages = np.einsum("kmn,kn->km", self._maps[:, :, :n], states) + own
        further = [
            value + np.sum(row.stages.reshape(count, -1) * stages)
            for row, value in zip(rows, left, strict=True)
        ]
        whole = np.concatenate([self._whole, *[self._along(row)[None] for row in rows]])
        found = np.linalg.solve(whole, -np.concatenate([rest, fixed, further]))
        if not np.isfinite(found).all():
            raise FloatingPointError("the matrix of an orbit is singular")
        states = self._states @ found
        stages += np.einsum("kmn,kn->km", self._maps[:, :, :n], states)
        stages += self._maps[:, :, n:] @ found[n:]
        return Change(stages.reshape(count, 3, n), found[n:])

    def _forced(self, own: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Changes (M, n) of the first poses, and of the end, if the orbit begins as it is."""
        n, count = self.system.chain.dimension, len(own)
        rest, states = np.zeros(n), np.empty((count, n))
        for k in range(count):
            states[k] = rest
            rest = self._maps[k, 2 * n :, :n] @ rest + own[k, 2 * n :]
        return states, rest

    def residual(self, defects: np.ndarray) -> np.ndarray:
        """r (n,): what defects (M, 3, n) add to the change of the last pose."""
        rows = zip(self._factors, defects, strict=True)
        return self._forced(np.stack([-one.solve(row.ravel()) for one, row in rows]))[1]

    def spread(self, change: np.ndarray) -> np.ndarray:
        """(M, 3, n): the change of all stages that a change (n,) of the first pose grows into."""
        n = self.system.chain.dimension
        states = self._states[:, :, :n] @ change
        stages = np.einsum("kmn,kn->km", self._maps[:, :, :n], states)
        return stages.reshape(len(states), 3, n)
