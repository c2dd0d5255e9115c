"""Many buckling chains side by side: two threads, and two processes, against one thread."""

from __future__ import annotations

import time
from concurrent.futures import Executor, ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from nrchain import Scene, load_scene, simulate_many
from validation.report.recorder import Recorder


def compare(recorder: Recorder) -> None:
    """The same chains by one worker, by two and by two processes, in turns: seconds, and bits."""
    count, turns = (10, 1) if recorder.quick else (100, 5)
    scenes = [
        load_scene("buckling", **{"slip.2s": 60.0 + 80.0 * k / count, "start.seed": k})
        for k in range(count)
    ]
    with ProcessPoolExecutor(2, mp_context=get_context("forkserver")) as pool:
        ways: dict[str, tuple[int, Executor | None]] = {
            "one thread": (1, None),
            "two threads": (2, None),
            "two processes": (2, pool),
        }
        # processes start, and load their kernels
        for workers, executor in ways.values():
            _timed(scenes[:4], workers, executor)
        found = [{name: _timed(scenes, *way) for name, way in ways.items()} for _ in range(turns)]
    seconds = {name: float(np.median([turn[name][0] for turn in found])) for name in ways}
    for name, least in (("two threads", 1.2), ("two processes", 1.5)):
        recorder.benchmark(
            f"an ensemble with {name} against one",
            seconds[name],
            seconds["one thread"],
            what=f"{count} buckling chains of 20 spheres whose strengths and seeds differ, by "
            f"simulate_many, {turns} turn{'s' if turns > 1 else ''}",
        )
        if not recorder.quick:
            ratio = seconds["one thread"] / seconds[name]
            recorder.bound(f"speed of {name} over one", ratio, least=least, source=WHY)
    for name, most in (("two threads", 0.0), ("two processes", 1e-9)):
        apart = max(np.abs(turn[name][1] - turn["one thread"][1]).max() for turn in found)
        recorder.bound(
            f"largest distance between the chains of one worker and of {name} (a)",
            apart,
            most=most,
            source="each chain is a run of its own; kernels compiled or loaded differ in rounding",
        )


WHY = "threads take turns in Python, some 1.5 ms of each run; processes hand over their results"


def _timed(
    scenes: list[Scene], workers: int, executor: Executor | None
) -> tuple[float, np.ndarray]:
    """Seconds of an ensemble, and the last positions of its chains."""
    begin = time.perf_counter()
    found = simulate_many(scenes, workers=workers, executor=executor)
    members = sorted(found, key=lambda member: member.index)
    seconds = time.perf_counter() - begin
    return seconds, np.array([member.result().positions[-1] for member in members])
