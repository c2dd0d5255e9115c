"""How much a trajectory takes, in memory and on disk, and whether there is room for it."""

from __future__ import annotations

from nrchain.errors import SceneError
from nrchain.scene.scene import Scene

CHECKPOINT_POSES = 2
"""Poses of the chain that a file keeps besides its snapshots."""

SNAPSHOT_MARKS = 3 * 8
"""Bytes of a snapshot besides its poses: its time, the time asked for, its step."""

BOX_BYTES = 3 * 8
"""What the edges of the box of a periodic chain take in every snapshot."""

LEAST_SNAPSHOTS = 2
"""A run records its start and its end."""


def pose_bytes(scene: Scene) -> int:
    """What the poses of one snapshot take: three coordinates and nine frame components a sphere."""
    return 12 * 8 * scene.chain.particles


def refuse_snapshots(scene: Scene, free: int, where: str, snapshots: int | None = None) -> None:
    """Raise :class:`~nrchain.errors.SceneError` if the snapshots need more than ``free`` bytes.

    They are those of the scene, unless their number is given.
    """
    each = pose_bytes(scene) + SNAPSHOT_MARKS
    if scene.chain.ends == "periodic":
        each += BOX_BYTES
    snapshots = scene.run.snapshots if snapshots is None else snapshots
    if each * snapshots <= free:
        return
    free = max(free, 0)
    fit = free // each
    told = f"{_size(each * snapshots)}, where {_size(free)} are {where}"
    if fit < LEAST_SNAPSHOTS:
        count = scene.chain.particles
        raise SceneError("chain.particles", count, f"not even the first and last poses fit: {told}")
    raise SceneError("run.snapshots", snapshots, f"needs {told}; {fit} would fit")


def _size(count: int) -> str:
    unit, power = ("GiB", 30) if count >= 2**30 else ("MiB", 20) if count >= 2**20 else ("kiB", 10)
    return f"{count / 2**power:.3g} {unit}"
