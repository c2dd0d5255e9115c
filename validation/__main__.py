"""python -m validation [NAME ...]: run the studies, print their checks, write the report.

Exit codes: 0, all checks pass; 1, a check fails or a study stops; 2, invalid arguments.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from validation.report.studies import STUDIES, Outcome, run_study

if TYPE_CHECKING:
    from validation.report.build import Report
    from validation.report.recorder import Check

FAILED, REFUSED = 1, 2
WIDE, NARROW = 62, 13

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


class _Display:
    """Prints one row per check and, on a terminal, a progress bar below."""

    def __init__(self, console: Console, studies: int) -> None:
        self.console = console
        self.bar = Progress(
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.description}"),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self.task = self.bar.add_task("", total=studies)
        self.study = ""

    def opened(self, name: str) -> None:
        self.study = name
        self.stepped("")
        self._print(f"\n{STUDIES[name].title}", style="bold")
        heads = (f"{head:>{NARROW}}" for head in ("predicted", "measured", "error", "tolerance"))
        self._print(f"  {name:<{WIDE}}{''.join(heads)}", style="dim")

    def checked(self, check: Check) -> None:
        from validation.report.page import number

        name = check.name if len(check.name) < WIDE else check.name[: WIDE - 2] + "…"
        values = (_entry(check.predicted), _entry(check.measured))
        errors = (f"{check.error:.1e}", f"{check.tolerance:.1e}")
        row = "".join(f"{text:>{NARROW}}" for text in (*map(number, values), *errors))
        mark, style = ("✓", None) if check.passed else ("✗", "bold red")
        self._print(f"{mark} {name:<{WIDE}}{row}", style=style)

    def stepped(self, description: str) -> None:
        self.bar.update(self.task, description=f"{self.study}  {description}")

    def closed(self, outcome: Outcome) -> None:
        self.bar.advance(self.task)
        if outcome.error:
            self._print(f"  stopped: {outcome.error}", style="bold red")

    def _print(self, line: str, style: str | None = None) -> None:
        self.console.print(line, style=style, soft_wrap=True)


@app.command()
def main(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME ...]", help="Studies to run.", show_default="all"),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Use fewer points: minutes in total.")
    ] = False,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the report.")] = Path(
        "report"
    ),
    show: Annotated[bool, typer.Option("--list", help="List the studies and stop.")] = False,
    readme: Annotated[
        bool,
        typer.Option(
            "--readme", help="Write the results of the report into the README and docs, and stop."
        ),
    ] = False,
) -> None:
    """Compare nrchain with derivations, the paper and PyStokes, and write a report."""
    from validation.report.build import PAGE, Report, ReportError

    console = Console(markup=False, emoji=False, highlight=False)
    if show:
        for name, study in STUDIES.items():
            console.print(f"{name:<16}{study.title}", soft_wrap=True)
        return
    if readme:
        from validation.report.readme import update

        try:
            update(Path(__file__).parents[1], output)
        except ReportError as error:
            _refuse(str(error))
        return
    for name in names or ():
        if name not in STUDIES:
            _refuse(f"no study is called {name!r}; known are {', '.join(STUDIES)}")
    chosen = [name for name in STUDIES if not names or name in names]
    try:
        report = Report(output)
    except ReportError as error:
        _refuse(str(error))
    outcomes = _run_studies(chosen, quick, console, report)
    console.print(_closing(outcomes))
    console.print(f"report  {output / PAGE}", soft_wrap=True)
    if not all(outcome.passed for outcome in outcomes):
        raise typer.Exit(FAILED)


def _run_studies(names: list[str], quick: bool, console: Console, report: Report) -> list[Outcome]:
    """Run the studies one by one, print their checks and add each to the report."""
    display = _Display(console, len(names))
    outcomes = []
    with display.bar:
        for name in names:
            display.opened(name)
            outcome = run_study(name, quick=quick, listener=display)
            display.closed(outcome)
            report.add(outcome)
            outcomes.append(outcome)
    return outcomes


def _refuse(reason: str) -> NoReturn:
    Console(stderr=True, markup=False, emoji=False, highlight=False).print(
        f"validation: {reason}", soft_wrap=True
    )
    raise typer.Exit(REFUSED)


def _closing(outcomes: list[Outcome]) -> Table:
    from rich import box

    table = Table(box=box.SIMPLE_HEAD, header_style="bold", pad_edge=False)
    table.add_column("study")
    for title in ("passed", "failed", "time"):
        table.add_column(title, justify="right")
    for outcome in outcomes:
        checks, failed = outcome.recorder.checks, outcome.recorder.failed
        table.add_row(
            outcome.recorder.study,
            str(len(checks) - len(failed)),
            str(len(failed)),
            f"{outcome.seconds:.1f} s",
            style="bold red" if failed else None,
        )
    return table


def _entry(value: Any) -> Any:
    return [value.real, value.imag] if isinstance(value, complex) else value


if __name__ == "__main__":
    # figures go to files; a notebook may set a backend that is not installed
    os.environ.pop("MPLBACKEND", None)
    app()
