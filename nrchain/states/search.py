"""G(X) = 0 near given poses: the state that a user means, or an error that says what is left.

The straight chain is found from its rest length, and if its links are soft, from where it is at the
end of its run. Given poses must be within one spacing of the state.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.comoving.relative import Point, RelativeChain
from nrchain.errors import SceneError, Words
from nrchain.geometry.near_pairs import closest_pair
from nrchain.inputs.arguments import finite_array, rotations
from nrchain.motion.contact import contact_distance, has_rotational_springs, most_turned_link
from nrchain.scene.scene import Scene
from nrchain.scene.unwrapping import unwrapped_chain
from nrchain.states.newton import SteadyState, find_steady_state
from nrchain.theory.line_loads import refuse_bending, straight_poses
from nrchain.theory.straight_state import straight_state
from nrchain.types import Poses


def state_near(scene: Scene, at: Any = None, key: str = "at") -> SteadyState:
    """The state near given poses, or the straight one; errors name the argument ``key``.

    ``at`` is ``(positions, frames)``, or anything with both, of which the last snapshot is taken.

    Raises :class:`~nrchain.errors.SceneError` if there is none within d of the poses.
    """
    straight = at is None
    poses = straight_poses(scene) if straight else given_poses(scene, at, key)
    chain = RelativeChain(scene, poses)
    begin = chain.at(poses)
    if straight:
        refuse_bending(scene, poses, chain.model.twists(*poses))
    state = find_steady_state(scene, poses)
    if straight and not state.found:
        state = _from_relaxed(scene, key)
    # no step of Newton's method moves the chain as a whole
    away = np.linalg.norm(state.positions - poses[0], axis=1).max()
    if not state.found:
        found = f"Newton's method ends with {state.residual:.3g}"
        raise _no_state(begin, key, start_name(at), found)
    if not straight and away > scene.chain.spacing:
        found = f"the state that Newton's method finds from there is {away:.3g} away"
        raise _no_state(begin, key, start_name(at), found)
    refuse_out_of_reach(scene, state, key)
    return state


def start_name(at: Any) -> str:
    """What errors call the poses from which a state is sought."""
    return Words("the straight chain" if at is None else "the given poses")


def _no_state(begin: Point, key: str, name: str, found: str) -> SceneError:
    """The error for poses near which no state is, with the effect that forbids one."""
    scene, effects = begin.chain.scene, begin.chain.model.further_effects
    left = f"spheres move relative to each other at up to {begin.largest:.3g}"
    for effect in effects:
        if not effect.covariant:
            allowed = f"forbids a state of steady motion near these poses: {left}, and {found}"
            return SceneError(effect.key, effect.value(scene), allowed)
    remedy = "begin nearer to a state, such as the end of a run that has settled"
    return SceneError(key, name, f"is no state: {left}, and {found}; {remedy}")


def given_poses(scene: Scene, at: Any, key: str) -> Poses:
    """Checked poses of an argument: a pair of arrays, or the last snapshot of a trajectory."""
    if hasattr(at, "positions") and hasattr(at, "frames"):
        positions, frames = np.asarray(at.positions), np.asarray(at.frames)
        pair = (positions[-1], frames[-1]) if positions.ndim == 3 else (positions, frames)
    else:
        try:
            pair = tuple(at)
        except TypeError:
            pair = ()  # type: ignore[assignment]
        if len(pair) != 2:
            raise SceneError(key, at, "must be (positions, frames) or a trajectory")
    count = scene.chain.particles
    positions = unwrapped_chain(scene, finite_array(key, pair[0], (count, 3)), key)
    return positions, rotations(pair[1], count, key=key)


def _from_relaxed(scene: Scene, key: str) -> SteadyState:
    """The state from where the straight chain is at the end of its run, if links stay straight."""
    line = straight_state(scene)
    if line.stopped:
        allowed = (
            f"has no state: {line.stopped.value.replace('-', ' ')} at link {line.link}, at t ="
            f" {line.time:.4g} of a run; raise elasticity.ratio or weaken the slip"
        )
        raise SceneError(key, start_name(None), allowed)
    return find_steady_state(scene, (line.positions, line.frames))


def refuse_out_of_reach(scene: Scene, state: SteadyState, key: str = "at") -> None:
    """Raise if spheres overlap in a state, or a link has turned by a quarter: no run gets there."""
    refuse_poses_out_of_reach(scene, *state.poses, key)


def refuse_poses_out_of_reach(
    scene: Scene, positions: np.ndarray, frames: np.ndarray, key: str = "at"
) -> None:
    """As :func:`refuse_out_of_reach`, for poses."""
    distance, i, j = closest_pair(positions, scene.period)
    contact = contact_distance(scene)
    soft = "the loads of the links exceed their stiffness; raise "
    if distance <= contact:
        allowed = f"overlap in the state, {distance:.4g} apart: {soft}elasticity.ratio"
        raise SceneError(key, Words(f"spheres {i} and {j}"), allowed)
    angle, link = most_turned_link(frames, scene.chain.ends == "periodic")
    if has_rotational_springs(scene) and angle >= 0.5 * np.pi:
        allowed = f"has turned by {angle:.4g} rad in the state: {soft}elasticity.twist and .bend"
        raise SceneError(key, Words(f"link {link}"), allowed)
