"""What a state costs beside the run that settles in it, and a state of a branch beside a search."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from statistics import median

import nrchain
from validation.report.recorder import Recorder
from validation.states.buckling import ISSUE, LINKS

LONG, REPEATS = 200, 5

SETTLED = 1e-6
"""Part of the bend that is left where a run has settled, at the rate of the leading mode."""

REACHED = {"nearest neighbours": 0.12, "all pairs": 0.22}
"""Ratios measured; 10 was asked for."""


def speed(recorder: Recorder) -> None:
    """Both comparisons, in turns."""
    for reach, push in (("nearest neighbours", 55.0), ("all pairs", 25.0)):
        if recorder.quick and reach == "all pairs":
            continue
        _state_against_run(recorder, reach, push)
    _branch_against_searches(recorder)


def _state_against_run(recorder: Recorder, reach: str, push: float) -> None:
    """A buckled chain of N = 200: found from the straight chain, and reached by a run."""
    scene = nrchain.load_scene(
        "buckling",
        **LINKS,
        **{
            "chain.particles": LONG,
            "slip.2s": push * (19.0 / (LONG - 1)) ** 2,
            "slip.neighbours": "all" if reach == "all pairs" else 1,
            "start.amplitude": 0.1,
        },
    )
    found = nrchain.find_state(scene, nudge=0.1)
    grows = nrchain.spectrum(scene).leading.growth
    end = -math.log(1.0 / SETTLED) / found.spectrum.leading.growth + 5.0 / grows
    settles = nrchain.load_scene(scene, **{"run.end": end, "run.snapshots": 11})
    ours, theirs = _in_turns(
        lambda: nrchain.find_state(scene, nudge=0.1, modes=1),
        lambda: nrchain.simulate(settles),
        1 if recorder.quick else REPEATS,
    )
    recorder.shortfall(
        f"N = {LONG}, {reach}: time of a run that settles over that of a state with its spectrum",
        theirs / ours,
        asked=10.0,
        reached=REACHED[reach],
        source="the run takes some hundred implicit steps in machine code",
    )
    recorder.benchmark(
        f"state, {reach}", ours, theirs, what=f"a buckled state of N = {LONG}, against a run to it"
    )


def _branch_against_searches(recorder: Recorder) -> None:
    """A branch of bent states, N = 20, against a search from state to state."""
    scene = nrchain.load_scene("buckling", **ISSUE, **{"slip.2s": 60.0})
    bent = nrchain.find_state(scene, nudge=0.1)
    along = {"slip.2s": (60.0, 200.0)}
    branch = nrchain.continue_state(scene, along, bent, branches=1).branches[0]
    targets = [nrchain.load_scene(scene, **{"slip.2s": float(v)}) for v in branch.values[1:]]

    def search() -> None:
        state = bent
        for target in targets:
            state = nrchain.find_state(target, state, modes=1)

    ours, theirs = _in_turns(
        lambda: nrchain.continue_state(scene, along, bent, branches=1),
        search,
        1 if recorder.quick else REPEATS,
    )
    recorder.bound(
        "time of a state of a branch, with all rates, over that of Newton's method with one",
        ours / theirs,
        most=3.0,
        source=f"{len(targets)} states from V = 60 to 200, each from the one before",
    )


def _in_turns(
    first: Callable[[], object], second: Callable[[], object], repeats: int
) -> tuple[float, float]:
    """Medians of the seconds of both."""
    seconds: list[list[float]] = [[], []]
    for _ in range(repeats):
        for task, taken in zip((first, second), seconds, strict=True):
            begin = time.perf_counter()
            task()
            taken.append(time.perf_counter() - begin)
    return median(seconds[0]), median(seconds[1])
