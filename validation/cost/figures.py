"""Work–precision figures: error against processor time, one figure an axis."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from validation.cost.results import (
    TARGET_NAMES,
    TARGETS,
    Case,
    Map,
    Priced,
    Reached,
    Resolved,
    least_reach,
)
from validation.report.style import MARKERS, SHADES

MARK = "#b00020"
COLOURS = (SHADES[0], SHADES[2], SHADES[4], SHADES[5], SHADES[6])


def stepping(maps: Sequence[Map], levels: Sequence[float]) -> Figure:
    """A panel a scene: a line an integrator, from loose to tight."""
    rows = (len(maps) + 1) // 2
    figure = Figure(figsize=(7.6, 3.1 * rows))
    panels = np.atleast_1d(figure.subplots(rows, min(2, len(maps)), squeeze=False)).flat
    for letter, axes, one in zip("abcd", panels, maps, strict=False):
        axes.axhspan(1e-16, one.floor, color="0.93", zorder=0)
        for k, scheme in enumerate(dict.fromkeys(s.scheme for s in one.settings)):
            row = [s for s in one.settings if s.scheme == scheme and s.measured.error > one.floor]
            axes.loglog(
                [s.measured.median for s in row], [s.measured.error for s in row],
                MARKERS[k] + "-", color=COLOURS[k], mfc="white", label=scheme,
            )  # fmt: skip
        for s in one.settings:
            if s.is_default:
                _ring(axes, s.measured.median, s.measured.error)
        best = {level: one.cheapest(level) for level in levels}
        _squares(
            axes,
            [(s.measured.median, s.measured.error, TARGET_NAMES[v]) for v, s in best.items() if s],
        )
        axes.set_ylim(bottom=one.floor / 5)
        axes.set_xlim(left=0.6 * axes.get_xlim()[0])  # room for what is written beside the marks
        _time_axis(axes, "processor time [s]")
        axes.set_ylabel("global error [$a$, rad]")
        axes.set_title(f"({letter})  {one.name}", loc="left", fontsize=9)
        axes.legend()
    return figure


def reach(found: Mapping[str, Sequence[Reached]]) -> Figure:
    """Trajectories and rates of all modes by reach, against their cost."""
    figure = Figure(figsize=(8.4, 3.5))
    left, right = figure.subplots(1, 2)
    for k, (label, points) in enumerate(found.items()):
        style: dict[str, Any] = {"color": COLOURS[k], "mfc": "white", "label": label}
        runs = [p for p in points if p.measured and p.path]
        times = [p.measured.median for p in runs if p.measured]
        left.loglog(times, [p.path for p in runs], MARKERS[k] + "-", **style)
        for p, x in zip(runs, times, strict=True):
            left.annotate(
                str(p.reach), (x, p.path or 0), (4, 3), textcoords="offset points", fontsize=6
            )
        _ring(left, times[0], runs[0].path or 0)
        rates = [p for p in points if p.rate > 0]
        right.loglog([1e6 * p.once for p in rates], [p.rate for p in rates], MARKERS[k] + "-",
                     **style)  # fmt: skip
        _ring(right, 1e6 * rates[0].once, rates[0].rate)
        best = [least_reach(points, level) for level in TARGETS]
        _squares(right, [(1e6 * p.once, p.rate, f"{p.reach}") for p in best if p and p.rate > 0])
    all_pairs = 1e6 * float(np.median([points[-1].once for points in found.values()]))
    right.axvline(all_pairs, color="0.5", ls=":", lw=0.9)
    right.annotate("all pairs", (all_pairs, 0.03), (-4, 0), xycoords=("data", "axes fraction"),
                   textcoords="offset points", fontsize=7, ha="right")  # fmt: skip
    _time_axis(left, "processor time of the shipped scene [s]")
    left.set_ylabel("error of the trajectory, over its path")
    left.set_title("(a)  trajectories", loc="left", fontsize=9)
    _time_axis(right, r"one right-hand side, $N = 2048$ [$\mu$s]")
    right.set_ylabel(r"error of $\Lambda$ at $qd = 0.1$")
    right.set_title("(b)  rates of bending waves", loc="left", fontsize=9)
    for axes in (left, right):
        axes.legend()
    return figure


def model(
    pairs: Mapping[str, Sequence[Case]],
    chains: Mapping[str, Sequence[Case]],
    driven: Sequence[Case],
    priced: Sequence[Priced],
) -> Figure:
    """True error of each level against distance, and against its cost."""
    figure = Figure(figsize=(8.0, 6.4))
    (first, second), (third, fourth) = figure.subplots(2, 2)
    for axes, groups in ((first, pairs), (second, chains)):
        for k, (label, cases) in enumerate(groups.items()):
            x = [case.distance for case in cases]
            for level, line in (("leading order", "-"), ("finite size", "--")):
                if level == "finite size" and label != "2s":
                    continue
                axes.loglog(
                    x, [case.errors[level] for case in cases], MARKERS[k] + line,
                    color=COLOURS[k], mfc="white",
                    label=label if line == "-" else f"{label}, finite size",
                )  # fmt: skip
    first.set_title("(a)  two spheres, one active", loc="left", fontsize=9)
    second.set_title("(b)  five spheres, all active", loc="left", fontsize=9)
    for k, name in enumerate(driven[0].errors):
        third.loglog(
            [case.distance for case in driven], [case.errors[name] for case in driven],
            MARKERS[k] + "-", color=COLOURS[k], mfc="white", label=name,
        )  # fmt: skip
    third.set_title("(c)  five spheres, driven: friction", loc="left", fontsize=9)
    for axes in (first, second, third):
        axes.set_xlabel("distance of neighbours $d/a$")
        axes.set_ylabel("relative error of velocities")
        axes.set_xticks([3, 5, 10, 20, 40], ["3", "5", "10", "20", "40"])
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.legend(fontsize=7)
    _prices(fourth, priced)
    return figure


def _prices(axes: Axes, priced: Sequence[Priced]) -> None:
    resolved = [p for p in priced if p.level.startswith("resolved")]
    laws = [p for p in priced if p not in resolved]
    axes.loglog([p.seconds for p in resolved], [p.error for p in resolved], "D-",
                color=COLOURS[0], mfc="white", label="resolved, by order $L$")  # fmt: skip
    for p in resolved:
        axes.annotate(p.level.split("= ")[1], (p.seconds, p.error), (5, 3),
                      textcoords="offset points", fontsize=7)  # fmt: skip
    for k, p in enumerate(laws):
        axes.loglog(p.seconds, p.error, MARKERS[k], color=COLOURS[1], mfc="white", label=p.level)
    _ring(axes, laws[0].seconds, laws[0].error)
    good = {level: [p for p in priced if p.error <= level] for level in TARGETS}
    best = {level: min(ps, key=lambda p: p.seconds) for level, ps in good.items() if ps}
    _squares(axes, [(p.seconds, p.error, TARGET_NAMES[level]) for level, p in best.items()])
    axes.set_xlabel("one evaluation, five spheres [s]")
    axes.set_ylabel("relative error at $d = 10a$")
    axes.set_title("(d)  what a level costs", loc="left", fontsize=9)
    axes.margins(x=0.1, y=0.12)
    axes.legend(fontsize=7)


def resolution(
    points: Sequence[Resolved],
    needed: Mapping[str, Sequence[int]],
    shipped: Mapping[str, int],
    formulas: Mapping[str, np.ndarray],
) -> Figure:
    """Spheres per wavelength, their cost, and the difference formulas."""
    figure = Figure(figsize=(10.2, 3.3))
    left, middle, right = figure.subplots(1, 3)
    counts = [p.count for p in points]
    for k, kind in enumerate(needed):
        errors = [p.errors[kind] for p in points]
        left.loglog(counts, errors, MARKERS[k] + "-", color=COLOURS[k], mfc="white", label=kind)
        for level, n in zip(TARGETS, needed[kind], strict=True):
            left.plot([n], [level], "s", color=COLOURS[k], ms=7, mfc="none", mew=1.0)
        if kind in shipped:
            _ring(left, shipped[kind], float(np.exp(np.interp(
                np.log(shipped[kind]), np.log(counts), np.log(errors)))))  # fmt: skip
    left.set_xlabel("spheres a wavelength")
    left.set_ylabel("error of the continuum law")
    left.set_title("(a)  resolution", loc="left", fontsize=9)
    left.legend(fontsize=7)
    timed = [p for p in points if p.measured]
    x = [p.measured.median for p in timed if p.measured]
    middle.loglog(x, [p.errors["passive"] for p in timed], "o-", color=COLOURS[0], mfc="white")
    for p, seconds in zip(timed, x, strict=True):
        middle.annotate(str(p.count), (seconds, p.errors["passive"]), (4, 4),
                        textcoords="offset points", fontsize=7)  # fmt: skip
    passive = [(seconds, p.errors["passive"]) for seconds, p in zip(x, timed, strict=True)]
    within = {level: [point for point in passive if point[1] <= level] for level in TARGETS}
    _squares(
        middle, [(*min(points), TARGET_NAMES[level]) for level, points in within.items() if points]
    )
    _time_axis(middle, "processor time of one decay time [s]")
    middle.set_ylabel("error of the passive law")
    middle.set_title("(b)  what it costs", loc="left", fontsize=9)
    phases = formulas["phases"]
    for k, name in enumerate(n for n in formulas if n != "phases"):
        line = "-" if k < 2 else "--"
        right.loglog(phases, formulas[name], line, color=COLOURS[k % 2], label=(
            f"tilt/slope, {name}" if k < 2 else name))  # fmt: skip
    right.set_xlabel("wavenumber  $qd$")
    right.set_ylabel("relative error")
    right.set_title("(c)  difference formulas", loc="left", fontsize=9)
    right.legend(fontsize=7)
    return figure


def _time_axis(axes: Axes, label: str) -> None:
    """Plain numbers at 1, 2 and 5 of every decade."""
    low, high = axes.get_xlim()
    few = high > 60 * low
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0,) if few else (1.0, 2.0, 5.0)))
    if not few:
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(label)


def _ring(axes: Axes, x: float, y: float) -> None:
    axes.plot([x], [y], "o", ms=11, mfc="none", mec="0.25", mew=1.1, zorder=5)


def _squares(axes: Axes, choices: Iterable[tuple[float, float, str]]) -> None:
    """Mark the cheapest choices; a point lists the names of all targets that it meets."""
    names: dict[tuple[float, float], list[str]] = {}
    for x, y, text in choices:
        names.setdefault((x, y), []).append(text)
    for (x, y), texts in names.items():
        axes.plot([x], [y], "s", ms=10, mfc="none", mec=MARK, mew=1.0, zorder=5)
        axes.annotate(
            ", ".join(dict.fromkeys(texts)), (x, y), (-7, -9), textcoords="offset points",
            fontsize=6.5, color=MARK, ha="right",
        )  # fmt: skip
