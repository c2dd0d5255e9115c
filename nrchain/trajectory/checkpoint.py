"""Where a run can be resumed, and what it counts, as numbers of the file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nrchain.trajectory import layout as h5md
from nrchain.trajectory.checked_datasets import dataset, require_array
from nrchain.trajectory.layout import COUNTERS


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """All that a run needs to resume at ``time``.

    ``positions (N, 3)`` and ``frames (N, 3, 3)`` are the poses, ``snapshot`` the index of the next
    snapshot to write. ``spin`` and ``drift (3,)`` are the angular velocity and the velocity of
    the frame of reference of the integrator, ``counters`` the counts so far.
    """

    time: float
    positions: np.ndarray
    frames: np.ndarray
    snapshot: int
    spin: float
    drift: np.ndarray
    counters: Mapping[str, float] = field(default_factory=dict)


def latest_checkpoint(file: Any, particles: int) -> Checkpoint | None:
    """The newest complete checkpoint of a file, or None before the first."""
    sequence = dataset(file, f"{h5md.CHECKPOINTS}/sequence", (2,), "i")[()]
    if not sequence.any():
        return None
    slot, width = int(np.argmax(sequence)), h5md.CHECKPOINT_STATE + len(COUNTERS)
    state = dataset(file, f"{h5md.CHECKPOINTS}/state", (2, width))[slot]
    positions = dataset(file, f"{h5md.CHECKPOINTS}/position", (2, particles, 3))[slot]
    frames = dataset(file, f"{h5md.CHECKPOINTS}/frame", (2, particles, 3, 3))[slot]
    for name, values in {"state": state, "position": positions, "frame": frames}.items():
        require_array(values, values.shape, f"{h5md.CHECKPOINTS}/{name}")
    time, snapshot, spin, *rest = state.tolist()
    return Checkpoint(
        time=time,
        positions=positions,
        frames=frames,
        snapshot=int(snapshot),
        spin=spin,
        drift=np.array(rest[:3]),
        counters=counter_table(rest[3:]),
    )


def counter_numbers(table: Mapping[str, float]) -> list[float]:
    """The numbers of a table of counters, in the order of the file."""
    unknown = sorted(table.keys() - set(COUNTERS))
    if unknown:
        raise ValueError(f"{unknown[0]!r} is not a counter; the counters are {', '.join(COUNTERS)}")
    return [float(table.get(name, 0)) for name in COUNTERS]


def counter_table(numbers: Iterable[float]) -> dict[str, float]:
    """The table of counters from its numbers: integers, except the times."""
    table = dict(zip(COUNTERS, numbers, strict=True))
    for name, count in table.items():
        if not 0 <= count < np.inf:
            raise ValueError(f"{h5md.COUNTS}: {name} = {count}")
    return {name: float(n) if name in h5md.TIMES else int(n) for name, n in table.items()}
