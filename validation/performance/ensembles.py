"""Many buckling chains side by side: two threads against one."""

from __future__ import annotations

import time

import numpy as np

from nrchain import Scene, load_scene, simulate_many
from validation.report.recorder import Recorder


def compare(recorder: Recorder) -> None:
    """The same chains by one worker and by two, in turns: seconds, and bits."""
    count, turns = (10, 1) if recorder.quick else (60, 3)
    scenes = [
        load_scene("buckling", **{"slip.2s": 60.0 + 80.0 * k / count, "start.seed": k})
        for k in range(count)
    ]
    _timed(scenes[:2], 2)
    pairs = [(_timed(scenes, 1), _timed(scenes, 2)) for _ in range(turns)]
    one, two = (float(np.median([pair[k][0] for pair in pairs])) for k in (0, 1))
    recorder.benchmark(
        "an ensemble with two workers against one",
        two,
        one,
        what=f"{count} buckling chains of 20 spheres whose strengths and seeds differ, by "
        f"simulate_many, {turns} turn{'s' if turns > 1 else ''}",
    )
    apart = max(np.abs(pair[0][1] - pair[1][1]).max() for pair in pairs)
    recorder.bound(
        "largest distance between the chains of one worker and of two (a)",
        apart,
        most=0.0,
        source="each chain is a run of its own",
    )


def _timed(scenes: list[Scene], workers: int) -> tuple[float, np.ndarray]:
    """Seconds of an ensemble, and the last positions of its chains."""
    begin = time.perf_counter()
    members = sorted(simulate_many(scenes, workers=workers), key=lambda member: member.index)
    seconds = time.perf_counter() - begin
    return seconds, np.array([member.result().positions[-1] for member in members])
