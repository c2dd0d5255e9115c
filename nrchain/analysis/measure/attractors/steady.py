"""The stable state next to the end of a run: which kind it is, and since when the chain is in it.

Newton's method goes from the last snapshot to the state, and the spectrum says whether it attracts
the chain. A chain that passes slowly by an unstable state is thereby not taken for a settled one.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain.analysis.handedness import handedness
from nrchain.analysis.measure.attractors.alignment import distances, first_inside
from nrchain.analysis.measure.attractors.kinds import Attracted, Attractor
from nrchain.comoving.relative import RelativeChain
from nrchain.comoving.stability import leading_rate
from nrchain.errors import SceneError
from nrchain.states.newton import SteadyState
from nrchain.states.search import state_near
from nrchain.states.spectrum import require_states
from nrchain.trajectory.trajectory import Trajectory

SETTLED = 1e-3
"""A chain is in a state if all its spheres are within this many radii of it."""

NEAR = 0.1
"""A chain is on its way to a stable state if all its spheres are within this many radii of it."""

GROWS = 1e-4
"""A state is stable if no small change grows by more than this part in the time of the run."""

STRAIGHT = 1e-3
"""A chain is straight if no sphere is farther than this fraction of its length from the axis."""

MOVES = 1.0
"""Radii, or radians, that a chain must move or turn in the time of the run to count as moving."""

WOUND = 0.5
"""A coil has a hand of at least this, from 0 for as much of both to 1 for one alone."""

FLAT = 0.1
"""A bend is flat if it leaves its plane by less than this fraction of its height in the plane."""


def steady_attractor(trajectory: Trajectory, positions: np.ndarray) -> Attractor | None:
    """The stable state at the end of a run, or near it; None if there is none."""
    scene, end = trajectory.scene, (positions[-1], trajectory.frames[-1])
    try:
        require_states(scene)
        found = state_near(scene, end)
    except SceneError:
        return None
    chain = RelativeChain(scene, end)
    radius, there = scene.chain.radius, found.positions
    away = float(distances(chain, positions[-1:], there)[0])
    if away > NEAR * radius:
        return None
    rate = leading_rate(chain.at(found.poses))
    if rate.real * float(trajectory.time[-1]) > GROWS:
        return None
    first = first_inside(
        len(positions), lambda places: distances(chain, positions[places], there) > SETTLED * radius
    )
    since = float(trajectory.time[first]) if first < len(positions) else None
    kind, numbers = _kind(found, trajectory)
    numbers |= {
        "distance": away,
        "distance tolerance": SETTLED * radius,
        "growth": rate.real,
        "growth tolerance": GROWS / max(float(trajectory.time[-1]), 1e-300),
        "residual": found.residual,
    }
    rotation = numbers["rotation"]
    period = 2.0 * math.pi / rotation if kind is Attracted.ROTATING else None
    return Attractor(kind, since, period, numbers, _confidence(since, away / radius, rate.real))


def _kind(state: SteadyState, trajectory: Trajectory) -> tuple[Attracted, dict[str, float]]:
    """Straight, bent or wound, and at rest or moving."""
    scene, positions = trajectory.scene, state.positions
    radius = scene.chain.radius
    duration = max(float(trajectory.time[-1]), 1e-300)
    velocity = float(np.linalg.norm(state.motion.velocity))
    rotation = float(np.linalg.norm(state.motion.rotation))
    bend = _offset(positions, scene.chain.ends == "periodic") / scene.length
    last = Trajectory(
        trajectory.time[-1:], positions[None], state.frames[None], scene, status="completed"
    )
    wound = handedness(last, noise=SETTLED * radius * 1e-3)
    hand = float(np.nan_to_num(wound.hand[0]))
    extents = np.zeros(3)
    # two spheres have two singular values
    values = np.linalg.svd(positions - positions.mean(axis=0), compute_uv=False)
    extents[: len(values)] = values
    depth = float(extents[2] / max(extents[1], 1e-300))
    numbers = {
        "velocity": velocity,
        "rotation": rotation,
        "turn": state.motion.turn,
        "offset": bend * scene.length,
        "hand": hand,
        "depth over height": depth,
    }
    moves = velocity * duration > MOVES * radius
    turns = rotation * duration > MOVES
    if bend <= STRAIGHT:
        if turns and (not moves or rotation * radius > velocity):
            return Attracted.SPINNING, numbers
        return (Attracted.SWIMMING if moves else Attracted.STRAIGHT), numbers
    if turns:
        return Attracted.ROTATING, numbers
    if moves:
        return Attracted.SWIMMING, numbers
    is_coil = abs(hand) >= WOUND and depth > FLAT
    return (Attracted.COILED if is_coil else Attracted.BUCKLED), numbers


def _offset(positions: np.ndarray, periodic: bool) -> float:
    """Largest distance of a sphere from the axis through the ends, or along x."""
    axis = np.array([1.0, 0.0, 0.0])
    if not periodic:
        axis = positions[-1] - positions[0]
        axis = axis / max(float(np.linalg.norm(axis)), 1e-300)
    centred = positions - (positions.mean(axis=0) if periodic else positions[0])
    return float(np.linalg.norm(centred - (centred @ axis)[:, None] * axis, axis=1).max())


def _confidence(since: float | None, away: float, growth: float) -> str:
    state = f"stable: the slowest change decays at rate {-growth:.3g}"
    if since is None:
        return f"approaches a state, {away:.2g} a away, that is {state}"
    return state
