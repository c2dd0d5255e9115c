"""The fields of a trajectory, read from its file."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.planning.choice import Choice
from nrchain.scene.scene import Scene
from nrchain.scene.toml import read_toml
from nrchain.trajectory import layout as h5md
from nrchain.trajectory.checked_datasets import dataset, read_code, read_text
from nrchain.trajectory.checkpoint import counter_table
from nrchain.trajectory.layout import COUNTERS
from nrchain.trajectory.provenance import FROM_SCENE, Provenance


def read_fields(file: Any) -> dict[str, Any]:
    """The fields of a :class:`~nrchain.trajectory.trajectory.Trajectory`, except its path."""
    scene = read_scene(file)
    count = finished_snapshots(file)
    reason = dataset(file, h5md.REASON, (1,), "S")[0].decode(errors="replace")
    time = snapshot_rows(file, f"{h5md.POSITION}/time", ())[:count]
    if not np.isfinite(time).all():
        raise ValueError(f"{h5md.POSITION}/time: not all values are finite")
    particles = scene.chain.particles
    return {
        "time": time,
        "positions": snapshot_rows(file, f"{h5md.POSITION}/value", (particles, 3))[:count],
        "frames": snapshot_rows(file, f"{h5md.FRAME}/value", (particles, 3, 3))[:count],
        "scene": scene,
        "counters": counter_table(dataset(file, h5md.COUNTS, (len(COUNTERS),))[()]),
        "status": read_code(file, h5md.STATUS, h5md.STATUSES),
        "reason": " ".join(reason.split()),
        "cause": read_code(file, h5md.CAUSE, h5md.CAUSES),
        "choice": read_choice(file),
        "provenance": read_provenance(file),
        **{
            name: snapshot_rows(file, f"{element}/value", ())[:count]
            for name, element in h5md.ERRORS.items()
            if element in file
        },
    }


def finished_snapshots(file: Any) -> int:
    """The number of finished snapshots: the smallest size of all series.

    While a run adds a snapshot, or if it was killed then, only some sizes include it.
    """
    count = int(dataset(file, h5md.FINISHED, (1,), "i")[0])
    if count < 0:
        raise ValueError(f"{h5md.FINISHED} is {count}")
    return min(count, *(int(file[name].shape[0]) for name in h5md.snapshot_series(file)))


def snapshot_rows(file: Any, name: str, shape: tuple[int, ...], kinds: str = "f") -> Any:
    """The data set of that name, with a row of that shape for each snapshot."""
    return dataset(file, name, (None, *shape), kinds)


def read_scene(file: Any) -> Scene:
    """The scene of the run, with the poses it was given."""
    table = read_toml(read_text(file, h5md.SCENE))
    for name, element in h5md.STARTS.items():
        if element in file:
            axes = (3,) if name == "positions" else (3, 3)
            table["start"][name] = snapshot_rows(file, element, axes)[()]
    return Scene.from_mapping(table)


def read_choice(file: Any) -> Choice | None:
    """The choice of effects = "auto", if the run has one."""
    return Choice.from_json(read_text(file, h5md.CHOICE)) if h5md.CHOICE in file else None


def read_provenance(file: Any) -> Provenance:
    """What the run started from. Files from before it was kept have none."""
    if h5md.PROVENANCE not in file:
        return FROM_SCENE
    return Provenance.from_json(read_text(file, h5md.PROVENANCE))
