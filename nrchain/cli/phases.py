"""``nrchain phases``: which attractor a chain reaches, over two keys of its scene."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrchain.cli.arguments import RUNS, Changes, Json, Quiet, SceneName, Style, load
from nrchain.cli.completion import complete_number
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show, show_if_possible
from nrchain.cli.records import show_json
from nrchain.cli.result_records import phases_record
from nrchain.cli.terminal import console, note, paragraph, report, warn
from nrchain.run.interruption import INTERRUPTED

if TYPE_CHECKING:
    from nrchain.jobs.crew import Progress

PICTURE, TABLE = "phases.png", "runs.csv"


@examples(
    "nrchain phases buckling --x slip.2s=0:3000 --y slip.3t=0:9000",
    "nrchain phases mine.toml --x slip.2s=0:200:5 --y slip.4a=0:900 --most 50",
)
@one_line_errors()
def phases(
    scene: SceneName,
    x: Annotated[
        str,
        typer.Option(
            metavar="KEY=LOW:HIGH",
            autocompletion=complete_number,
            help="Key and range of the first axis; a third number is the points of its first grid.",
            show_default=False,
        ),
    ],
    y: Annotated[
        str,
        typer.Option(
            metavar="KEY=LOW:HIGH",
            autocompletion=complete_number,
            help="Those of the second axis.",
            show_default=False,
        ),
    ],
    changes: Changes = None,
    start: Annotated[
        list[str] | None,
        typer.Option(
            help="Start of the runs at each point: random, planar (random:3 has seed 3),"
            " helix-left, helix-right, scene. Can be repeated.",
            show_default="random, planar, helix-right",
        ),
    ] = None,
    levels: Annotated[
        int, typer.Option(help="How often the distance of points is halved where kinds differ.")
    ] = 2,
    most: Annotated[int, typer.Option(help="Most points with runs.")] = 1000,
    longest: Annotated[
        float | None,
        typer.Option(
            help="Largest end of a run, in the scene's unit of time.",
            show_default="from the spectrum",
        ),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Threads that run.", show_default="one a core")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="Folder that keeps the results.",
            show_default="runs/SCENE-phases",
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace another diagram in this folder.")
    ] = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Draw which attractor a chain reaches, and where the straight chain turns unstable."""
    from nrchain.cli.phase_tables import lines, regions_table
    from nrchain.diagrams.compute import phases as compute
    from nrchain.diagrams.starts import STARTS
    from nrchain.view.drawing import require_matplotlib
    from nrchain.view.phase_plots import save_phases

    style = Style.of(as_json=as_json, quiet=quiet)
    require_matplotlib()
    axes = _axis("x", x), _axis("y", y)
    loaded, _ = load(scene, changes, lines=style.is_text)
    place = output or RUNS / f"{Path(scene).stem}-phases"
    with _progress(place) as progress:
        found = compute(
            loaded,
            *axes,
            start or STARTS,
            levels=levels,
            most=most,
            longest=longest,
            workers=workers,
            output=place,
            overwrite=overwrite,
            progress=progress,
        )
    picture = save_phases(found, place / PICTURE)
    table = found.write_table(place / TABLE)
    if style.is_text:
        show_if_possible(regions_table(found), whole=True)
        show_if_possible(*map(paragraph, lines(found)), soft_wrap=True)
    for text in found.notes:
        note(text)
    if style is Style.JSON:
        show_json(phases_record(found, picture, table))
    elif style.is_text:
        show(f"picture     {picture}", f"runs        {table}", soft_wrap=True)
    for region in found.regions:
        for one in region.verified:
            if not one.agrees:
                size = len(region.points)
                warn(f"the region {one.kind} of {size} points is not confirmed: {one.why}")


def _axis(name: str, text: str) -> tuple[Any, ...]:
    """``(key, low, high)`` or ``(key, low, high, points)`` of ``key=low:high[:points]``."""
    from nrchain.errors import SceneError

    key, _, numbers = text.partition("=")
    try:
        low, high, *count = numbers.split(":")
        if len(count) < 2:
            return key.strip(), float(low), float(high), *map(int, count)
    except ValueError:
        pass
    allowed = "must be key=low:high or key=low:high:points, such as slip.2s=-100:100"
    raise SceneError(name, text, allowed)


@contextmanager
def _progress(place: Path) -> Iterator[Callable[[Progress], None]]:
    """Show how many results there are; if interrupted, say how to continue."""
    screen = console(stderr=True)
    try:
        with screen.status("phases") if screen.is_terminal else nullcontext() as status:

            def show_progress(progress: Progress) -> None:
                if progress.waits_for:
                    runs = "run" if progress.waits_for == 1 else "runs"
                    count = f"{progress.waits_for} {runs} under way"
                    report(f"interrupted; waiting for {count} to end at the next step")
                elif status is not None:
                    status.update(f"{progress.done} results   {progress.name}")

            yield show_progress
    except KeyboardInterrupt:
        report(
            f"interrupted; what is finished is kept in {shlex.quote(str(place))}; the same command"
            " continues"
        )
        raise typer.Exit(INTERRUPTED) from None
