"""What a study does in processes of their own: ``python -m validation.hard_cases.child TASK``.

The task is a name; its arguments come as JSON on standard input and its answer goes as JSON to
standard output. Kernels are loaded from disk here, not compiled, once one such process has run.
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
from validation.hard_cases.outputs import on_small_disk, plain

Answer = dict[str, Any]


def digest(scene: str) -> Answer:
    """The bits that a run ends with."""
    return {"digest": _bits(simulate(Scene.from_toml(scene)))}


def write(scene: str, path: str) -> Answer:
    """Run into a file, once the kernels are there; how long it took, and every write to the file.

    Every number that goes to the file is counted: poses, marks, counters and checkpoints.
    """
    spec = Scene.from_toml(scene)
    simulate(spec)
    written: list[str] = []
    began = clock.perf_counter()
    with _watching(written):
        simulate(spec, output=path, overwrite=True)
    return {"written": written, "seconds": clock.perf_counter() - began}


def kill(scene: str, paths: list[str], places: list[int], seconds: list[float]) -> Answer:
    """Run into each file in a process that is killed: before a write, by its count, or in time.

    The processes are forks of this one, which has loaded the kernels: a run begins at once. Where
    the place is 0 the moment is ``seconds`` after the beginning. Answers whether each was killed.
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
    """Add the name of each data set to ``written`` as it is written to, and die at a given one."""
    write_item = h5py.Dataset.__setitem__

    def counted(dataset: Any, where: Any, values: Any) -> None:
        written.append(dataset.name)
        if len(written) == kill_at:
            os.kill(os.getpid(), signal.SIGKILL)
        write_item(dataset, where, values)

    with patch.object(h5py.Dataset, "__setitem__", counted):
        yield


def resume(paths: list[str], scene: str) -> Answer:
    """Go on with runs that were killed: how each stood, the time it went on from, and its bits.

    Beside them the bits of the whole run, whose kernels are loaded as theirs are.
    """
    found = []
    for path in map(Path, paths):
        left = Trajectory.open(path) if path.exists() else None
        checkpoint = left.latest_checkpoint() if left else None
        try:
            run = resume_run(path)
        except TrajectoryError:
            # killed before its first checkpoint: said so, and is run again
            run = simulate(Scene.from_toml(scene), output=path, overwrite=True)
        found.append(
            {
                "status": left.status if left else "no file",
                "snapshots": len(left.time) if left else 0,
                "from": checkpoint.time if checkpoint else None,
                "digest": _bits(run),
            }
        )
    return {"runs": found, "digest": digest(scene)["digest"]}


def soak(scene: str, path: str, warm: int) -> Answer:
    """The peak of memory, in kB, once a run has taken ``warm`` steps, and at its end."""
    seen: dict[str, int] = {}

    def note(progress: Any) -> None:
        if progress.counters["steps"] >= warm:
            seen.setdefault("warm", _peak())

    run = simulate(Scene.from_toml(scene), output=path, overwrite=True, progress=note)
    grown = _peak() - seen["warm"]
    return {"grown": grown, "peak": _peak(), "steps": run.counters["steps"]}


def outputs(place: str) -> Answer:
    """What came of outputs that cannot be written or read, on whatever disk ``place`` is."""
    return {"told": plain(place)}


def small_disk(place: str) -> Answer:
    """The same on a disk of a quarter of a megabyte, mounted for this process."""
    return {"told": on_small_disk(place)}


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
