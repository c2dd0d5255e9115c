"""The tables that the command line prints."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich import box
from rich.table import Table

from nrchain.wording import digits, span

if TYPE_CHECKING:
    from nrchain.accuracy.cost import WorkPrecision
    from nrchain.trajectory.trajectory import Trajectory


def plain_table(*columns: str) -> Table:
    """A table with a head and a rule below it."""
    return Table(*columns, box=box.SIMPLE_HEAD, header_style="bold", pad_edge=False)


def counters_table(trajectory: Trajectory) -> Table:
    """What a run took."""
    counters = trajectory.counters
    entries = {
        "t": f"{trajectory.time[-1]:.6g}",
        "snapshots": str(len(trajectory.time)),
        "steps": f"{counters.get('steps', 0):.0f}",
        "evaluations": f"{counters.get('evaluations', 0):.0f}",
        "Jacobians": f"{counters.get('jacobians', 0):.0f}",
        "solves": f"{counters.get('solves', 0):.0f}",
        "processor\ntime": _processor_time(trajectory),
        "wall\ntime": f"{counters.get('wall_time', 0.0):.2f} s",
    }
    table = plain_table()
    for title in entries:
        table.add_column(title, justify="right")
    table.add_row(*entries.values())
    return table


def _processor_time(trajectory: Trajectory) -> str:
    """Seconds of the steps that were taken, in words."""
    from nrchain.run.work import FEWEST_STEPS, cost_of

    cost = cost_of(trajectory)
    if 0 < cost.work.steps < FEWEST_STEPS:
        return "not known"
    return f"{digits(cost.seconds)} s"


def effects_table(trajectory: Trajectory) -> Table:
    """What a run has simulated, what it has left out, and which keys did nothing."""
    from nrchain.planning.description import describe

    description = describe(trajectory.scene)
    table = plain_table("", "effect", "how")
    for heading, effects in (
        ("simulated", description.simulated),
        ("left out", description.left_out),
        ("without effect", description.without_effect),
    ):
        for row, (effect, line) in enumerate(effects):
            table.add_row(heading if row == 0 else "", effect, line)
        table.add_section()
    return table


def work_table(found: WorkPrecision) -> Table:
    """Error, work and time of every setting; the whole run's only where it is extrapolated."""
    table = Table(box=box.SIMPLE_HEAD, header_style="bold", show_edge=False, padding=(0, 1, 0, 0))
    whole = ["whole run"] if found.part < 1.0 else []
    table.add_column("setting", no_wrap=True)
    counts = "steps", "evalu-\nations", "Jaco-\nbians", "solves"
    for title in ("error", *counts, "seconds", *whole):
        table.add_column(title, justify="right", no_wrap=True)
    axis = ""
    for point in found.points:
        if point.axis != axis:
            axis = point.axis
            table.add_section()
            table.add_row(axis, style="bold")
        measured = point.measured
        seconds = found.whole_run(measured)
        in_all = span(*map(digits, seconds), sign="–") if seconds else "not known"
        table.add_row(
            f" {point.setting}",
            f"{measured.error:.1e}" if measured.error else "none",
            *map(str, measured.work),
            digits(measured.median),
            *(in_all for _ in whole),
        )
    return table
