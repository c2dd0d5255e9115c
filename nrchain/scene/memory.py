"""The bytes of a trajectory in memory and on disk, and whether there is room for them."""

from __future__ import annotations

from nrchain.errors import SceneError
from nrchain.scene.scene import Scene

CHECKPOINT_POSES = 2
"""Checkpoints that a file keeps besides its snapshots."""

SNAPSHOT_MARKS = 3 * 8
"""Bytes of a snapshot besides its poses: its time, the time asked for, its step."""

BOX_BYTES = 3 * 8
"""Bytes of the edges of the box of a periodic chain in each snapshot."""

LEAST_SNAPSHOTS = 2
"""A run records its start and its end."""


def pose_bytes(scene: Scene) -> int:
    """Bytes of the poses of one snapshot: 3 coordinates and 9 frame components for each sphere."""
    return 12 * 8 * scene.chain.particles


def snapshot_bytes(scene: Scene) -> int:
    """Bytes of one snapshot with its marks."""
    box = BOX_BYTES if scene.chain.ends == "periodic" else 0
    return pose_bytes(scene) + SNAPSHOT_MARKS + box


def refuse_snapshots(scene: Scene, free: int, where: str, snapshots: int | None = None) -> None:
    """Raise :class:`~nrchain.errors.SceneError` if the snapshots need more than ``free`` bytes.

    ``where`` says in the error where these are. ``snapshots`` is by default that of the scene.
    """
    each = snapshot_bytes(scene)
    snapshots = scene.run.snapshots if snapshots is None else snapshots
    if each * snapshots <= free:
        return
    free = max(free, 0)
    fit = free // each
    needed = f"{_size(each * snapshots)}, and {_size(free)} are {where}"
    if fit < LEAST_SNAPSHOTS:
        count = scene.chain.particles
        raise SceneError(
            "chain.particles",
            count,
            f"even the first and last poses do not fit: they need {needed}",
        )
    raise SceneError("run.snapshots", snapshots, f"needs {needed}; {fit} snapshots would fit")


def _size(count: int) -> str:
    unit, power = ("GiB", 30) if count >= 2**30 else ("MiB", 20) if count >= 2**20 else ("kiB", 10)
    return f"{count / 2**power:.3g} {unit}"
