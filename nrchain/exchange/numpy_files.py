"""NumPy's ``.npz``: ``time`` (T,), ``positions`` (T, N, 3), ``frames`` (T, N, 3, 3), all digits.

``scene`` is the scene as TOML, ``record`` the record as JSON. Nothing is pickled.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nrchain.errors import TrajectoryError
from nrchain.exchange.record import FramePoses, Record, pick_frame
from nrchain.trajectory.trajectory import Trajectory

ARRAYS = ("time", "positions", "frames")


def write(trajectory: Trajectory, record: Record, path: Path) -> None:
    """Write an ``.npz``."""
    arrays = {name: getattr(trajectory, name) for name in ARRAYS}
    for name in ("position_error", "frame_error"):
        if getattr(trajectory, name) is not None:
            arrays[name] = getattr(trajectory, name)
    texts = {"scene": np.array(record.scene), "record": np.array(record.to_json())}
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays, **texts)


def read(path: Path, index: int) -> FramePoses:
    """Frame ``index`` of an ``.npz`` with these arrays."""
    with np.load(path, allow_pickle=False) as file:
        missing = [name for name in ARRAYS if name not in file]
        if missing:
            raise TrajectoryError(
                f"{path}: has no array {missing[0]!r}; it must have time (T,), "
                "positions (T, N, 3) and frames (T, N, 3, 3)"
            )
        time, positions, frames = (file[name] for name in ARRAYS)
        record = str(file["record"]) if "record" in file else ""
    place = pick_frame(path, index, len(time))
    return FramePoses(
        positions[place], frames[place], place, float(time[place]), Record.from_json(record)
    )
