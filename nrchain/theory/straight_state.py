"""dx/dt = v(x, ψ) along the line: the steady or final state of a chain that stays straight.

The chain starts at its rest length. Its links lengthen, shorten and twist under their loads by
(I/h − J)(Δx, Δψ) = (v, ω) in each step (linearly implicit Euler, Newton's method at large h), until
the chain rests, spheres touch, a link has twisted by a quarter turn, or the run ends. Each step is
taken once as a whole and once in two halves; if the results differ, the step is too long. Implicit
steps damp growing motion and could otherwise miss a slow collapse.

Deuflhard, Newton Methods for Nonlinear Problems (2004), sec. 6.4: pseudo-transient continuation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.errors import SceneError
from nrchain.motion.contact import contact_distance, has_rotational_springs
from nrchain.motion.model import Model
from nrchain.outcome import Cause
from nrchain.scene.scene import Scene
from nrchain.theory.line_loads import from_blocks, refuse_bending, sparse_factors, straight_poses

LONGEST = 1000
"""Spheres of the longest chain that is computed: it takes some seconds."""

FIRST, SHRINKAGE, GROWTH = 1.0 / 64.0, 0.1, 2.0
"""The first step, in units of the run, and by how much steps may shrink and grow."""

CHANGE, ERROR = 0.05, 1e-3
"""A step changes a link by at most this fraction of d and this many radians; whole and half steps
agree to this error."""

STEPS = 1000
"""Largest number of steps; a chain that still moves is returned as it is."""

STILL = 1e-9
"""Links rest if they change by less than this in the rest of the run, in d and radians."""

_ALONG = [0, 3]


@dataclass(frozen=True)
class StraightState:
    """(x, ψ) of a straight chain under the loads of its links.

    Attributes
    ----------
    positions, frames
        (N, 3) and (N, 3, 3) in the frame of the lab, chain along x.
    twists
        (N, 6) there.
    lengths, turns
        (L,) of each link: its length, and the angle between its frames about x.
    time
        Time of this state.
    stopped
        Why the straight chain stops here; None if it does not.
    link
        The link at which it stops.
    """

    positions: np.ndarray
    frames: np.ndarray
    twists: np.ndarray
    lengths: np.ndarray
    turns: np.ndarray
    time: float
    stopped: Cause | None
    link: int


def straight_state(scene: Scene) -> StraightState:
    """The straight chain at the end of the run, or when spheres touch or a link twists too far.

    Raises :class:`~nrchain.errors.SceneError` for a chain that does not stay straight, see
    :func:`nrchain.theory.line_loads.line_loads`, and one of more than ``LONGEST`` spheres;
    FloatingPointError beyond the range of floats.
    """
    if scene.chain.particles > LONGEST:
        allowed = f"must be at most {LONGEST} to compute the straight state"
        raise SceneError("chain.particles", scene.chain.particles, allowed)
    line, moved = _Line(scene), True
    end, time, step = scene.run.end, 0.0, FIRST * scene.run.end
    for _ in range(STEPS):
        rate = line.rates()
        stopped, link = line.stopped()
        still = np.abs(line.relative(rate)).max(initial=0.0) * (end - time) < STILL
        if stopped or still or time >= end:
            break
        if moved:
            line.linearise()
        step = min(step, end - time)
        longer = line.advance(rate, step)
        moved = longer >= 1.0
        time += step * moved
        step *= min(max(0.8 * longer, SHRINKAGE), GROWTH)
    return line.state(time, stopped, link)


class _Line:
    """The coordinates (x, ψ) of the spheres of a straight chain, and their rates."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._model = scene, Model(scene)
        self._positions, self._frames = straight_poses(scene)
        count = scene.chain.particles
        self._turns = np.zeros(count)
        self._free = np.flatnonzero(~self._model.held)
        self._blocks = np.empty((count, 2 * self._model.reach + 1, 6, 6))
        self._periodic = scene.chain.ends == "periodic"

    def rates(self) -> np.ndarray:
        """(ẋ, ψ̇) (N, 2) of all spheres, without their mean."""
        self._twists = self._model.twists(self._positions, self._frames)
        if not np.isfinite(self._twists).all():
            raise FloatingPointError("velocities leave the range of floats")
        refuse_bending(self._scene, (self._positions, self._frames), self._twists)
        rate = self._twists[:, _ALONG]
        return rate if self._model.held.any() else rate - rate.mean(axis=0)

    def relative(self, change: np.ndarray) -> np.ndarray:
        """(L, 2): extension of each link, in d, and its twist, for a change (N, 2)."""
        ahead = np.roll(change, -1, axis=0) - change
        return (ahead if self._periodic else ahead[:-1]) / [self._scene.chain.spacing, 1.0]

    def linearise(self) -> None:
        """Take J at this state, for the next steps."""
        self._model.linearise(self._positions, self._frames, self._blocks)
        along = self._blocks[:, :, _ALONG][:, :, :, _ALONG]
        kept = np.ravel(2 * self._free[:, None] + np.arange(2))
        self._matrix = from_blocks(along, periodic=self._periodic)[kept][:, kept]
        self._kept = kept

    def _step(self, rate: np.ndarray, step: float) -> np.ndarray:
        """The change (N, 2) in a step of this length."""
        from scipy.sparse import eye_array

        change = np.zeros(rate.size)
        if len(self._kept):
            system = eye_array(len(self._kept), format="csc") - step * self._matrix
            change[self._kept] = sparse_factors(system).solve(step * rate.ravel()[self._kept])
        return change.reshape(rate.shape)

    def advance(self, rate: np.ndarray, step: float) -> float:
        """Advance by 2·(two half steps) − (whole step), of second order.

        Returns the allowed length of the step over its length; below 1 the chain does not advance.
        Raises if the chain does not stay straight, or finite, within the step.
        """
        kept = self._positions.copy(), self._turns.copy()
        whole = self._step(rate, step)
        first = self._step(rate, 0.5 * step)
        self._move(first)
        halves = first + self._step(self.rates(), 0.5 * step)
        change = float(np.abs(self.relative(halves)).max(initial=0.0))
        error = float(np.abs(self.relative(halves - whole)).max(initial=0.0))
        allowed = 1.0 / max(change / CHANGE, math.sqrt(error / ERROR), 1e-3)
        self._positions[:], self._turns[:] = kept
        self._move(2.0 * halves - whole if allowed >= 1.0 else np.zeros_like(halves))
        return allowed

    def _move(self, change: np.ndarray) -> None:
        self._positions[:, 0] += change[:, 0]
        self._turns += change[:, 1]
        cosine, sine = np.cos(self._turns), np.sin(self._turns)
        self._frames[:, 1] = np.stack([0.0 * cosine, cosine, sine], axis=1)
        self._frames[:, 2] = np.stack([0.0 * cosine, -sine, cosine], axis=1)

    def links(self) -> tuple[np.ndarray, np.ndarray]:
        """Lengths and turns (L,)."""
        lengths = np.roll(self._positions[:, 0], -1) - self._positions[:, 0]
        turns = np.roll(self._turns, -1) - self._turns
        lengths[-1] += self._scene.length
        return (lengths, turns) if self._periodic else (lengths[:-1], turns[:-1])

    def stopped(self) -> tuple[Cause | None, int]:
        """Why a run would stop at this state, and at which link."""
        lengths, turns = self.links()
        shortest = int(np.argmin(lengths))
        if lengths[shortest] <= contact_distance(self._scene):
            return Cause.TOUCH, shortest
        most = int(np.argmax(np.abs(turns)))
        if has_rotational_springs(self._scene) and abs(turns[most]) >= 0.5 * math.pi:
            return Cause.TURN, most
        return None, 0

    def state(self, time: float, stopped: Cause | None, link: int) -> StraightState:
        poses = self._positions, self._frames
        return StraightState(*poses, self._twists, *self.links(), time, stopped, link)
