"""Is the error that a run with ``run.verify`` estimates of itself its error?

Random chains with fixed seeds run with ``run.verify``. Their error is the distance from a run of
another integrator at a far smaller tolerance. A second such run, by the same integrator, says how
far the first can be trusted. Scenes are left out if the two are farther apart than a twentieth of
the error, or if a run stops before its end.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, islice
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nrchain import Scene, SceneError, Trajectory, load_scene, simulate, simulate_many
from nrchain.planning.integrator import integrator_of
from validation.report.random_scenes import random_scene
from validation.report.recorder import Recorder
from validation.report.style import MARKERS, SHADES

REFERENCES = {"radau": 1e-3, "cvode": 2e-4}
"""Tolerance of the reference runs over that of the run, by integrator."""

MISSED = 0.05
"""Part of the scenes whose estimate may be farther off: see the text of the study."""

STEPS = {"radau": 2000, "cvode": 20_000}
"""A scene of which a run needs more steps is left out, by integrator."""

TRUSTED = 0.05
"""Largest distance of the two references over the error."""

VISIBLE = 0.01
"""Errors above this part of the tolerance count in the comparison of single snapshots."""

FACTOR = 3.0
"""Within which an estimate is to be."""


@dataclass(frozen=True)
class Compared:
    """Estimates and errors (2, T) of a scene, of positions in radii and of frames in radians.

    ``cost`` is the number of right-hand sides of the second run over those of the first.
    """

    seed: int
    tolerance: float
    estimates: np.ndarray
    errors: np.ndarray
    cost: float

    @property
    def ratios(self) -> np.ndarray:
        """Estimate over error of the largest over the snapshots, (2,)."""
        return self.estimates.max(axis=1) / self.errors.max(axis=1)


def study(recorder: Recorder) -> None:
    recorder.step("random scenes")
    wanted = 6 if recorder.quick else 40
    found = list(islice(_compared(), wanted))
    ratios = np.concatenate([one.ratios for one in found])
    within = np.array([np.all(_near(one.ratios)) for one in found])
    recorder.bound(
        f"scenes of {wanted} whose largest estimates are within a factor of 3 of their errors",
        int(within.sum()),
        least=(1.0 - MISSED) * wanted,
        source="a second run with a tenth of the tolerances",
    )
    recorder.text(
        "An estimate misses what neither run resolves. The stiff chain of seed 5 bends by 0.2 a "
        "within t = 0.01, from below the tolerance, and straightens again. Runs of Radau at 1e-4 "
        "to 1e-7 step over that bend. They agree with each other, and are 2.5e-3 a off at t = 5."
    )
    snapshots = np.concatenate([_snapshots(one) for one in found])
    recorder.bound(
        "part of the snapshots whose estimate is within a factor of 3 of the error",
        float(_near(snapshots).mean()),
        least=0.95,
        source=f"{len(snapshots)} errors of positions and frames above {VISIBLE:g} times the "
        "tolerance",
    )
    costs = [one.cost for one in found]
    recorder.bound(
        "right-hand sides of the second run over those of the first, median",
        float(np.median(costs)),
        most=2.0,
        source="the project's bar",
    )
    recorder.table(
        "What an estimate is off by, and what it costs",
        ["", "Least", "Median", "Largest"],
        [
            ("largest estimate over largest error, a scene", *_spread(ratios)),
            ("estimate over error, a snapshot", *_spread(snapshots)),
            ("right-hand sides of the second run over those of the first", *_spread(costs)),
        ],
        f"{wanted} random scenes. Estimates of positions and of frames count alike.",
    )
    recorder.figure("estimates", _figure(found), "Estimated error of a run against its error.")
    recorder.step("what it costs")
    _time(recorder)


def _compared() -> Iterator[Compared]:
    """The scenes that run to their end and have a reference, from seed 0 on."""
    for seed in count():
        one = _compare(seed, random_scene(seed))
        if one is not None:
            yield one


def _compare(seed: int, scene: Scene) -> Compared | None:
    tolerance = scene.run.rtol
    mine = integrator_of(scene)
    other = "radau" if mine == "cvode" else "cvode"

    def at(part: float, integrator: str, **changes: Any) -> Scene:
        chosen = {
            "run.rtol": part * tolerance,
            "run.atol": part * tolerance,
            "run.integrator": integrator,
            "run.max_steps": STEPS[integrator],
        }
        return load_scene(scene, **(chosen | changes))

    runs = _finished([at(1.0, mine, **{"run.verify": True}), at(0.1, mine)])
    references = runs and _finished([at(REFERENCES[name], name) for name in (other, mine)])
    if not runs or not references:
        return None
    (run, second), (reference, again) = runs, references
    errors, doubts = _errors(run, reference), _errors(again, reference)
    if np.any(doubts.max(axis=1) > TRUSTED * errors.max(axis=1)):
        return None
    assert run.position_error is not None
    assert run.frame_error is not None
    estimates = np.array([run.position_error / scene.chain.radius, run.frame_error])
    cost = second.counters["evaluations"] / run.counters["evaluations"]
    return Compared(seed, tolerance, estimates, errors, cost)


def _finished(scenes: list[Scene]) -> list[Trajectory] | None:
    """The trajectories of all scenes; None if one is refused or stops."""
    try:
        members = sorted(simulate_many(scenes), key=lambda member: member.index)
        runs = [member.result() for member in members]
    except SceneError:
        return None
    return runs if all(run.status == "completed" for run in runs) else None


def _errors(run: Trajectory, reference: Trajectory) -> np.ndarray:
    """max |r − r′|/a and max ∠(frame, frame′), (2, T); sin(∠/2) = ‖F − F′‖ / √8."""
    apart = np.linalg.norm(run.positions - reference.positions, axis=-1).max(axis=1)
    chord = np.linalg.norm(run.frames - reference.frames, axis=(2, 3)).max(axis=1)
    angle = 2.0 * np.arcsin(np.minimum(1.0, chord / np.sqrt(8.0)))
    return np.array([apart / run.scene.chain.radius, angle])


def _snapshots(one: Compared) -> np.ndarray:
    """Estimate over error of the snapshots whose error is visible."""
    visible = one.errors > VISIBLE * one.tolerance
    return one.estimates[visible] / one.errors[visible]


def _near(ratios: np.ndarray) -> np.ndarray:
    return (ratios < FACTOR) & (ratios > 1.0 / FACTOR)


def _spread(values: np.ndarray | list[float]) -> tuple[float, float, float]:
    least, median, largest = np.quantile(values, (0.0, 0.5, 1.0))
    return float(f"{least:.2g}"), float(f"{median:.2g}"), float(f"{largest:.2g}")


def _figure(found: list[Compared]) -> Figure:
    figure = Figure(figsize=(7.6, 3.6))
    for axes, kind, title in zip(
        figure.subplots(1, 2), (0, 1), ("positions [$a$]", "frames [rad]"), strict=True
    ):
        errors = np.concatenate([one.errors[kind, 1:] for one in found])
        estimates = np.concatenate([one.estimates[kind, 1:] for one in found])
        seen = (errors > 0.0) & (estimates > 0.0)
        axes.loglog(errors[seen], estimates[seen], ".", color="0.7", ms=2, label="snapshots")
        axes.loglog(
            [one.errors[kind].max() for one in found],
            [one.estimates[kind].max() for one in found],
            MARKERS[0], color=SHADES[0], mfc="white", label="largest of a scene",
        )  # fmt: skip
        ends = np.array([errors[seen].min(), errors[seen].max()])
        for factor, line in ((1.0, "-"), (FACTOR, ":"), (1.0 / FACTOR, ":")):
            axes.loglog(ends, factor * ends, line, color=SHADES[2], lw=0.8)
        axes.set(xlabel=f"error of {title}", ylabel="estimate")
        axes.legend()
    return figure


def _time(recorder: Recorder) -> None:
    """Wall time of the buckling scene with ``run.verify`` and without, in turns."""
    scenes = [load_scene("buckling", **{"run.verify": verify}) for verify in (False, True)]
    turns = [[_seconds(scene) for scene in scenes] for _ in range(6)][1:]
    plain, verified = np.median(turns, axis=0)
    recorder.benchmark(
        "the buckling scene with run.verify over without",
        plain,
        verified,
        what="wall time; the second run has a thread of its own",
    )


def _seconds(scene: Scene) -> float:
    begin = time.perf_counter()
    simulate(scene)
    return time.perf_counter() - begin
