"""The file of a run made anew for a later end, with all that the run has reached.

A file has room for the snapshots of its scene and no more. A longer one is written beside it and
takes its name once it is complete: a kill at any moment leaves the one or the other.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from nrchain.planning.choice import Choice
from nrchain.scene.scene import Scene
from nrchain.trajectory import layout as h5md
from nrchain.trajectory.checked_datasets import damage_errors
from nrchain.trajectory.file import file_errors, open_file, protected, refuse_full_disk
from nrchain.trajectory.new_file import write_new_file
from nrchain.trajectory.provenance import Provenance
from nrchain.trajectory.reader import finished_snapshots

_KEPT = (
    h5md.COUNTS,
    *(f"{h5md.CHECKPOINTS}/{name}" for name in ("sequence", "position", "frame", "state")),
)
"""What does not depend on the number of snapshots."""


def extend_file(
    path: Path, scene: Scene, times: np.ndarray, choice: Choice | None, provenance: Provenance
) -> None:
    """Give the file of a run a later end: ``scene`` has it, and snapshots at ``times (T,)``.

    The caller holds the write lock. The run is marked as running.

    Raises :class:`~nrchain.errors.SceneError` for more snapshots than the disk has room for, and
    :class:`~nrchain.errors.TrajectoryError` for a file that is damaged or cannot be replaced.
    """
    target = refuse_full_disk(path, scene, len(times))
    partial = target.with_name(target.name + ".partial")
    texts = choice.to_json() if choice else "", target, provenance.to_json()
    with file_errors(path, "cannot be extended"), protected(path):
        try:
            write_new_file(partial, scene, times, *texts)
            _copy(path, partial)
            os.replace(partial, target)
        except BaseException:
            partial.unlink(missing_ok=True)
            raise


def _copy(path: Path, partial: Path) -> None:
    """Copy the finished snapshots, the checkpoints and the counters to the new file."""
    with open_file(path, "r") as old, open_file(partial, "r+") as new, damage_errors(path):
        count = finished_snapshots(old)
        for name in h5md.snapshot_series(old):
            new[name].resize(count, axis=0)
            new[name][...] = old[name][:count]
        for name in _KEPT:
            new[name][...] = old[name][()]
        new[h5md.FINISHED][0] = count
