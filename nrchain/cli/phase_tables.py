"""What ``nrchain phases`` prints: the regions with what verifies them, and the thresholds."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.table import Table

from nrchain.cli.tables import plain_table
from nrchain.wording import digits, span

if TYPE_CHECKING:
    from nrchain.diagrams.diagram import PhaseDiagram
    from nrchain.diagrams.regions import Region

MOST_REGIONS = 12
"""Most rows of the table of regions; the table of runs has all."""


def regions_table(diagram: PhaseDiagram) -> Table:
    """Kind, size and ranges of each region, and whether its verified point agrees."""
    table = plain_table("region")
    for title in ("points", "part of\nplane", diagram.x.key, diagram.y.key):
        table.add_column(title, justify="right")
    table.add_column("verified at")
    table.add_column("error (a)", justify="right")
    for region in diagram.regions[:MOST_REGIONS]:
        table.add_row(
            region.kind,
            str(len(region.points)),
            f"{100.0 * region.share:.1f} %",
            span(*(f"{value:g}" for value in region.x)),
            span(*(f"{value:g}" for value in region.y)),
            *_verified(region),
        )
    return table


def _verified(region: Region) -> tuple[str, str]:
    """Where a region is verified and whether it agrees, and the error of positions there."""
    if not region.verified:
        return "", ""
    first = region.verified[0]
    where = f"({first.x:g}, {first.y:g})" + ("" if region.agrees else ": not confirmed")
    errors = [one.error for one in region.verified if not math.isnan(one.error)]
    return where, f"{max(errors):.1e}" if errors else "not known"


def lines(diagram: PhaseDiagram) -> list[str]:
    """One line for each threshold, and one on what was run."""
    found = []
    for curve in diagram.curves:
        what = "flutters" if curve.flutters else "buckles"
        text = (
            f"the straight chain {what} on a curve from ({curve.x[0]:.6g}, {curve.y[0]:.6g}) to "
            f"({curve.x[-1]:.6g}, {curve.y[-1]:.6g}), {len(curve.x)} points"
        )
        if curve.flutters:
            low, high = curve.frequency.min(), curve.frequency.max()
            text += f", at frequencies from {low:.4g} to {high:.4g}"
        found.append(text)
    trials = [trial for point in diagram.points for trial in point.trials]
    spent = sum(trial.seconds for trial in trials if trial.seconds == trial.seconds)
    runs = f"{len(trials)} runs at {len(diagram.points)} points"
    return [*found, f"{runs}, in {digits(spent)} s of processor time"]
