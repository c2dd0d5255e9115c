"""Phase diagrams of a clamped chain over (2s, 3t) and (2s, 4a).

What runs end in must agree with what the spectrum says of the straight chain: it is reached where
it is stable, and left where it is not. Next to the line of flutter the chain oscillates at the
frequency of its leading mode.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

import nrchain
from validation.report.recorder import Recorder

COUNT = 20
SCENE = {"chain.particles": COUNT, "elasticity.ratio": 1e8, "start.amplitude": 0.5}

PUSH = ("slip.2s", -100.0, 100.0)
AXES = {
    "2s, 3t": (PUSH, ("slip.3t", 0.0, 2000.0)),
    "2s, 4a": (PUSH, ("slip.4a", 0.0, 4000.0)),
}

GRIDS = {"2s, 3t": (17, 2), "2s, 4a": (21, 0)}
"""Points of the first grid along each axis, and how often it is refined. Over (2s, 4a) there are
three regions with plain borders, and slow runs next to them."""

LEAST_POINTS = 400

OSCILLATING = ("standing oscillation", "travelling oscillation", "rotating shape")

CLEAR = 0.05
"""Part of the range of an axis from a threshold within which runs may not have settled."""

NEAR = 0.06
"""Part of the ranges from the line of flutter within which a period is that of the mode."""

WITHIN = 0.1
"""Of the period next to the line and that of the leading mode."""

WORST = 1e-3
"""Largest error of positions in verified runs of states, in radii."""

CAPTION = (
    "What a clamped chain of N = {count} ends in from two starts, over {axes}: R = 10⁸, a = η ="
    " 1, d = 10, nearest neighbours. On solid lines the straight chain buckles, on dashed lines it"
    " flutters, by the spectrum."
)


def diagrams(recorder: Recorder) -> dict[str, nrchain.PhaseDiagram]:
    """Compute both diagrams, or the first if quick; check them, add their figures and tables."""
    found = {}
    for axes in list(AXES)[:1] if recorder.quick else AXES:
        x, y = AXES[axes]
        recorder.step(f"phases over {axes}")
        diagram = compute(x, y, *GRIDS[axes], quick=recorder.quick)
        found[axes] = diagram
        _check(recorder, axes, diagram)
        recorder.figure(
            f"phases-{axes.replace(', ', '-')}",
            nrchain.phase_plots.phase_figure(diagram),
            CAPTION.format(count=COUNT, axes=axes),
        )
    return found


def compute(
    x: tuple[str, float, float],
    y: tuple[str, float, float],
    count: int,
    levels: int,
    *,
    quick: bool,
) -> nrchain.PhaseDiagram:
    """The diagram: in full, of at least :data:`LEAST_POINTS` points, each from two starts."""
    scene = nrchain.load_scene("buckling", **SCENE)
    if quick:
        return nrchain.phases(scene, (*x, 5), (*y, 5), "random", levels=1, most=50)
    starts = "random", "planar"
    return nrchain.phases(scene, (*x, count), (*y, count), starts, levels=levels, most=560)


def _check(recorder: Recorder, axes: str, diagram: nrchain.PhaseDiagram) -> None:
    if not recorder.quick:
        recorder.bound(
            f"{axes}: points", len(diagram.points), least=LEAST_POINTS, source="what is asked for"
        )
    clear = [point for point in diagram.points if _distance(diagram, point) > CLEAR]
    wrong = [p for p in clear if ("straight" in p.kinds) != (p.growth < 0.0)]
    recorder.bound(
        f"{axes}: points whose runs and spectrum differ on the straight chain",
        len(wrong),
        most=0,
        source=f"Re Λ₁, for {len(clear)} points that are not next to a threshold",
    )
    _check_periods(recorder, axes, diagram)
    verified = [one for region in diagram.regions for one in region.verified]
    states = [one for one in verified if math.isfinite(one.growth)]
    recorder.bound(
        f"{axes}: largest error of verified runs that end in a state or a cycle, in radii",
        max(one.error for one in states),
        most=WORST,
        source="a run with a tenth of the tolerances",
    )
    recorder.table(
        f"Regions over {axes}",
        ["Region", "Points", "Part", diagram.x.key, diagram.y.key, "Verified", "Error (a)"],
        [_row(region) for region in diagram.regions],
        "Connected points of one kind, and the run that is verified in each.",
    )


def _check_periods(recorder: Recorder, axes: str, diagram: nrchain.PhaseDiagram) -> None:
    """The period of oscillations next to the line of flutter, over that of the leading mode."""
    flutters = [curve for curve in diagram.curves if curve.flutters]
    ratios = [
        trial.period * point.frequency / (2.0 * math.pi)
        for point in diagram.points
        if point.growth > 0.0 and _distance(diagram, point, flutters) < NEAR
        for trial in point.trials
        if trial.period and trial.kind in OSCILLATING
    ]
    if ratios:
        recorder.check(
            f"{axes}: period next to the line of flutter over that of the mode",
            1.0,
            float(np.median(ratios)),
            WITHIN,
            source=f"Im Λ₁ of the straight chain; the median of {len(ratios)} runs",
        )


def _distance(
    diagram: nrchain.PhaseDiagram, point: Any, curves: Sequence[Any] | None = None
) -> float:
    """Distance of a point from the nearest of some curves, in ranges of the axes."""
    chosen = diagram.curves if curves is None else curves
    ranges = [axis.high - axis.low for axis in (diagram.x, diagram.y)]
    apart = [
        np.hypot((curve.x - point.x) / ranges[0], (curve.y - point.y) / ranges[1]).min()
        for curve in chosen
    ]
    return float(min(apart, default=math.inf))


def _row(region: Any) -> tuple[str | int, ...]:
    errors = [one.error for one in region.verified if math.isfinite(one.error)]
    return (
        region.kind,
        len(region.points),
        f"{100.0 * region.share:.1f} %",
        f"{region.x[0]:g} to {region.x[1]:g}",
        f"{region.y[0]:g} to {region.y[1]:g}",
        "yes" if region.agrees else "no",
        f"{max(errors):.1e}" if errors else "",
    )
