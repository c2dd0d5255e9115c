"""The poses a run starts from: its scene's or given ones, checked before any time is spent."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np

from nrchain.errors import SceneError
from nrchain.geometry.near_pairs import closest_pair
from nrchain.inputs.arguments import finite_array, rotations
from nrchain.inputs.arrays import GivenArray
from nrchain.motion.contact import contact_distance, has_turning_springs, most_turned_link
from nrchain.scene.memory import refuse_snapshots
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene, require_scene
from nrchain.scene.sections import StartSpec
from nrchain.scene.unwrapping import unwrapped_chain
from nrchain.watch.seed import refuse_unresolved_seed

SOLVER_BYTES = 12_000
"""Memory of one sphere in an integrator with nearest neighbours."""

MORE_NEIGHBOURS = 8
"""How many more neighbours are tried for a cut of the friction that holds."""

LARGEST_COORDINATE = 1e100
"""Beyond this the squares of distances leave the range of floats."""


def starting_poses(
    scene: Scene, positions: np.ndarray | None = None, frames: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The poses (N, 3) and (N, 3, 3) that a run starts from: the scene's, or the ones given.

    Positions of a periodic chain may be wrapped: they are put together, see
    :func:`nrchain.scene.unwrapping.unwrapped`.

    Raises :class:`~nrchain.errors.SceneError` for poses of the wrong shape, that are not finite,
    frames that are not right-handed and orthonormal to 1e-6 (rounding to 32 bits is mended),
    spheres that overlap, links turned by more than a quarter turn against the springs of twist and
    bend, friction between spheres cut where its mobility is not positive definite, and a bend below
    ``run.atol`` that grows beyond it.
    """
    _refuse_size(require_scene(scene))
    with np.errstate(all="ignore"):
        built = initial_poses(scene)
    count, start = scene.chain.particles, scene.start
    where = _given("positions", positions, start.positions)
    points = unwrapped_chain(
        scene, _finite(where or "start.amplitude", positions, built[0]), where or "start.amplitude"
    )
    turned = _given("frames", frames, start.frames)
    turns = rotations(built[1] if frames is None else frames, count, key=turned or "frames").copy()
    _refuse_overlap(scene, points, where)
    _refuse_turns(scene, turns, turned)
    _refuse_indefinite(scene, points)
    refuse_unresolved_seed(scene, points, turns)
    return points, turns


def with_start(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> Scene:
    """The scene that starts from these poses, which it holds."""
    start = StartSpec(
        shape="given",
        wavenumber=scene.start.wavenumber,
        positions=GivenArray(positions),
        frames=GivenArray(frames),
    )
    return replace(scene, start=start)


def _given(name: str, argument: object, of_scene: object) -> str:
    """What poses are called: an argument or a key of the scene; empty where neither is given."""
    if argument is not None:
        return name
    return StartSpec.key(name) if of_scene is not None else ""


def _finite(key: str, given: np.ndarray | None, built: np.ndarray) -> np.ndarray:
    """A copy of the positions given, or of those built, if their squares are finite."""
    points = finite_array(key, built if given is None else given, built.shape).copy()
    refuse_far(key, points)
    return points


def refuse_far(key: str, positions: np.ndarray) -> None:
    """Raise for a coordinate so large that its square is none of the floats."""
    largest = np.abs(positions).max()
    if largest > LARGEST_COORDINATE:
        raise SceneError(key, float(largest), f"no coordinate may exceed {LARGEST_COORDINATE:g}")


def _refuse_size(scene: Scene) -> None:
    """Refuse a scene whose trajectory and solver do not fit the memory of this machine."""
    count = scene.chain.particles
    present = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    left = present - SOLVER_BYTES * count
    if left < 0:
        needed, most = SOLVER_BYTES * count / 2**30, present // SOLVER_BYTES
        allowed = f"needs {needed:.3g} GiB to be integrated, where this machine has "
        allowed += f"{present / 2**30:.3g}; {most} would fit"
        raise SceneError("chain.particles", count, allowed)
    refuse_snapshots(scene, left, "in this machine")


def _refuse_overlap(scene: Scene, positions: np.ndarray, given: str) -> None:
    period = scene.length if scene.chain.ends == "periodic" else 0.0
    distance, i, j = closest_pair(positions, period)
    contact = contact_distance(scene)
    if distance <= contact:
        who = f"spheres {i} and {j}"
        must = f"{distance:.6g} apart and must be more than {contact:g}"
        if given:
            raise SceneError(given, who, f"overlap: they are {must}")
        raise SceneError("start.shape", scene.start.shape, f"{who} overlap: they are {must}")


def _refuse_turns(scene: Scene, frames: np.ndarray, given: str) -> None:
    angle, link = most_turned_link(frames, scene.chain.ends == "periodic")
    if has_turning_springs(scene) and angle >= 0.5 * np.pi:
        why = (
            f"turned by {angle:.4g} rad; from a quarter turn on the springs of twist and bend would"
            " pull it on towards a half turn"
        )
        if given:
            raise SceneError(given, f"link {link}", why)
        raise SceneError("start.shape", scene.start.shape, f"link {link} is {why}")


def _refuse_indefinite(scene: Scene, positions: np.ndarray) -> None:
    """Refuse a cut of the friction between spheres that lets a passive chain gain energy."""
    from nrchain.effects.shared.image_sums import takes_all
    from nrchain.motion.definiteness import DEFINITE, is_cut, least_mobility

    if not is_cut(scene):
        return
    least = least_mobility(scene, positions)
    if least >= DEFINITE:
        return
    cut = int(scene.friction.neighbours)
    more = range(cut + 1, min(cut + MORE_NEIGHBOURS, scene.chain.particles - 2) + 1)
    holds = next((k for k in more if least_mobility(scene, positions, k) >= DEFINITE), None)
    choices = [f"{holds}, which holds here"] if holds else []
    if takes_all(scene):
        choices.insert(0, "'all'")
    raise SceneError(
        "friction.neighbours",
        cut,
        f"cut there, the mobility of this start is not positive definite: its least eigenvalue is "
        f"{least:.2g} of that of a sphere by itself, and even a passive chain would gain energy; "
        + (f"must be {', or '.join(choices)}" if choices else "choose friction = 'one-body'"),
    )
