"""X(T) = exp(Tξ) X(0): the shapes that return, from a run that nearly does."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nrchain.comoving.relative import RelativeChain
from nrchain.errors import SceneError, Words
from nrchain.inputs.rules import is_number
from nrchain.notebook import record_html
from nrchain.scene.scene import Scene
from nrchain.states.cycles.carrying import carry, is_half_turned, is_turned, twice
from nrchain.states.cycles.charts import chart
from nrchain.states.cycles.mesh import Refined, refined
from nrchain.states.cycles.multipliers import (
    Trivial,
    largest_difference,
    multipliers,
    trivial_multipliers,
)
from nrchain.states.cycles.orbit import FIRST, Orbit
from nrchain.states.cycles.recurrence import STILL, orbit_from_run
from nrchain.states.search import refuse_poses_out_of_reach
from nrchain.states.spectrum import require_states
from nrchain.trajectory.trajectory import Trajectory
from nrchain.types import Poses
from nrchain.wording import brief

TOLERANCE = 1e-6
"""Error of the period, relative, and of poses, in d and radians, unless another is given."""

NEAR_HALF, LOOSE = 0.1, 1e-3
"""Difference from half a turn, in radians, of a guess that may be planar, and of its orbit."""

MODES = 10
"""Leading multipliers unless more are asked for."""


@dataclass(frozen=True)
class Cycle:
    """A chain whose shape returns after a period, carried along and turned as a whole.

    Attributes
    ----------
    scene
        The scene.
    period, period_error
        T, and the estimate of its error.
    error
        That of positions and frames, in lengths and radians: the largest of all spheres.
    velocity, rotation, turn
        V (3,) of the point ``origin``, Ω (3,) and s of the axes in which the chain is periodic.
        The rotation over a period is at most half a turn.
    origin
        o (3,).
    amplitude
        Largest distance of a sphere from its mean position in these axes.
    multipliers, multiplier_error
        (k,) the largest Floquet multipliers beside the trivial ones, and the error of these.
    modes
        (k, N, 6): the changes (u, φ) of the first pose that grow by each multiplier in a period,
        less those along the cycle and as a whole, with ‖(u, φ)‖ = 1.
    trivial
        The multipliers of a shift in time and of motions as a whole, with their distance from what
        they are.
    orbit
        The poses at the stages of all intervals.
    """

    scene: Scene
    period: float
    period_error: float
    error: float
    velocity: np.ndarray
    rotation: np.ndarray
    turn: float
    origin: np.ndarray = field(repr=False)
    amplitude: float
    multipliers: np.ndarray
    multiplier_error: float
    modes: np.ndarray = field(repr=False)
    trivial: Trivial = field(repr=False)
    orbit: Orbit = field(repr=False)

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def is_stable(self) -> bool:
        """Whether all changes of the shape decay, by more than the error of the multipliers."""
        return bool(np.all(np.abs(self.multipliers) < 1.0 - self.multiplier_error))

    @property
    def times(self) -> np.ndarray:
        """(M,) at which the intervals begin, from 0 on."""
        return self.period * self.orbit.starts

    @property
    def positions(self) -> np.ndarray:
        """(M, N, 3) in the lab at these times."""
        return np.stack([self.at(time)[0] for time in self.times])

    @property
    def frames(self) -> np.ndarray:
        """(M, N, 3, 3) in the lab at these times."""
        return np.stack([self.at(time)[1] for time in self.times])

    @property
    def displacement(self) -> np.ndarray:
        """(3,) by which the mean position of the spheres moves in a period, from t = 0 on.

        Of a chain that turns, only the part along Ω is the same from any other time on.
        """
        return self.at(self.period)[0].mean(axis=0) - self.at(0.0)[0].mean(axis=0)

    @property
    def rotation_angle(self) -> np.ndarray:
        """TΩ (3,): axis and angle of the rotation in a period."""
        return self.period * self.rotation

    def at(self, time: float) -> Poses:
        """Positions (N, 3) and frames (N, 3, 3) in the lab, at any time."""
        chain = RelativeChain(self.scene, self.orbit.base(0), self.origin)
        moved = carry(chain, self.orbit.elementary, time)
        return moved.applied(self.orbit.at(time / self.period), self.origin)


def find_cycle(
    scene: Scene, guess: Any, *, tolerance: float = TOLERANCE, modes: int = MODES
) -> Cycle:
    """X and T with Ẋ = w(X), X(T) = exp(Tξ) X(0): an oscillation that repeats itself for ever.

    Parameters
    ----------
    scene
        Any ends and effects, without ``effects = "auto"``.
    guess
        A trajectory whose end is nearly periodic, or another cycle. A trajectory need not be of the
        same scene: its last snapshot is where a run over one period begins.
    tolerance
        Error of the period, relative, and of the poses, in d and radians. Intervals are halved
        until it is reached, and the result states the error.
    modes
        Number of leading multipliers.

    Raises :class:`~nrchain.errors.SceneError` if the guess is not nearly periodic, with how near it
    comes, or has settled, or if no cycle is found from it.

    >>> from nrchain import load_scene, simulate
    >>> changes = {"chain.particles": 12, "slip.2s": 200.0, "slip.3t": 6500.0}
    >>> changes |= {"elasticity.ratio": 1e8, "run.end": 1000.0, "run.snapshots": 1001}
    >>> run = simulate(load_scene("buckling", **changes))
    >>> cycle = find_cycle(run.scene, run, tolerance=1e-3)
    >>> round(cycle.period, 1), cycle.is_stable
    (36.6, True)
    """
    require_states(scene)
    if not is_number(tolerance) or not tolerance > 0.0:
        raise SceneError("tolerance", tolerance, "must be a positive number")
    return cycle_near(*guessed_orbit(scene, guess), tolerance, modes)


def guessed_orbit(scene: Scene, guess: Any) -> tuple[RelativeChain, Orbit]:
    """The chain and the orbit from which Newton's method begins."""
    count = scene.chain.particles
    if isinstance(guess, Cycle) and guess.scene.chain.particles == count:
        half = max(FIRST, guess.orbit.count // 2)
        chain = RelativeChain(scene, guess.orbit.base(0), guess.origin)
        return chain, guess.orbit.remeshed(np.full(half, 1.0 / half))
    if isinstance(guess, Trajectory) and guess.scene.chain.particles == count:
        return orbit_from_run(scene, guess)
    given = type(guess).__name__
    raise SceneError("guess", given, f"must be a trajectory or a cycle of {count} spheres")


def cycle_near(chain: RelativeChain, orbit: Orbit, tolerance: float, modes: int) -> Cycle:
    """The cycle near an orbit; see :func:`find_cycle`."""
    try:
        with np.errstate(all="ignore"):
            found = _found(chain, orbit, tolerance)
    except (FloatingPointError, np.linalg.LinAlgError) as error:
        raise SceneError("guess", Words("the guess"), f"leads to no cycle: {error}") from None
    if found is None:
        allowed = (
            "leads to no cycle: Newton's method does not converge; run it longer. If its"
            " oscillation dies out, find_state finds the state that it settles in"
        )
        raise SceneError("guess", Words("the guess"), allowed)
    _refuse_state(found)
    for pose in zip(*found.fine.system.orbit.bases(), strict=True):
        refuse_poses_out_of_reach(chain.scene, *pose, "guess")
    return cycle_of(found, modes)


def _found(chain: RelativeChain, orbit: Orbit, tolerance: float) -> Refined | None:
    """The cycle near an orbit; over two periods if the shape is turned by half after one."""
    if is_half_turned(chain, orbit, NEAR_HALF):
        found = refined(chain, orbit, LOOSE)
        if found is not None and is_half_turned(chain, found.fine.system.orbit, LOOSE):
            doubled = refined(chain, twice(chain, found.fine.system.orbit), tolerance)
            if doubled is not None and not is_turned(chain, doubled.fine.system.orbit):
                return doubled
    return refined(chain, orbit, tolerance)


def _refuse_state(found: Refined) -> None:
    """Raise if the orbit is a single shape."""
    system = found.fine.system
    chain, orbit = system.chain, system.orbit
    away = chart(orbit.positions, orbit.frames, orbit.base(0))[:, :, chain.free]
    size = np.linalg.norm(away.reshape(-1, 2, 3), axis=2) * [1.0, chain.length]
    if size.max() <= STILL * chain.scene.chain.spacing:
        allowed = "leads to a state whose shape does not change: find_state finds it"
        raise SceneError("guess", Words("the guess"), allowed)


def cycle_of(found: Refined, modes: int) -> Cycle:
    """What a user gets of an orbit that has been found."""
    system = found.fine.system
    chain, orbit = system.chain, system.orbit
    trivial, neutral = trivial_multipliers(found.fine)
    values, vectors = multipliers(found.fine, neutral, modes)
    coarse = multipliers(found.coarse, trivial_multipliers(found.coarse)[1], modes)[0]
    motion = chain.motion(orbit.elementary)
    return Cycle(
        scene=chain.scene,
        period=float(orbit.period),
        period_error=float(found.period),
        error=found.poses,
        velocity=motion.velocity,
        rotation=motion.rotation,
        turn=motion.turn,
        origin=chain.origin,
        amplitude=orbit.amplitude,
        multipliers=values,
        multiplier_error=max(largest_difference(values, coarse), trivial.error),
        modes=np.stack([chain.poses(vector) for vector in vectors.T]),
        trivial=trivial,
        orbit=orbit,
    )
