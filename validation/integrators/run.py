"""Which integrator for which class of scene, and what does ``run.rtol`` say of the global error?

The shipped scenes, the completed cases of the gallery and 40 random scenes run with each integrator
at tolerances rtol = atol from 1e-3 to 1e-8. Errors are distances from a run of Radau IIA at a far
smaller tolerance; a run of CVODE at 2e-11 checks it. Times are processor times, medians of
repetitions that take turns. Every scene counts in all classes that it belongs to.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from validation.integrators import figures, promise
from validation.integrators.runs import (
    COMPLETED,
    INTEGRATORS,
    MEET,
    REPEATS,
    TOLERANCES,
    Mapped,
    map_scene,
    shorten,
)
from validation.integrators.scenes import CLASSES, FAR, NEAR, QUICK, scenes
from validation.report.recorder import Recorder
from validation.report.threads import one_thread

LEVELS = (1e-3, 1e-4, 1e-6)
"""Errors at which times are compared, in radii and radians."""

REFERENCED = 0.9
"""Least part of the scenes with a reference."""


def study(recorder: Recorder) -> None:
    with one_thread():
        found, without = _map(recorder)
    groups = {name: [one for one in found if name in one.classes] for name in CLASSES}
    groups = {name: members for name, members in groups.items() if members}
    _check(recorder, found, without)
    for name, chosen, other in ((NEAR, "radau", "cvode"), (FAR, "cvode", "radau")):
        if name in groups:
            recorder.bound(
                f"{name}: part of the runs of {chosen} with an error of at most 10 rtol",
                promise.below(promise.ratios(groups[name], chosen)),
                least=promise.PART,
                source="nine scenes of ten, with the integrator that 'auto' takes",
            )
            recorder.bound(
                f"{name}: time of {chosen} over that of {other} at an error of 1e-4",
                promise.speed(groups[name], chosen, other, 1e-4)[0],
                most=1.0,
                source="run.integrator = 'auto' takes the faster",
            )
    _tabulate_speeds(recorder, groups)
    _tabulate_promise(recorder, found, groups)
    _tabulate_ends(recorder, found, without)
    recorder.figure(
        "map",
        figures.work_precision(groups),
        "Global error against processor time, for tolerances from 1e-3 (upper left) to 1e-8: "
        "medians over the scenes of a class, with the quartiles of the error.",
    )
    recorder.figure(
        "tolerance",
        figures.histogram(found),
        "Global error over tolerance of all runs. Shaded: within a factor of 10.",
    )
    _tabulate_runs(recorder, found)


def _map(recorder: Recorder) -> tuple[list[Mapped], dict[str, str]]:
    """The scenes that have a reference, and how the reference of the others ends."""
    tolerances = TOLERANCES[::2] if recorder.quick else TOLERANCES
    found: list[Mapped] = []
    without: dict[str, str] = {}
    for name, scene in scenes().items():
        if recorder.quick and name not in QUICK:
            continue
        recorder.step(name)
        one = map_scene(name, shorten(scene), tolerances, 1 if recorder.quick else REPEATS)
        if isinstance(one, Mapped):
            found.append(one)
        else:
            without[name] = one
    return found, without


def _check(recorder: Recorder, found: Sequence[Mapped], without: dict[str, str]) -> None:
    recorder.bound(
        f"part of the scenes in which two schemes at their tightest meet within {MEET:g}",
        len(found) / (len(found) + len(without)),
        least=REFERENCED,
        source="CVODE's BDF and Radau IIA share the right-hand side, no more",
    )
    for integrator in INTEGRATORS:
        recorder.bound(
            f"{integrator}: decades of error over decades of tolerance, median",
            float(np.median(_slopes(found, integrator))),
            least=0.8,
            most=1.3,
            source="an error in proportion to the tolerance",
        )


def _slopes(found: Sequence[Mapped], integrator: str) -> list[float]:
    """d log(error) / d log(tolerance) between the loosest and the tightest run of each scene."""
    slopes = []
    for one in found:
        runs = [run for run in one.completed(integrator) if run.error > 0.0]
        if len(runs) > 1:
            decades = np.log10(runs[0].tolerance / runs[-1].tolerance)
            slopes.append(float(np.log10(runs[0].error / runs[-1].error) / decades))
    return slopes


def _tabulate_speeds(recorder: Recorder, groups: dict[str, list[Mapped]]) -> None:
    others = INTEGRATORS[1:]
    heads = [f"{name}, {level:g}" for level in LEVELS for name in others]
    rows = []
    for name, members in groups.items():
        cells = [
            promise.speed(members, integrator, "cvode", level)
            for level in LEVELS
            for integrator in others
        ]
        rows.append((name, len(members), *(_pair(value, count) for value, count in cells)))
    recorder.table(
        "Time at equal error",
        ["Class", "Scenes", *heads],
        rows,
        "Processor time over that of cvode at a global error of 1e-3, 1e-4 and 1e-6 (radii or "
        "radians): geometric mean over the scenes in which both reach the error (their number in "
        "brackets). Times are interpolated between tolerances. Where the loosest run is more "
        "accurate, its time counts.",
        first_page=True,
    )


def _tabulate_promise(
    recorder: Recorder, found: Sequence[Mapped], groups: dict[str, list[Mapped]]
) -> None:
    quantiles = [f"{100 * q:g} %" for q in promise.QUANTILES]
    tolerances = sorted({run.tolerance for one in found for run in one.runs}, reverse=True)
    rows = [
        (integrator, tolerance, *_spread(promise.ratios(found, integrator, tolerance)))
        for integrator in INTEGRATORS
        for tolerance in (*tolerances, None)
    ]
    recorder.table(
        "Global error over tolerance",
        ["Integrator", "Tolerance", "Runs", *quantiles, "≤ 10", "Within 10"],
        [(row[0], "all" if row[1] is None else row[1], *row[2:]) for row in rows],
        "Quantiles over the scenes of the global error over the tolerance, rtol = atol. The error "
        "is the larger of positions in radii and frames in radians. Last: the part of the runs "
        "with at most ten times the tolerance, and with a tenth to ten times.",
        first_page=True,
    )
    recorder.table(
        "Global error over tolerance, by class",
        ["Class", "Integrator", "Runs", *quantiles, "≤ 10", "Within 10"],
        [
            (name, integrator, *_spread(promise.ratios(members, integrator)))
            for name, members in groups.items()
            for integrator in INTEGRATORS
        ],
        "All tolerances.",
    )
    recorder.table(
        "Global error over tolerance and path",
        ["Integrator", "Runs", *quantiles, "≤ 10", "Within 10"],
        [
            (integrator, *_spread(promise.relative_ratios(found, integrator)))
            for integrator in INTEGRATORS
        ],
        "As before, with the error of positions over atol + rtol · (the longest displacement of a "
        "sphere, in radii).",
    )
    _tabulate_calibration(recorder, groups)


def _tabulate_calibration(recorder: Recorder, groups: dict[str, list[Mapped]]) -> None:
    rows = []
    for name, members in groups.items():
        for integrator in INTEGRATORS:
            largest = promise.largest_calibration(members, integrator)
            closest = promise.closest_calibration(members, integrator)
            bar = (largest.factor, largest.below) if largest else ("none", "")
            rows.append((name, integrator, *map(_short, (*bar, closest.factor, closest.within))))
    recorder.table(
        "Calibration",
        ["Class", "Integrator", "c, error ≤ 10 rtol", "Part of the runs",
         "c, most within 10", "Part of the runs"],
        rows,
        "If the tolerance of the steps were c times what it is. First: the largest c with which "
        "nine runs of ten have an error of at most 10 rtol. Then: the c with which most have an "
        "error of rtol / 10 to 10 rtol. Four c a decade, from 10 to 1e-4.",
        first_page=True,
    )  # fmt: skip


def _tabulate_ends(recorder: Recorder, found: Sequence[Mapped], without: dict[str, str]) -> None:
    counts: dict[tuple[str, str], int] = {}
    for one in found:
        for run in one.runs:
            end = run.ended
            if end == COMPLETED and not one.trusts(run.tolerance):
                end = "reference too coarse"
            counts[run.integrator, end] = counts.get((run.integrator, end), 0) + 1
    recorder.table(
        "How runs end",
        ["Integrator", "End", "Runs"],
        sorted((*key, count) for key, count in counts.items()),
        "Runs that are refused, stop or take too long are not in the other tables.",
    )
    if without:
        recorder.text(
            "No reference: " + "; ".join(f"{name} ({end})" for name, end in without.items()) + ". "
            "Where the two schemes do not meet, a stiff chain buckles at its start from what "
            "rounding leaves of a symmetry. The error is then the same at every tolerance."
        )
    recorder.table(
        "Scenes",
        ["Scene", "Classes", "End", "Longest path [a]", "Reference", "CVODE at 2e-11"],
        [
            (one.name, ", ".join(one.classes[1:]),
             *map(_short, (one.end, one.path, one.floor, one.apart)))
            for one in found
        ],
        "Scenes that stop, or that take long, are run to 0.8 of the time that a first run reaches. "
        "Reference: bound of its error. CVODE at 2e-11: its distance from the reference.",
    )  # fmt: skip


def _tabulate_runs(recorder: Recorder, found: Sequence[Mapped]) -> None:
    recorder.table(
        "Runs",
        ["Scene", "Integrator", "Tolerance", "End", "Positions [a]", "Frames [rad]", "Steps",
         "Right-hand sides", "Jacobians", "Seconds"],
        [
            (one.name, r.integrator, r.tolerance, r.ended, *map(_short, (r.position, r.frame)),
             r.steps, r.evaluations, r.jacobians, _short(r.seconds))
            for one in found
            for r in one.runs
        ],
        "Largest global errors over the snapshots, and median processor times.",
    )  # fmt: skip


def _spread(found: np.ndarray) -> tuple[float | str, ...]:
    if not len(found):
        return (0, *[""] * (len(promise.QUANTILES) + 2))
    quantiles = np.quantile(found, promise.QUANTILES)
    return (
        len(found),
        *map(_short, (*quantiles, promise.below(found), promise.within(found))),
    )


def _pair(value: float, count: int) -> str:
    return f"{value:.2g} ({count})" if count else ""


def _short(value: float | str) -> float | str:
    """Three digits; text stays, and what is not finite is left out."""
    if isinstance(value, str):
        return value
    return float(f"{value:.3g}") if np.isfinite(value) else ""
