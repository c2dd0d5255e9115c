"""One point of a sweep: its run, what is observed of it, and what it cost."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from nrchain.errors import TrajectoryError
from nrchain.jobs.ledger import Result
from nrchain.outcome import Cause
from nrchain.run.interruption import Interruption
from nrchain.run.preparation import check_start
from nrchain.run.simulation import simulate_in_memory, simulate_to_file
from nrchain.scene.scene import Scene
from nrchain.sweeps.observables import Observable, observe
from nrchain.trajectory.trajectory import Trajectory
from nrchain.version import versions

TRAJECTORIES = "trajectories"
"""Folder of the trajectories that are kept, in the folder of a sweep."""

UNFINISHED = (Cause.INTERRUPTED, Cause.ERROR)
"""Causes of a stop after which a point is run again."""


def run_point(
    scene: Scene,
    observables: Mapping[str, Observable | None],
    earlier: Result,
    folder: Path | None,
    name: str,
    *,
    interruption: Interruption | None,
) -> Result:
    """The result of a point, with what its ``earlier`` result observed.

    With a ``folder``, the trajectory is kept there, and one that is there already is not run again.
    """
    warnings: list[str] = []
    file = None if folder is None else folder / TRAJECTORIES / f"{name}.h5"
    trajectory = _kept(scene, file)
    if trajectory is None:
        trajectory = _run(scene, file, warnings, interruption)
    values, reasons = observe(trajectory, observables)
    return {
        "outcome": trajectory.status,
        "cause": trajectory.cause and str(trajectory.cause),
        "reason": trajectory.reason,
        "observables": {**earlier.get("observables", {}), **values},
        "unmeasured": {**earlier.get("unmeasured", {}), **reasons},
        "counters": dict(trajectory.counters),
        "warnings": warnings,
        "versions": dict(versions()),
        "trajectory": file and f"{TRAJECTORIES}/{file.name}",
    }


def _run(
    scene: Scene, file: Path | None, warnings: list[str], interruption: Interruption | None
) -> Trajectory:
    start = check_start(scene)
    if file is None:
        return simulate_in_memory(start, report=warnings.append, interruption=interruption)
    file.parent.mkdir(parents=True, exist_ok=True)
    return simulate_to_file(
        start, file, overwrite=True, report=warnings.append, interruption=interruption
    )


def _kept(scene: Scene, file: Path | None) -> Trajectory | None:
    """The finished run of this scene in a file; None where there is none."""
    if file is None or not file.exists():
        return None
    try:
        trajectory = Trajectory.open(file)
    except TrajectoryError:
        return None
    ended = trajectory.status != "running" and trajectory.cause not in UNFINISHED
    return trajectory if ended and trajectory.scene == scene else None
