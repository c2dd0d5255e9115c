"""How a run ends on the command line: its picture, its tables, its files and its exit code."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from nrchain.cli.exits import STOPPED, show_if_possible
from nrchain.cli.garbage import no_collection
from nrchain.cli.tables import ERRORS_NOTE, counters_table, effects_table, errors_table
from nrchain.cli.terminal import note, report
from nrchain.errors import TrajectoryError

if TYPE_CHECKING:
    from nrchain.trajectory.trajectory import Trajectory

PICTURE, PICTURE_IN_SPACE = "chain.png", "chain-3d.png"
EFFECTS_PICTURE, FLOW_PICTURE = "effects.png", "flow.png"


def finish(trajectory: Trajectory) -> None:
    """Draw the picture, print what the run did and where it is, and exit by how it ended."""
    from nrchain.run.work import DEFINITION

    picture = _draw(trajectory)
    show_if_possible(counters_table(trajectory), whole=True)
    show_if_possible(DEFINITION, soft_wrap=True)
    if trajectory.position_error is not None:
        show_if_possible(errors_table(trajectory))
        show_if_possible(ERRORS_NOTE, soft_wrap=True)
    show_if_possible(effects_table(trajectory))
    if trajectory.status == "completed" and trajectory.reason:
        show_if_possible(f"complete    {trajectory.reason}", soft_wrap=True)
    if trajectory.status == "completed":
        show_if_possible(f"attractor   {_attractor(trajectory)}", soft_wrap=True)
    if trajectory.provenance:
        show_if_possible(f"start       {trajectory.provenance.line}", soft_wrap=True)
    if trajectory.path:
        show_if_possible(f"trajectory  {trajectory.path}", soft_wrap=True)
    if picture:
        show_if_possible(f"picture     {picture}", soft_wrap=True)
    if trajectory.path is None:
        report(f"nothing is kept: {trajectory.reason or 'the file was removed during the run'}")
        raise typer.Exit(STOPPED)
    if trajectory.status != "completed":
        report(_why_stopped(trajectory))
        raise typer.Exit(STOPPED)


def _attractor(trajectory: Trajectory) -> str:
    """What the chain has settled in, as far as the snapshots tell."""
    from nrchain.analysis.measure import MeasurementError, attractor

    with no_collection():
        try:
            return str(attractor(trajectory, further=False))
        except MeasurementError as error:
            return f"not known: {error}"


def _why_stopped(trajectory: Trajectory) -> str:
    run = trajectory.scene.run
    advice = f"; {trajectory.advice}" if trajectory.advice else ""
    return (
        f"stopped early: {trajectory.reason}; {len(trajectory.time)} of {run.snapshots} snapshots "
        f"are kept, up to t = {trajectory.time[-1]:.6g} of {run.end:.6g}{advice}"
    )


def _draw(trajectory: Trajectory) -> Path | None:
    """Draw the chain beside the file of a run; note a failure and return None."""
    if trajectory.path is None:
        return None
    try:
        with no_collection():
            from nrchain.view.plots import save_chain

            return save_chain(trajectory, picture_beside(trajectory, PICTURE))
    except (OSError, ValueError, RuntimeError, MemoryError, ArithmeticError) as error:
        note(f"no picture is drawn: {error}")
        return None


def picture_beside(trajectory: Trajectory, name: str) -> Path:
    """The path of a picture beside a trajectory: ``name``, or FILE-``name`` for a FILE.h5."""
    from nrchain.trajectory.file import FILE_NAME

    assert trajectory.path is not None
    prefix = "" if trajectory.path.name == FILE_NAME else f"{trajectory.path.stem}-"
    return trajectory.path.with_name(prefix + name)


def check_absent(output: Path) -> None:
    """Raise :class:`TrajectoryError` if the file of a picture exists."""
    from nrchain.trajectory.file import file_errors

    with file_errors(output, "cannot be drawn"):
        if output.exists():
            raise TrajectoryError(f"{output} exists; add --overwrite to replace it")
