"""The tables that the command line prints."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich import box
from rich.table import Table

from nrchain.wording import digits, span

if TYPE_CHECKING:
    from nrchain.accuracy.cost import WorkPrecision
    from nrchain.accuracy.plan_effects import EffectPlan
    from nrchain.accuracy.timing import Measured
    from nrchain.planning.plan import Plan
    from nrchain.theory.dispersion import Dispersion
    from nrchain.theory.lattice import Branch
    from nrchain.theory.rod.coarse_graining import Moduli
    from nrchain.trajectory.trajectory import Trajectory

ERROR_ROWS = 6
"""Most rows of the table of errors; the file has the errors of all snapshots."""

ROUNDING = 1e-12
"""Part of a rate, relative to its size, that is shown as 0."""

NOT_KNOWN = "not known"

ERRORS_NOTE = (
    "errors are the distance from a second run with a tenth of the tolerances, the largest over the"
    " spheres"
)


def plain_table(*columns: str) -> Table:
    """A table with column heads and a rule below them."""
    return Table(*columns, box=box.SIMPLE_HEAD, header_style="bold", pad_edge=False)


def counters_table(trajectory: Trajectory) -> Table:
    """What a run reached, what it counted, and its computing time."""
    counters = trajectory.counters
    entries = {
        "t": f"{trajectory.time[-1]:.6g}",
        "snapshots": str(len(trajectory.time)),
        "steps": f"{counters.get('steps', 0):.0f}",
        "right-hand\nsides": f"{counters.get('evaluations', 0):.0f}",
        "Jacobians": f"{counters.get('jacobians', 0):.0f}",
        "solves": f"{counters.get('solves', 0):.0f}",
        "processor\ntime": _processor_time(trajectory),
        "wall\ntime": f"{counters.get('wall_time', 0.0):.2f} s",
    }
    table = plain_table()
    table.collapse_padding = True
    for title in entries:
        table.add_column(title, justify="right")
    table.add_row(*entries.values())
    return table


def counts(trajectory: Trajectory) -> dict[str, str]:
    """What a run reached, what it counted and what it took, a line each, by its label."""
    from nrchain.run.work import cost_of

    work = cost_of(trajectory).work
    lines = {
        "reached": f"t = {trajectory.time[-1]:.6g}, {len(trajectory)} snapshots",
        "steps": f"{work.steps}, with {work.evaluations} right-hand sides, {work.jacobians} "
        f"Jacobians and {work.solves} solves",
        "time": _times(trajectory),
    }
    if trajectory.choice is not None:
        choice = trajectory.choice
        lines["left out"] = ", ".join(choice.left_out) or "nothing: the full model"
        if choice.left_out:
            lines["left out"] += (
                f"; poses stay within {choice.bound:.2g} radii or radians, {choice.tolerance:g} is "
                "allowed"
            )
    if trajectory.position_error is not None and trajectory.frame_error is not None:
        radius = trajectory.scene.chain.radius
        errors = (trajectory.position_error / radius, trajectory.frame_error)
        positions, frames = (_error(float(part.max())) for part in errors)
        lines["error"] = f"positions {positions} a, frames {frames} rad, the largest"
    return lines


def _times(trajectory: Trajectory) -> str:
    """The processor time of a run, if it is known, and its wall time."""
    wall = f"{trajectory.counters.get('wall_time', 0.0):.2f} s in all"
    processor = _processor_time(trajectory)
    return wall if processor == NOT_KNOWN else f"{processor} of the processor, {wall}"


def errors_table(trajectory: Trajectory) -> Table:
    """The estimated errors of a verified run, at up to :data:`ERROR_ROWS` of its times."""
    table = plain_table()
    for title in ("t", "error of\npositions (a)", "error of\nframes (rad)"):
        table.add_column(title, justify="right")
    last, radius = len(trajectory.time) - 1, trajectory.scene.chain.radius
    rows = sorted({round(k * last / (ERROR_ROWS - 1)) for k in range(ERROR_ROWS)})
    assert trajectory.position_error is not None
    assert trajectory.frame_error is not None
    for row in rows:
        errors = trajectory.position_error[row] / radius, trajectory.frame_error[row]
        table.add_row(f"{trajectory.time[row]:.6g}", *map(_error, errors))
    return table


def _error(error: float) -> str:
    if math.isnan(error):
        return NOT_KNOWN
    return f"{error:.1e}" if error else "0"


def _processor_time(trajectory: Trajectory) -> str:
    """Seconds of the steps of a run; not known for a few steps, which compilation dominates."""
    from nrchain.run.work import FEWEST_STEPS, cost_of

    cost = cost_of(trajectory)
    if 0 < cost.work.steps < FEWEST_STEPS:
        return NOT_KNOWN
    return f"{digits(cost.seconds)} s"


def effects_table(trajectory: Trajectory) -> Table:
    """The effects that a run simulated and left out, and its keys without effect."""
    from nrchain.planning.description import effect_rows, without_effect

    simulated, left_out = effect_rows(trajectory.scene)
    table = plain_table("", "effect", "details")
    for heading, effects in (
        ("simulated", simulated),
        ("left out", left_out),
        ("without effect", without_effect(trajectory.scene)),
    ):
        for row, (effect, line) in enumerate(effects):
            table.add_row(heading if row == 0 else "", effect, line)
        table.add_section()
    return table


def predictions_table(predicted: Plan) -> Table:
    """What the numbers of a scene predict, one quantity a row."""
    table = plain_table("quantity", "value", "meaning")
    for line in predicted.lines:
        table.add_row(line.quantity, line.value, line.meaning)
    return table


def contributions_table(effects: EffectPlan) -> Table:
    """What each effect contributes and costs, one effect a row."""
    from nrchain.accuracy.effect_cells import COLUMNS

    table = plain_table()
    table.collapse_padding = True
    for name in COLUMNS:
        table.add_column(name, justify="left" if name == COLUMNS[0] else "right", no_wrap=True)
    for row in effects.rows():
        table.add_row(*row)
    return table


def moduli_table(found: Moduli) -> Table:
    """The constants that symmetry allows a transversely isotropic chain, one a row."""
    from nrchain.theory.rod.symmetry import classes

    table = plain_table("constant", "class")
    titles = ["slip", "elasticity", "± error"]
    columns = [found.active.symbols(), found.elastic.symbols(), found.error.symbol_bounds()]
    if found.logarithm.largest() > 0.0:
        titles.append("ln(1/qd)")
        columns.append(found.logarithm.symbols())
    for title in titles:
        table.add_column(title, justify="right")
    kinds = classes()
    for symbol in found.symmetry.symbols():
        *values, error = (column[symbol] for column in columns[:3])
        cells = [_value(value, error) for value in values] + [f"{error:.0e}"]
        cells += [_value(column[symbol], error) for column in columns[3:]]
        table.add_row(symbol, str(kinds[symbol]), *cells)
    return table


def entries_table(found: Moduli) -> Table:
    """All entries of C, H and the affine parts of a chain without transverse isotropy."""
    names = [f"{name}{n}" for name in ("ε", "τ") for n in (1, 2, 3)]
    table = plain_table("")
    for title in ("at rest", *names):
        table.add_column(title, justify="right")
    total, error, allowed = found.total, found.error, found.symmetry.allowed()
    for matrix, affine, rows in (("C", "prestress", "FM"), ("H", "presource", "fm")):
        for n in range(6):
            cells = []
            for name, index in ((affine, n), *((matrix, (n, k)) for k in range(6))):
                value, bound = (getattr(c, name)[index] for c in (total, error))
                cells.append(_value(value, bound) if getattr(allowed, name)[index] else "·")
            table.add_row(f"{rows[n // 3]}{n % 3 + 1}", *cells)
        table.add_section()
    return table


def growth_table(found: Dispersion) -> Table:
    """The largest growth of each branch on the lattice, and its growth there by every theory."""
    from nrchain.theory.lattice import Branch

    table = _theories_table(found, "largest\ngrowth\nat qd", "growth")
    for branch in Branch:
        row = found.fastest(branch)
        qd = f"{found.wavenumbers[row] * found.scene.chain.spacing:.4g}"
        cells = [_rate(rate, growth=True) for rate in _theories(found, branch, row)]
        table.add_row(branch.spoken, qd, *cells)
    return table


def frequency_table(found: Dispersion) -> Table:
    """The frequency of each branch where it grows most, by every theory."""
    from nrchain.theory.lattice import Branch

    table = _theories_table(found, "at qd", "frequency")
    if found.rod:
        table.add_column("group velocity\nrod", justify="right", no_wrap=True)
    for branch in Branch:
        row = found.fastest(branch)
        qd = f"{found.wavenumbers[row] * found.scene.chain.spacing:.4g}"
        cells = [_rate(rate, growth=False) for rate in _theories(found, branch, row)]
        if found.rod:
            velocity = found.rod.velocities[row, branch]
            scale = abs(found.rod.rates[row, branch]) / found.wavenumbers[row]
            cells.append("0" if abs(velocity) <= ROUNDING * scale else f"{velocity:.4g}")
        table.add_row(branch.spoken, qd, *cells)
    return table


def _theories_table(found: Dispersion, place: str, what: str) -> Table:
    """A table with a column for each theory, without rows."""
    table = plain_table("branch")
    theories = ["lattice", *(["rod", "beam limit"] if found.rod else [])]
    for title in (place, *(f"{what}\n{name}" for name in theories)):
        table.add_column(title, justify="right", no_wrap=True)
    return table


def _theories(found: Dispersion, branch: Branch, row: int) -> list[complex | None]:
    """The rate of a branch at one wavenumber by every theory; None where one has no such branch."""
    rates: list[complex | None] = [found.lattice[row, branch]]
    for waves in (found.rod, found.beam) if found.rod else ():
        known = waves is not None and branch in waves.branches
        rates.append(waves.column(branch)[row] if waves is not None and known else None)
    return rates


def _rate(rate: complex | None, *, growth: bool) -> str:
    """Re Λ or −Im Λ; 0 within rounding, and nothing where a theory has no such branch."""
    if rate is None:
        return ""
    value = rate.real if growth else -rate.imag
    return "0" if abs(value) <= ROUNDING * abs(rate) else f"{value:.4g}"


def _value(value: float, error: float) -> str:
    """A number with six digits; 0 within its error."""
    return "0" if abs(value) <= error else f"{value:.6g}"


def work_table(found: WorkPrecision) -> Table:
    """Error, work and processor time of every setting; those of the whole run if extrapolated."""
    table = Table(box=box.SIMPLE_HEAD, header_style="bold", show_edge=False, padding=(0, 1, 0, 0))
    table.add_column("setting", no_wrap=True)
    heads = ["error", "steps", "right-hand\nsides", "Jaco-\nbians", "solves", "time\n(s)"]
    if found.part < 1.0:
        heads.append("whole\nrun (s)")
    for title in heads:
        table.add_column(title, justify="right", no_wrap=True)
    axis = ""
    for point in found.points:
        if point.axis != axis:
            axis = point.axis
            table.add_section()
            table.add_row(axis, style="bold")
        cells = _work_cells(found, point.measured)
        table.add_row(f" {point.setting}", *cells[: len(heads)])
    return table


def _work_cells(found: WorkPrecision, measured: Measured) -> list[str]:
    """Error, counts, seconds of the short run, and seconds of the whole run."""
    whole = found.whole_run(measured)
    return [
        f"{measured.error:.1e}" if measured.error else "0",
        *map(str, measured.work),
        digits(measured.median),
        span(*map(digits, whole), sign="–") if whole else "not known",
    ]
