"""``nrchain sweep``: one scene at many points of its keys; and what was found, drawn."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrchain.cli.arguments import RUNS, Changes, Json, Quiet, Style
from nrchain.cli.completion import complete_key, complete_number, complete_scene
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.result_records import sweep_record, without_value_record
from nrchain.cli.terminal import console, labelled, note, paragraph, report
from nrchain.progress import terminal_bar
from nrchain.run.interruption import INTERRUPTED

if TYPE_CHECKING:
    from nrchain.sweeps.progress import Report
    from nrchain.sweeps.result import Sweep
    from nrchain.sweeps.without_value import WithoutValue

SHOW = "show"
"""In place of a scene: draw what a folder holds."""

PICTURE = "sweep.png"

SHOWN = 5
"""Failures that are listed."""

OPTIONS = (
    *("grid", "points", "random", "adaptive", "samples", "seed", "target", "observe", "keep"),
    *("shard", "workers", "processes", "retry", "overwrite", "x", "y", "at"),
)
"""Options that Python names as arguments, without the dashes."""


@contextmanager
def _options_with_dashes() -> Iterator[None]:
    """Name an option in an error as the terminal spells it."""
    from nrchain.errors import SceneError

    try:
        yield
    except SceneError as error:
        if error.key.partition(" ")[0] not in OPTIONS:
            raise
        raise SceneError(f"--{error.key}", error.value, error.allowed) from error


@examples(
    "nrchain sweep wave --grid slip.3t=0:1000:9 --observe end.size -o runs/a",
    "nrchain sweep show runs/a",
)
@one_line_errors()
@_options_with_dashes()
def sweep(
    scene: Annotated[
        str,
        typer.Argument(
            help="Name of a shipped scene, or a TOML file; or the word show.",
            show_default=False,
            autocompletion=complete_scene,
        ),
    ],
    folder: Annotated[
        Path | None,
        typer.Argument(help="After show: folder of a sweep, to be drawn.", show_default=False),
    ] = None,
    grid: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=VALUES",
            autocompletion=complete_key,
            help="Values of a key: low:high:count, low:high:count:log, or a list such as 16,32."
            " Can be repeated: all combinations are run.",
        ),
    ] = None,
    points: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="A table (CSV) of points: keys in its first line.", dir_okay=False
        ),
    ] = None,
    random: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=LOW:HIGH",
            autocompletion=complete_number,
            help="Ends between which a key is drawn; with :log by its logarithm. Can be repeated.",
        ),
    ] = None,
    adaptive: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=LOW:HIGH",
            autocompletion=complete_number,
            help="Ends of one or two keys, between which points are placed where the target"
            " changes most.",
        ),
    ] = None,
    samples: Annotated[
        int | None, typer.Option(help="Number of points of --random or --adaptive.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of --random.")] = 0,
    target: Annotated[
        str | None,
        typer.Option(help="Observable that places points.", show_default="the first observable"),
    ] = None,
    changes: Changes = None,
    observe: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAMES",
            help="What is kept of each run, such as end.size,measure.rate. Can be repeated; a"
            " wrong name lists all.",
            show_default="end.time,end.size",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="Folder of the results, or after show the picture: PNG, PDF or SVG.",
            show_default="runs/SCENE-sweep",
        ),
    ] = None,
    keep: Annotated[bool, typer.Option("--keep", help="Keep the trajectories too.")] = False,
    shard: Annotated[
        str | None,
        typer.Option(
            metavar="I/N",
            help="Run part I of N. The same command without it merges the parts.",
        ),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Threads that run.", show_default="one a core")
    ] = None,
    processes: Annotated[
        int | None, typer.Option(min=1, help="Processes in place of threads.")
    ] = None,
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Scheduler of Dask, such as tcp://node:8786, or its JSON file."
        ),
    ] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Run points that failed again.")] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace another sweep, or a picture.")
    ] = False,
    x: Annotated[str | None, typer.Option(help="After show: key along x.")] = None,
    y: Annotated[str | None, typer.Option(help="After show: key along y, of a map.")] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=VALUE", help="After show: value of a key that is not drawn."),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a scene at many points, keep what is observed, and draw it.

    A sweep that was interrupted goes on with the same command.

    More values or observables are added in the same way.

    nrchain sweep show FOLDER draws maps and lines.
    """
    style = Style.of(as_json=as_json, quiet=quiet)
    if scene == SHOW:
        draw(folder, _split(observe), output, x, y, at, overwrite, style)
        return
    from nrchain.errors import NOT_GIVEN, SceneError
    from nrchain.scene.loading import load_scene
    from nrchain.scene.toml import parse_assignment
    from nrchain.sweeps.compute import sweep as compute
    from nrchain.sweeps.executors import cluster as dask

    if folder is not None:
        raise SceneError("folder", str(folder), "follows only the word show; use -o for results")
    if samples is None and (random or adaptive):
        name = "--random" if random else "--adaptive"
        raise SceneError("samples", NOT_GIVEN, f"{name} needs the number of points")
    if not (grid or points or random or adaptive):
        allowed = (
            "must name a key and its values, such as --grid slip.2s=0:100:3; or give --points,"
            " --random or --adaptive"
        )
        raise SceneError("grid", NOT_GIVEN, allowed)
    loaded = load_scene(scene, **dict(map(parse_assignment, changes or ())))
    place = output or RUNS / f"{Path(scene).stem}-sweep"
    options: dict[str, Any] = {
        "points": None if points is None else _read_points(points),
        "random": _pairs("random", random),
        "adaptive": _pairs("adaptive", adaptive),
        "samples": samples,
        "seed": seed,
        "target": target,
        "keep": keep,
        "shard": shard,
        "workers": workers,
        "processes": processes,
        "retry": retry,
        "overwrite": overwrite,
    }
    options |= {"observe": named} if (named := _split(observe)) else {}
    table = _pairs("grid", grid)
    with _progress(place) as progress:
        if cluster is None:
            found = compute(loaded, table, output=place, progress=progress, **options)
        else:
            with dask(cluster) as client:
                found = compute(
                    loaded, table, output=place, progress=progress, executor=client, **options
                )
    if style is Style.JSON:
        show_json(sweep_record(found, _tables(place)))
    elif style.is_text:
        _tell(found, place, shard)


