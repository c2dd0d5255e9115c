"""How a run ends on the command line: its picture, its tables, its files and its exit code."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from nrchain.cli.arguments import Style
from nrchain.cli.exits import STOPPED, show_if_possible
from nrchain.cli.garbage import no_collection
from nrchain.cli.records import json_text
from nrchain.cli.result_records import run_record
from nrchain.cli.tables import ERRORS_NOTE, counters_table, counts, effects_table, errors_table
from nrchain.cli.terminal import LABEL, labelled, note, paragraph, report
from nrchain.errors import TrajectoryError

if TYPE_CHECKING:
    from nrchain.analysis.measure import Attractor
    from nrchain.trajectory.trajectory import Trajectory

PICTURE, PICTURE_IN_SPACE = "chain.png", "chain-3d.png"
EFFECTS_PICTURE, FLOW_PICTURE = "effects.png", "flow.png"

WHOLE = {"soft_wrap": True}
"""Lines are as wide as they should be."""


def finish(trajectory: Trajectory, style: Style) -> None:
    """Draw the picture, print what the run did and where it is, and exit by how it ended."""
    picture = _draw(trajectory)
    if style is Style.JSON:
        show_if_possible(json_text(run_record(trajectory, picture, _found(trajectory))), **WHOLE)
    elif style.is_text:
        if style is Style.FULL:
            _show_tables(trajectory)
        else:
            _show_counts(trajectory)
        _show_ends(trajectory, picture)
    if trajectory.path is None:
        report(f"nothing is kept: {trajectory.reason or 'the file was removed during the run'}")
        raise typer.Exit(STOPPED)
    if trajectory.status != "completed":
        report(_why_stopped(trajectory))
        raise typer.Exit(STOPPED)


def _show_tables(trajectory: Trajectory) -> None:
    """All counts, errors and effects."""
    from nrchain.run.work import DEFINITION

    show_if_possible(counters_table(trajectory), whole=True)
    show_if_possible(paragraph(DEFINITION), **WHOLE)
    if trajectory.position_error is not None:
        show_if_possible(errors_table(trajectory))
        show_if_possible(paragraph(ERRORS_NOTE), **WHOLE)
    show_if_possible(effects_table(trajectory))


def _show_counts(trajectory: Trajectory) -> None:
    """How far the run came, and what that took, in a few lines."""
    for label, text in counts(trajectory).items():
        show_if_possible(labelled(label, text), **WHOLE)


def _show_ends(trajectory: Trajectory, picture: Path | None) -> None:
    """How the run ended, and its files."""
    lines = {}
    if trajectory.status == "completed":
        lines["complete"] = trajectory.reason
        lines["attractor"] = _attractor(trajectory)
    if trajectory.provenance:
        lines["start"] = trajectory.provenance.line
    for label, text in lines.items():
        if text:
            show_if_possible(labelled(label, text), **WHOLE)
    for label, path in (("trajectory", trajectory.path), ("picture", picture)):
        if path:
            show_if_possible(f"{label:<{LABEL}}{path}", **WHOLE)


def _attractor(trajectory: Trajectory) -> str:
    """What the chain has settled in, as far as the snapshots tell, in words."""
    from nrchain.analysis.measure import MeasurementError, attractor

    with no_collection():
        try:
            return str(attractor(trajectory, further=False))
        except MeasurementError as error:
            return f"not known: {error}"


def _found(trajectory: Trajectory) -> Attractor | None:
    """What the chain has settled in; None if the run stopped, or if that is not known."""
    from nrchain.analysis.measure import MeasurementError, attractor

    if trajectory.status != "completed":
        return None
    with no_collection(), suppress(MeasurementError):
        return attractor(trajectory, further=False)
    return None


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
