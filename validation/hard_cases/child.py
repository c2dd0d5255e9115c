"""Tasks of the study in separate processes: ``python -m validation.hard_cases.child TASK``.

Arguments are JSON on standard input, the answer is JSON on standard output. After the first such
process, kernels are loaded from disk.
"""

from __future__ import annotations

import hashlib
import json
import os
import resource
import signal
import sys
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import h5py

from nrchain import Scene, Trajectory, TrajectoryError, simulate
from nrchain import resume as resume_run
from nrchain.trajectory import rows
from validation.hard_cases.outputs import on_small_disk, plain

Answer = dict[str, Any]


def digest(scene: str) -> Answer:
    """Hash of the result of a run."""
    return {"digest": _bits(simulate(Scene.from_toml(scene)))}


def write(scene: str, path: str) -> Answer:
    """Run into a file with kernels loaded; return the time and every write to the file.

    All writes count: poses, marks, counters and checkpoints.
    """
    spec = Scene.from_toml(scene)
    simulate(spec)
    written: list[str] = []
    began = clock.perf_counter()
    with _watching(written):
        simulate(spec, output=path, overwrite=True)
    return {"written": written, "seconds": clock.perf_counter() - began}


def kill(scene: str, paths: list[str], places: list[int], seconds: list[float]) -> Answer:
    """Run into each file in a process, and kill it before a given write or after a given time.

    The processes are forks of this one, which has loaded the kernels, so a run starts at once. If
    the place is 0, the kill comes ``seconds`` after the start. Returns whether each was killed.
    """
    spec = Scene.from_toml(scene)
    simulate(spec)
    killed = []
    for path, place, moment in zip(paths, places, seconds, strict=True):
        child = os.fork()
        if child == 0:
            with _watching([], place):
                simulate(spec, output=path, overwrite=True)
            os._exit(0)
        if place == 0:
            clock.sleep(moment)
            os.kill(child, signal.SIGKILL)
        killed.append(os.WIFSIGNALED(os.waitpid(child, 0)[1]))
    return {"killed": killed}


@contextmanager
def _watching(written: list[str], kill_at: int = 0) -> Iterator[None]:
    """Append the name of each data set written to ``written``; kill the process at ``kill_at``."""

    def counted(write: Callable[..., None]) -> Callable[..., None]:
        def count_and_write(dataset: Any, *what: Any) -> None:
            written.append(dataset.name)
            if len(written) == kill_at:
                os.kill(os.getpid(), signal.SIGKILL)
            write(dataset, *what)

        return count_and_write

    # snapshots and counters are rows, the rest are items
    with (
        patch.object(rows, "put", counted(rows.put)),
        patch.object(h5py.Dataset, "__setitem__", counted(h5py.Dataset.__setitem__)),
    ):
        yield


def resume(paths: list[str], scene: str) -> Answer:
    """Resume killed runs; return the state of each file, the time of resumption and the hash.

    The answer also has the hash of an uninterrupted run with loaded kernels.
    """
    found = []
    for path in map(Path, paths):
        left = Trajectory.open(path) if path.exists() else None
        checkpoint = None if left is None else left.latest_checkpoint()
        try:
            run = resume_run(path)
        except TrajectoryError:
            # killed before its first checkpoint: refused, and run again
            run = simulate(Scene.from_toml(scene), output=path, overwrite=True)
        found.append(
            {
                "status": "no file" if left is None else left.status,
                "snapshots": 0 if left is None else len(left),
                "from": checkpoint.time if checkpoint else None,
                "digest": _bits(run),
            }
        )
    return {"runs": found, "digest": digest(scene)["digest"]}


def soak(scene: str, path: str, warm: int) -> Answer:
    """Growth of peak memory, in kB, from step ``warm`` to the end of a run."""
    seen: dict[str, int] = {}

    def note(progress: Any) -> None:
        if progress.counters["steps"] >= warm:
            seen.setdefault("warm", _peak())

    run = simulate(Scene.from_toml(scene), output=path, overwrite=True, progress=note)
    grown = _peak() - seen["warm"]
    return {"grown": grown, "peak": _peak(), "steps": run.counters["steps"]}


def outputs(place: str) -> Answer:
    """Messages for outputs that cannot be written or read, in the folder ``place``."""
    return {"messages": plain(place)}


def small_disk(place: str) -> Answer:
    """The same on a disk of 256 kB that is mounted for this process."""
    return {"messages": on_small_disk(place)}


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _bits(run: Trajectory) -> str:
    arrays = (run.time, run.positions, run.frames)
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


TASKS: dict[str, Callable[..., Answer]] = {
    task.__name__: task for task in (digest, write, kill, resume, soak, outputs, small_disk)
}

if __name__ == "__main__":
    answer = TASKS[sys.argv[1]](**json.load(sys.stdin))
    print(json.dumps(answer))