def draw(
    folder: Path | None,
    names: Sequence[str],
    output: Path | None,
    x: str | None,
    y: str | None,
    at: Sequence[str] | None,
    overwrite: bool,
    style: Style,
) -> None:
    """Draw a sweep: the first observable, or each of those named, in a panel of its own."""
    from nrchain.cli.summary import check_absent
    from nrchain.errors import SceneError
    from nrchain.scene.toml import parse_assignment
    from nrchain.sweeps.result import Sweep
    from nrchain.sweeps.without_value import without_value
    from nrchain.view.sweep_plots import save_sweep

    if folder is None:
        raise SceneError("folder", folder, "must follow the word show: nrchain sweep show FOLDER")
    found = Sweep.open(folder)
    if output is not None and not overwrite:
        check_absent(output)
    fixed = dict(map(parse_assignment, at or ()))
    picture, others = save_sweep(
        found, output or folder / PICTURE, names or None, x=x, y=y, at=fixed
    )
    if others:
        words = ", ".join(f"{key} = {value}" for key, value in others.items())
        note(f"drawn at {words}; --at chooses other values")
    empty = without_value(found.points, names or found.observables[:1])
    if style is Style.JSON:
        record = without_value_record(empty)
        show_json({"picture": picture, "at": others | fixed, "without_value": record})
    elif style.is_text:
        show(f"picture     {picture}", soft_wrap=True)
        _tell_empty(empty)


def _tell(found: Sweep, place: Path, shard: str | None) -> None:
    """Print how many points there are, which failed, and where the tables are."""
    from nrchain.sweeps.tables import CSV

    stopped = [point for point in found.points if point.outcome == "stopped"]
    failed = found.failed
    words = [f"{len(found)} points"]
    words += [f"{len(stopped)} stopped early"] if stopped else []
    words += [f"{len(failed)} failed"] if failed else []
    show(f"points      {', '.join(words)}", soft_wrap=True)
    for point in failed[:SHOWN]:
        values = ", ".join(f"{key} = {value}" for key, value in point.values.items())
        show(paragraph(f"{values}: {point.reason}", "failed      ", 12 * " "), soft_wrap=True)
    if len(failed) > SHOWN:
        show(f"            and {len(failed) - SHOWN} more: see {CSV}")
    _tell_empty(found.without_value)
    if shard is not None:
        show("merge       when all shards are done: the same command without --shard")
        return
    for table in _tables(place):
        show(f"table       {table}", soft_wrap=True)


def _tell_empty(found: Iterable[WithoutValue]) -> None:
    """Print a line for each observable that has no value at some points."""
    for one in found:
        show(labelled("no value", str(one)), soft_wrap=True)


def _tables(place: Path) -> list[Path]:
    """The tables in the folder of a sweep."""
    from nrchain.sweeps.tables import CSV, NETCDF, PARQUET

    return [place / name for name in (CSV, PARQUET, NETCDF) if (place / name).exists()]


def _split(given: Sequence[str] | None) -> list[str]:
    """Names that commas separate."""
    return [name.strip() for text in given or () for name in text.split(",") if name.strip()]


def _pairs(name: str, given: Sequence[str] | None) -> dict[str, str] | None:
    """Keys and their texts, of ``key=text``."""
    from nrchain.errors import SceneError

    if not given:
        return None
    pairs: dict[str, str] = {}
    for text in given:
        key, sign, values = (part.strip() for part in text.partition("="))
        if not sign or not key:
            form = "-100:100:21" if name == "grid" else "-100:100"
            raise SceneError(name, text, f"must be key=values, such as slip.2s={form}")
        if key in pairs:
            raise SceneError(name, text, f"names {key} a second time; give all values at once")
        pairs[key] = values
    return pairs


def _read_points(path: Path) -> list[dict[str, Any]]:
    """The points of a table: keys in the first line, values in the others."""
    import csv

    from nrchain.errors import SceneError
    from nrchain.scene.toml import parse_assignment
    from nrchain.trajectory.file import file_errors

    with file_errors(path, "cannot be read"), path.open(newline="", encoding="utf-8-sig") as file:
        rows = [row for row in csv.reader(file, skipinitialspace=True) if row]
    if len(rows) < 2 or any(len(row) != len(rows[0]) for row in rows):
        allowed = "must have keys in its first line, and as many values in each other line"
        raise SceneError("points", str(path), allowed)
    return [
        dict(parse_assignment(f"{key}={value}") for key, value in zip(rows[0], row, strict=True))
        for row in rows[1:]
    ]


@contextmanager
def _progress(place: Path) -> Iterator[Report | None]:
    """Show a bar; if interrupted, say how to continue."""
    screen = console(stderr=True)
    try:
        if not screen.is_terminal:
            yield None
            return
        with terminal_bar(screen) as update:
            yield lambda progress: update(progress.shown())
    except KeyboardInterrupt:
        report(
            f"interrupted; what is finished is kept in {shlex.quote(str(place))}; the same command"
            " continues"
        )
        raise typer.Exit(INTERRUPTED) from None
