"""What a trajectory file holds: finished snapshots, the scene, how the run stands."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.planning.choice import Choice
from nrchain.scene.scene import Scene
from nrchain.scene.toml import read_toml
from nrchain.trajectory import layout as h5md
from nrchain.trajectory.checkpoint import counter_table
from nrchain.trajectory.layout import COUNTERS
from nrchain.trajectory.stored import dataset, meaning, text


def contents(file: Any) -> dict[str, Any]:
    """The fields of a :class:`~nrchain.trajectory.trajectory.Trajectory`, but for its path."""
    scene = stored_scene(file)
    count = finished(file)
    reason = dataset(file, h5md.REASON, (1,), "S")[0].decode(errors="replace")
    time = rows(file, f"{h5md.POSITION}/time", ())[:count]
    if not np.isfinite(time).all():
        raise ValueError(f"{h5md.POSITION}/time: not all values are finite")
    particles = scene.chain.particles
    return {
        "time": time,
        "positions": rows(file, f"{h5md.POSITION}/value", (particles, 3))[:count],
        "frames": rows(file, f"{h5md.FRAME}/value", (particles, 3, 3))[:count],
        "scene": scene,
        "counters": counter_table(dataset(file, h5md.COUNTS, (len(COUNTERS),))[()]),
        "status": meaning(file, h5md.STATUS, h5md.STATUSES),
        "reason": " ".join(reason.split()),
        "cause": meaning(file, h5md.CAUSE, h5md.CAUSES),
        "choice": stored_choice(file),
    }


def finished(file: Any) -> int:
    """How many snapshots a file has.

    A run that was killed while it set the sizes of the series has set those of some of them: the
    others tell, and so they do while a run goes on.
    """
    count = int(dataset(file, h5md.FINISHED, (1,), "i")[0])
    if count < 0:
        raise ValueError(f"{h5md.FINISHED} is {count}")
    return min(count, *(int(file[name].shape[0]) for name in h5md.series(file)))


def rows(file: Any, name: str, shape: tuple[int, ...], kinds: str = "f") -> Any:
    """The data set of that name with a row of that shape for every snapshot."""
    return dataset(file, name, (None, *shape), kinds)


def stored_scene(file: Any) -> Scene:
    """What was run, with the poses it was given."""
    table = read_toml(text(file, h5md.SCENE))
    for name, element in h5md.STARTS.items():
        if element in file:
            axes = (3,) if name == "positions" else (3, 3)
            table["start"][name] = rows(file, element, axes)[()]
    return Scene.from_mapping(table)


def stored_choice(file: Any) -> Choice | None:
    """What effects chosen for a tolerance leave out."""
    return Choice.from_json(text(file, h5md.CHOICE)) if h5md.CHOICE in file else None
