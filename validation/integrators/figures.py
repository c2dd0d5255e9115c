"""The map: error against time, a panel a class; and the histogram of error over tolerance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from validation.integrators.promise import FACTOR, ratios
from validation.integrators.runs import INTEGRATORS, Mapped, Run
from validation.report.style import MARKERS, SHADES

COLOURS = (SHADES[0], SHADES[2], SHADES[4], SHADES[5])
UNIT = "cvode", 1e-5
"""The run whose processor time is the unit of time of a scene."""

FEWEST = 0.5
"""Least part of the scenes of a class that a point of the map needs."""


def work_precision(groups: dict[str, list[Mapped]]) -> Figure:
    """Medians over the scenes of a class, and quartiles of the error as bands."""
    rows = (len(groups) + 2) // 3
    figure = Figure(figsize=(9.6, 2.9 * rows))
    panels = figure.subplots(rows, 3, squeeze=False, sharex=True, sharey=True).flat
    for axes, (name, scenes) in zip(panels, groups.items(), strict=False):
        for k, integrator in enumerate(INTEGRATORS):
            _draw_line(axes, scenes, integrator, k)
        axes.set_title(f"{name} ({len(scenes)})", loc="left", fontsize=9)
        axes.legend(fontsize=7)
    for axes in panels:
        axes.set_visible(False)
    figure.supxlabel(f"processor time over that of {UNIT[0]} at {UNIT[1]:g}", fontsize=9)
    figure.supylabel("global error [$a$, rad]", fontsize=9)
    return figure


def _draw_line(axes: Axes, scenes: Sequence[Mapped], integrator: str, k: int) -> None:
    times, errors = [], []
    tolerances = sorted({run.tolerance for one in scenes for run in one.runs}, reverse=True)
    for tolerance in tolerances:
        found = [
            (run.seconds / unit.seconds, run.error)
            for one in scenes
            for unit in _runs(one, *UNIT)
            for run in _runs(one, integrator, tolerance)
        ]
        if len(found) >= max(FEWEST * len(scenes), 1):
            seconds, error = np.array(found).T
            times.append(np.median(seconds))
            errors.append(np.quantile(error, (0.25, 0.5, 0.75)))
    if times:
        low, middle, high = np.array(errors).T
        axes.fill_between(times, low, high, color=COLOURS[k], alpha=0.15, lw=0)
        axes.loglog(
            times, middle, MARKERS[k] + "-", color=COLOURS[k], mfc="white", label=integrator
        )


def _runs(one: Mapped, integrator: str, tolerance: float) -> list[Run]:
    return [run for run in one.completed(integrator) if run.tolerance == tolerance]


def histogram(scenes: Sequence[Mapped]) -> Figure:
    """How many runs have which error over tolerance, in thirds of a decade."""
    figure = Figure(figsize=(9.6, 2.8))
    edges = np.arange(-4.0, 6.01, 1.0 / 3.0)
    for k, (axes, integrator) in enumerate(
        zip(figure.subplots(1, len(INTEGRATORS), sharey=True), INTEGRATORS, strict=True)
    ):
        decades = np.log10(np.maximum(ratios(scenes, integrator), 1e-300))
        axes.axvspan(-np.log10(FACTOR), np.log10(FACTOR), color="0.93", zorder=0)
        axes.hist(np.clip(decades, edges[0], edges[-1]), edges, color=COLOURS[k])
        axes.set_title(integrator, loc="left", fontsize=9)
        axes.set_xlabel(r"$\log_{10}$ (global error / tolerance)")
    figure.axes[0].set_ylabel("runs")
    return figure
