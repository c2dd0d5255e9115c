"""``nrchain resume``: continue a run."""

from __future__ import annotations

from typing import Annotated

import typer

from nrchain.cli.arguments import Json, Quiet, Run, Style, Verbose, find_run
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors
from nrchain.cli.progress import progress_bar, report_warnings
from nrchain.cli.summary import finish
from nrchain.cli.terminal import note


@examples(
    "nrchain resume runs/buckling",
    "nrchain resume runs/mine --until 2000",
    "nrchain resume runs/mine --unwatched",
)
@one_line_errors()
def resume(
    directory: Run,
    unwatched: Annotated[
        bool,
        typer.Option(
            "--unwatched",
            help="Continue although neglected effects exceed their estimate. The error bound of "
            "the run is lost.",
        ),
    ] = False,
    until: Annotated[
        float | None,
        typer.Option(
            metavar="TIME",
            help="Give the run a later end, in units of time: a multiple of the interval between "
            "its snapshots. A complete run goes on.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Continue a run that was interrupted, killed or stopped by a budget, or extend it."""
    from nrchain.run.simulation import resume as continue_run
    from nrchain.trajectory.trajectory import Trajectory

    style = Style.of(as_json=as_json, quiet=quiet, verbose=verbose)
    place = find_run(directory)
    kept = Trajectory.open(place)
    if kept.status == "completed" and until is None:
        note(f"{kept.path} is complete; there is nothing to resume")
    with progress_bar(place, hidden=quiet) as progress, report_warnings():
        trajectory = continue_run(place, unwatched=unwatched, until=until, progress=progress)
    finish(trajectory, style)
