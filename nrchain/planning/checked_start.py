"""The poses that a run starts from: those of its scene or given ones, checked before the run."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np

from nrchain.errors import SceneError, Words
from nrchain.geometry.near_pairs import closest_pair
from nrchain.inputs.arguments import finite_array, rotations
from nrchain.inputs.arrays import GivenArray
from nrchain.motion.contact import (
    contact_distance,
    has_rotational_springs,
    most_turned_link,
)
from nrchain.scene.chain_sections import StartSpec
from nrchain.scene.loading import require_scene
from nrchain.scene.memory import refuse_snapshots
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene
from nrchain.scene.unwrapping import unwrapped_chain
from nrchain.watch.seed import refuse_unresolved_seed

SOLVER_BYTES = 12_000
"""Bytes that an integrator with nearest neighbours takes for one sphere."""

MORE_NEIGHBOURS = 8
"""How many more neighbours are tried to find a cut of the friction that is positive definite."""

LARGEST_COORDINATE = 1e100
"""Above this the squares of distances leave the range of floating point."""


def starting_poses(
    scene: Scene, positions: np.ndarray | None = None, frames: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The poses (N, 3) and (N, 3, 3) that a run starts from: those of the scene, or given ones.

    Positions of a periodic chain may be wrapped, see
    :func:`nrchain.scene.unwrapping.unwrapped`.

    Raises :class:`~nrchain.errors.SceneError` for

    - poses of the wrong shape, or that are not finite;
    - frames that are not right-handed and orthonormal to 1e-6 (rounding to 32 bits is corrected);
    - spheres that overlap;
    - links turned by a quarter turn or more against the springs of twist and bend;
    - a cut of the friction between spheres at which the mobility is not positive definite;
    - a bend below ``run.atol`` that grows beyond it.
    """
    _refuse_size(require_scene(scene))
    with np.errstate(all="ignore"):
        built = initial_poses(scene)
    count, start = scene.chain.particles, scene.start
    where = _key_of("positions", positions, start.positions)
    points = unwrapped_chain(
        scene, _finite(where or "start.amplitude", positions, built[0]), where or "start.amplitude"
    )
    turned = _key_of("frames", frames, start.frames)
    turns = rotations(built[1] if frames is None else frames, count, key=turned or "frames").copy()
    _refuse_overlap(scene, points, where)
    _refuse_turns(scene, turns, turned)
    _refuse_indefinite(scene, points)
    refuse_unresolved_seed(scene, points, turns)
    return points, turns


def with_start(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> Scene:
    """The scene with these poses as its start."""
    start = StartSpec(
        shape="given",
        wavenumber=scene.start.wavenumber,
        positions=GivenArray(positions),
        frames=GivenArray(frames),
    )
    return replace(scene, start=start)


def _key_of(name: str, argument: object, of_scene: object) -> str:
    """The name of given poses in errors, an argument or a key; empty if none are given."""
    if argument is not None:
        return name
    return StartSpec.key(name) if of_scene is not None else ""


def _finite(key: str, given: np.ndarray | None, built: np.ndarray) -> np.ndarray:
    """A copy of the given positions, or else of those built from the scene, checked."""
    points = finite_array(key, built if given is None else given, built.shape).copy()
    refuse_far(key, points)
    return points


def refuse_far(key: str, positions: np.ndarray) -> None:
    """Raise for a coordinate whose square is beyond the range of floating point."""
    largest = np.abs(positions).max()
    if largest > LARGEST_COORDINATE:
        raise SceneError(
            key, float(largest), f"coordinates must be at most {LARGEST_COORDINATE:g} in size"
        )


def _refuse_size(scene: Scene) -> None:
    """Raise if the trajectory and the solver do not fit the memory of this machine."""
    count = scene.chain.particles
    present = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    left = present - SOLVER_BYTES * count
    if left < 0:
        needed, most = SOLVER_BYTES * count / 2**30, present // SOLVER_BYTES
        allowed = f"needs {needed:.3g} GiB of memory, and this machine has "
        allowed += f"{present / 2**30:.3g} GiB; {most} spheres would fit"
        raise SceneError("chain.particles", count, allowed)
    refuse_snapshots(scene, left, "in this machine")


def _refuse_overlap(scene: Scene, positions: np.ndarray, given: str) -> None:
    distance, i, j = closest_pair(positions, scene.period)
    contact = contact_distance(scene)
    if distance <= contact:
        who = Words(f"spheres {i} and {j}")
        must = f"{distance:.6g} apart and must be more than {contact:g} apart"
        if given:
            raise SceneError(given, who, f"overlap: they are {must}")
        raise SceneError("start.shape", scene.start.shape, f"{who} overlap: they are {must}")


def _refuse_turns(scene: Scene, frames: np.ndarray, given: str) -> None:
    angle, link = most_turned_link(frames, scene.chain.ends == "periodic")
    if has_rotational_springs(scene) and angle >= 0.5 * np.pi:
        why = (
            f"turned by {angle:.4g} rad, and must be turned by less than π/2: beyond that the"
            " springs of twist and bend pull it towards a half turn"
        )
        if given:
            raise SceneError(given, Words(f"link {link}"), why)
        raise SceneError("start.shape", scene.start.shape, f"link {link} is {why}")


def _refuse_indefinite(scene: Scene, positions: np.ndarray) -> None:
    """Raise for a cut of the friction between spheres at which a passive chain gains energy."""
    from nrchain.effects.shared.image_sums import takes_all
    from nrchain.motion.definiteness import DEFINITE, CutFriction, is_cut

    if not is_cut(scene):
        return
    friction = CutFriction(scene)
    least, cut = friction.least_mobility(positions), friction.neighbours
    if least >= DEFINITE:
        return
    more = range(cut + 1, min(cut + MORE_NEIGHBOURS, scene.chain.particles - 2) + 1)
    holds = next(
        (k for k in more if CutFriction(scene, k).least_mobility(positions) >= DEFINITE), None
    )
    choices = [f"{holds}, which is enough here"] if holds else []
    if takes_all(scene):
        choices.insert(0, "'all'")
    raise SceneError(
        "friction.neighbours",
        cut,
        f"with this cut the mobility of the start is not positive definite, and even a passive "
        f"chain would gain energy: its least eigenvalue is {least:.2g} times that of one sphere; "
        + (f"must be {', or '.join(choices)}" if choices else "choose friction = 'one-body'"),
    )
