"""``nrchain branch``: states along a key of a scene, and where their stability changes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nrchain.cli.arguments import RUNS, Changes, Json, Quiet, SceneName, Style, find_run, load
from nrchain.cli.completion import complete_number
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.result_records import branch_record, cycles_record
from nrchain.cli.terminal import note
from nrchain.errors import SceneError

if TYPE_CHECKING:
    from rich.table import Table

    from nrchain.cli.result_records import Record
    from nrchain.scene.scene import Scene
    from nrchain.states.branches.branch import SpecialPoint
    from nrchain.states.branches.continuation import BranchDiagram
    from nrchain.states.cycles.branch import SpecialCycle
    from nrchain.states.cycles.continuation import CycleDiagram

PICTURE, CYCLES_PICTURE = "branches.png", "cycles.png"

CYCLES = "cycles"
"""Folders of the cycles that leave Hopf points begin with this word."""


@examples(
    "nrchain branch buckling --along slip.2s=0:150",
    "nrchain branch mine.toml --along slip.2s=0:200 --nudge 0.1 --cycles",
)
@one_line_errors()
def branch(
    scene: SceneName,
    along: Annotated[
        list[str],
        typer.Option(
            metavar="KEY=LOW:HIGH",
            autocompletion=complete_number,
            help="A number of the scene and its range, such as slip.2s=0:150."
            " Several vary together.",
        ),
    ],
    changes: Changes = None,
    start: Annotated[
        Path | None,
        typer.Option(
            "--from",
            help="Directory or file of a run whose last snapshot is near the first state."
            " By default, the straight chain.",
        ),
    ] = None,
    nudge: Annotated[
        float,
        typer.Option(help="Leave the first state along its fastest mode, by so many radii."),
    ] = 0.0,
    branches: Annotated[int, typer.Option(min=1, help="Most branches.")] = 8,
    steps: Annotated[int, typer.Option(min=1, help="Most states of a branch.")] = 400,
    step: Annotated[
        float,
        typer.Option(
            help="Largest arclength between two states, where the whole range and a displacement"
            " of each sphere by d are 1 each."
        ),
    ] = 0.05,
    cycles: Annotated[
        bool, typer.Option("--cycles", help="Follow the cycles that leave Hopf points as well.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="Directory for the branches. Branches of the same request there are continued.",
            show_default=f"{RUNS}/SCENE-branch",
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Follow states along a key, with their stability and the branches that leave them."""
    from nrchain.states.branches.continuation import continue_state
    from nrchain.states.branches.follow import END
    from nrchain.trajectory.trajectory import Trajectory
    from nrchain.view.branch_plots import save_branches

    style = Style.of(as_json=as_json, quiet=quiet)
    given = [_range(text) for text in along]
    ranges = dict(given)
    if len(ranges) < len(given):
        raise SceneError("--along", ", ".join(along), "must name each key once")
    loaded, _ = load(scene, changes, lines=style.is_text)
    guess = None if start is None else Trajectory.open(find_run(start))
    folder = output or RUNS / f"{Path(scene).stem}-branch"
    found = continue_state(
        loaded,
        ranges,
        guess,
        nudge=nudge,
        branches=branches,
        steps=steps,
        step=step,
        output=folder,
        progress=not quiet,
    )
    if style.is_text:
        show(branches_table(found))
        if found.special:
            show(special_table(found, "branch", "frequency", "rates at once"))
    picture = save_branches(found, folder / PICTURE)
    for number, one in enumerate(found.branches):
        if one.reason != END:
            note(f"branch {number} ends: {one.reason}")
    if len(found.branches) == branches:
        note(f"no more than {branches} branches are followed: --branches sets how many")
    if style.is_text:
        show(str(picture), soft_wrap=True)
    records = []
    for special in _hopf_points(found) if cycles else ():
        place = folder / f"{CYCLES}-{special.value:.6g}"
        records.append(_follow_cycles(loaded, ranges, special, place, style))
    if style is Style.JSON:
        show_json(branch_record(found, picture, records))


def _hopf_points(found: BranchDiagram) -> list[SpecialPoint]:
    """The Hopf points of all branches."""
    from nrchain.states.branches.events import HOPF

    return [special for special in found.special if special.kind == HOPF]


def _follow_cycles(
    scene: Scene,
    ranges: dict[str, tuple[float, float]],
    special: SpecialPoint,
    folder: Path,
    style: Style,
) -> Record:
    """Follow, show and draw the cycles that leave a Hopf point; their record."""
    from nrchain.states.cycles.continuation import continue_cycle
    from nrchain.view.cycle_plots import save_cycles

    found = continue_cycle(scene, ranges, special, output=folder)
    picture = save_cycles(found, folder / CYCLES_PICTURE)
    if style.is_text:
        show(cycles_table(found))
        if found.special:
            show(special_table(found, "cycles", "angle", "at once"))
        show(str(picture), soft_wrap=True)
    return cycles_record(found, picture)


def _range(text: str) -> tuple[str, tuple[float, float]]:
    """The key and the ends of ``key=low:high``."""
    key, _, ends = text.partition("=")
    low, _, high = ends.partition(":")
    try:
        return key.strip(), (float(low), float(high))
    except ValueError:
        allowed = "must be KEY=LOW:HIGH, such as slip.2s=0:150"
        raise SceneError("--along", text, allowed) from None


def branches_table(found: BranchDiagram) -> Table:
    """Where each branch begins and ends, and how many of its states are stable."""
    from nrchain.cli.tables import plain_table

    key = found.line.key
    table = plain_table("branch", "leaves", f"{key} from", "to", "states", "stable", "amplitude")
    for number, one in enumerate(found.branches):
        leaves = "" if one.parent is None else f"{one.parent[0]} at {one.values[0]:.6g}"
        table.add_row(
            f"{number}",
            leaves,
            f"{one.values[0]:.6g}",
            f"{one.values[-1]:.6g}",
            f"{len(one)}",
            f"{int(one.is_stable.sum())}",
            f"{one.amplitude.max():.4g}",
        )
    return table


def special_table(
    found: BranchDiagram | CycleDiagram, branches: str, measure: str, at_once: str
) -> Table:
    """The special points of all branches, each with its ``measure``: a frequency or an angle."""
    from nrchain.cli.tables import plain_table

    table = plain_table(branches, "point", found.line.key, "error", measure, at_once)
    specials: list[tuple[SpecialPoint | SpecialCycle, ...]] = [b.special for b in found.branches]
    for number, points in enumerate(specials):
        for special in points:
            turning = getattr(special, measure)
            table.add_row(
                f"{number}",
                special.kind,
                f"{special.value:.9g}",
                f"{special.error:.1e}",
                f"{turning:.6g}" if turning else "",
                f"{special.multiplicity}",
            )
    return table


def cycles_table(found: CycleDiagram) -> Table:
    """Where each branch of cycles begins and ends, and how many of them are stable."""
    from nrchain.cli.tables import plain_table

    key = found.line.key
    table = plain_table("cycles", f"{key} from", "to", "number", "stable", "period from", "to")
    for number, one in enumerate(found.branches):
        table.add_row(
            f"{number}",
            *(f"{value:.6g}" for value in one.values[[0, -1]]),
            f"{len(one)}",
            f"{int(one.is_stable.sum())}",
            *(f"{value:.6g}" for value in one.periods[[0, -1]]),
        )
    return table
