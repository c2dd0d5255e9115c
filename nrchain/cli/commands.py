"""The command line: run a scene, resume a run, list the scenes, draw a run.

What is heavy is imported by the command that needs it, so that ``nrchain --help`` is immediate.
Exit codes: 0, done; 2, refused, with one line on what is wrong; 3, a run that stopped early and
kept what it reached; 130, interrupted; 141, without a word, where whoever reads the output of a
command has gone away, as ``| head`` does. A picture or a table that cannot be written does not
change the code of a run, whose data are in its file.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any
from warnings import catch_warnings

import typer
from typer.core import TyperGroup

from nrchain.cli.tables import counters_table, effects_table, plain_table, work_table
from nrchain.cli.terminal import (
    READER_GONE,
    complain,
    complain_of,
    console,
    let_go,
    show,
    spell_out,
)
from nrchain.errors import NrchainError, SceneError, SceneWarning, TrajectoryError
from nrchain.run.interruption import INTERRUPTED
from nrchain.version import __version__

if TYPE_CHECKING:
    from nrchain.planning.choice import Choice
    from nrchain.run.simulate import Progress
    from nrchain.scene.scene import Scene
    from nrchain.trajectory.trajectory import Trajectory

REFUSED, STOPPED = 2, 3
PICTURE, PICTURE_IN_SPACE, EFFECTS_PICTURE = "chain.png", "chain-3d.png", "effects.png"

_UsageError: Any = typer.BadParameter.__base__
"""What a command line that cannot be understood raises; Typer has no public name for it."""


class _OneLineGroup(TyperGroup):
    """The commands, with one line for a command line that is not understood."""

    def main(self, args: Sequence[str] | None = None, *given: Any, **options: Any) -> Any:
        words = sys.argv[1:] if args is None else list(args)
        options["standalone_mode"] = False
        try:
            code = super().main(words or ["--help"], *given, **options)
        except _UsageError as error:
            where = error.ctx.command_path if error.ctx else "nrchain"
            message = " ".join(error.format_message().split()).rstrip(".")
            complain(f"{message}; see {where} --help")
            code = REFUSED
        except SystemExit as end:
            # what Typer itself makes of a reader that has gone away while it shows a help text
            if not isinstance(end.__context__, BrokenPipeError):
                raise
            code = READER_GONE
        except OSError as error:
            let_go()
            complain_of(error)
            code = _unwritten(error)
        sys.exit(code if isinstance(code, int) else 0)


def _unwritten(error: OSError) -> int:
    """The exit code of a command whose output cannot be written."""
    return READER_GONE if isinstance(error, BrokenPipeError) else REFUSED


app = typer.Typer(
    name="nrchain",
    help="Simulate chains of active colloids with nonreciprocal interactions.",
    cls=_OneLineGroup,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class View(StrEnum):
    planes = "planes"
    space = "3d"


Directory = Annotated[Path, typer.Argument(help="Directory of a run.", show_default=False)]
SceneName = Annotated[
    str, typer.Argument(help="Name of a shipped scene, or a TOML file.", show_default=False)
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Change a key of the scene, such as slip.2s=50."
    ),
]


def main() -> None:
    """The command line, from the arguments of the process."""
    spell_out()
    try:
        app()
    finally:
        try:
            if sys.stdout is not None:
                sys.stdout.flush()
        except OSError as error:
            let_go()
            complain_of(error)


@contextmanager
def _reporting() -> Iterator[None]:
    """Turn what a user can cause into one line on stderr and an exit code."""
    try:
        yield
    except NrchainError as error:
        complain(str(error))
        raise typer.Exit(REFUSED) from error
    except OSError as error:
        complain(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        raise typer.Exit(REFUSED) from error
    except KeyboardInterrupt:
        complain("interrupted")
        raise typer.Exit(INTERRUPTED) from None


def _show(*things: Any, **how: Any) -> None:
    """Print, or end with one line on why that is not possible."""
    if failure := show(*things, **how):
        complain_of(failure)
        raise typer.Exit(_unwritten(failure))


def _mention(*things: Any, **how: Any) -> None:
    """Print beside a run, which goes on where that is not possible, and says so."""
    if failure := show(*things, **how):
        complain_of(failure, "note: ")


def _show_version(wanted: bool) -> None:
    if wanted:
        _show(f"nrchain {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    pass


@app.command()
@_reporting()
def run(
    scene: SceneName,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="Directory, or file that ends in .h5, to write to.",
            show_default="runs/SCENE",
        ),
    ] = None,
    changes: Changes = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an older result.")
    ] = False,
) -> None:
    """Run a scene; write its trajectory and a picture."""
    from nrchain.effects.registry import acting
    from nrchain.planning.regime import warnings
    from nrchain.run.folders import made
    from nrchain.run.simulate import output_file, simulate

    place = output or Path("runs") / Path(scene).stem
    folder, file = output_file(place, overwrite)
    what, choice = _chosen(scene, changes)
    said = warnings(what)
    _warn(what, said)
    names = ", ".join(effect.name for effect in acting(what)) or "none"
    _mention(f"effects     {names}", soft_wrap=True)
    with (
        made(folder) if folder else nullcontext(),
        _progress_bar(place) as report,
        _telling(said),
    ):
        trajectory = simulate(
            what,
            output=file,
            overwrite=overwrite,
            progress=report,
            choice=choice,
        )
    _finish(trajectory)


@app.command()
@_reporting()
def plan(
    scene: SceneName,
    changes: Changes = None,
    budget: Annotated[
        float, typer.Option(min=0.0, help="Work of the probes, in seconds counted, not timed.")
    ] = 3.0,
) -> None:
    """Say what a scene's numbers foretell, and what each effect contributes and costs."""
    from nrchain.accuracy.plan_effects import COLUMNS, plan_effects
    from nrchain.planning.estimate import estimate_effects
    from nrchain.planning.plan import plan as foretell

    what, _ = _chosen(scene, changes)
    found = foretell(what)
    table = plain_table("quantity", "value", "meaning")
    for line in found.lines:
        table.add_row(line.quantity, line.value, line.meaning)
    _show(table)
    effects = plan_effects(what, estimate_effects(what, budget=budget))
    table = plain_table()
    table.collapse_padding = True
    for name in COLUMNS:
        table.add_column(name, justify="left" if name == COLUMNS[0] else "right", no_wrap=True)
    for row in effects.rows():
        table.add_row(*row)
    _show(table)
    _show(*effects.remarks(), *effects.notes(), soft_wrap=True)
    _warn(what, found.warnings)


@app.command()
@_reporting()
def resume(
    directory: Directory,
    unwatched: Annotated[
        bool, typer.Option("--unwatched", help="Go on although more is left out than foreseen.")
    ] = False,
) -> None:
    """Go on with a run that was killed or interrupted."""
    from nrchain.run.simulate import resume as go_on
    from nrchain.trajectory.trajectory import Trajectory

    directory = _place_of(directory)
    done = Trajectory.open(directory)
    if done.status == "completed":
        complain(f"note: {done.path} is complete, and nothing is left to do")
    with _progress_bar(directory) as report, _telling([]):
        trajectory = go_on(directory, unwatched=unwatched, progress=report)
    _finish(trajectory)


@app.command()
@_reporting()
def scenes() -> None:
    """List the scenes that ship."""
    from nrchain.scene.scene import load_scene, scene_names, slip_text

    table = plain_table("scene", "what it shows", "slip", "ends")
    table.add_column("N", justify="right")
    for name in scene_names():
        scene = load_scene(name)
        chain = scene.chain
        table.add_row(name, scene.title, slip_text(scene), chain.ends, str(chain.particles))
    _show(table)


@app.command()
@_reporting()
def effects() -> None:
    """List all effects: what each does, and the scene key that calls for it."""
    from nrchain.effects.registry import effects as known

    table = plain_table("effect", "what it does", "scene key")
    for effect in known():
        table.add_row(effect.name, effect.summary, effect.key)
    _show(table)


@app.command()
@_reporting()
def plot(
    directory: Directory,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="PNG, PDF or SVG.",
            show_default=f"DIRECTORY/{PICTURE}, {PICTURE_IN_SPACE} or {EFFECTS_PICTURE}",
        ),
    ] = None,
    of_effects: Annotated[
        bool, typer.Option("--effects", help="Draw what each effect does, not the chain.")
    ] = False,
    view: Annotated[
        View | None, typer.Option(help="Three projections, or space.", show_default="planes")
    ] = None,
    times: Annotated[
        int | None, typer.Option(min=1, help="How many states to draw.", show_default="6")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the file that -o names.")
    ] = False,
) -> None:
    """Draw the chain of a run at several times, or its effects, also while it runs."""
    from nrchain.trajectory.file import refusing
    from nrchain.trajectory.trajectory import Trajectory
    from nrchain.view.plots import draw_chain

    if of_effects and (view or times):
        raise SceneError(
            "--view" if view else "--times",
            view.value if view else times,
            "is for pictures of the chain; take it or --effects out",
        )
    trajectory = Trajectory.open(_place_of(directory))
    if output is not None and not overwrite:
        with refusing(output, "cannot be drawn"):
            if output.exists():
                raise TrajectoryError(f"{output}: exists; it is only replaced with --overwrite")
    if of_effects:
        from nrchain.view.effect_plots import draw_effects

        path = draw_effects(trajectory, output or _beside(trajectory, EFFECTS_PICTURE))
        _show(str(path), soft_wrap=True)
        return
    shown = view or View.planes
    name = PICTURE if shown is View.planes else PICTURE_IN_SPACE
    path = output or _beside(trajectory, name)
    _show(str(draw_chain(trajectory, path, view=shown.value, times=times or 6)), soft_wrap=True)


@app.command()
@_reporting()
def cost(
    scene: SceneName,
    changes: Changes = None,
    target: Annotated[
        float | None,
        typer.Option(help="Global error to reach, in radii and radians: which setting to use."),
    ] = None,
    budget: Annotated[
        float,
        typer.Option(help="Work of the short runs together, in seconds counted, not timed."),
    ] = 30.0,
) -> None:
    """Measure what the accuracy of a scene costs, by short runs."""
    from nrchain.accuracy.cost import check_target, work_precision

    if target is not None:
        check_target(target)
    what, _ = _chosen(scene, changes)
    with console(stderr=True).status("") as status:
        found = work_precision(
            what, budget=budget, progress=lambda stage: status.update(f"measuring {stage}")
        )
    _show(work_table(found), whole=True)
    _show(*found.notes(), soft_wrap=True)
    if target is not None:
        advice = found.advise(target)
        own = "".join(f"--set {shlex.quote(change)} " for change in changes or ())
        _show(
            f"\nfor an error of {target:g}: {advice.point.setting}",
            f"  nrchain run {scene} {own}{advice.arguments}",
            *(f"  {line}" for line in advice.lines()),
            soft_wrap=True,
        )


def _place_of(given: Path) -> Path:
    """The directory or file of a run; one that is not there is refused with where it may be."""
    meant = Path("runs") / given
    if not given.exists() and meant.exists():
        raise TrajectoryError(f"{given}: there is no such trajectory; did you mean {meant}?")
    return given


def _chosen(name: str, changes: Sequence[str] | None) -> tuple[Scene, Choice | None]:
    """The scene with its effects chosen, if it leaves that to us; what they leave out is said."""
    from nrchain.scene.scene import load_scene, parse_assignment

    scene = load_scene(name, **dict(parse_assignment(change) for change in changes or ()))
    if scene.effects != "auto":
        return scene, None
    from nrchain.planning.auto import choose

    scene, choice = choose(scene)
    for text in choice.lines():
        _mention(text, soft_wrap=True)
    return scene, choice


def _warn(scene: Scene, warnings: list[str]) -> None:
    """Say what is risky about a scene, and which of its keys do nothing."""
    from nrchain.planning.description import without_effect

    for key, why in without_effect(scene):
        complain(f"note: {key} has no effect: {why}")
    for text in warnings:
        complain(f"warning: {text}")


@contextmanager
def _telling(said: list[str]) -> Iterator[None]:
    """Tell what a run warns of, once it is over and but for what was said before."""
    with catch_warnings(record=True, action="always", category=SceneWarning) as told:
        yield
    for text in (str(one.message) for one in told or ()):
        if text not in said:
            complain(f"warning: {text}")


@contextmanager
def _progress_bar(directory: Path) -> Iterator[Callable[[Progress], None]]:
    """A bar of the time reached, which says how to go on if it is interrupted."""
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    from nrchain.trajectory.file import locate

    screen = console(stderr=True)
    bar = Bar(
        TextColumn("t = {task.fields[time]}"),
        BarColumn(bar_width=None),
        TextColumn("{task.fields[steps]} steps"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=screen,
        transient=True,
        disable=not screen.is_terminal,
    )
    task = bar.add_task("", total=None, time="0", steps="0")

    def report(progress: Progress) -> None:
        bar.update(
            task,
            total=progress.end,
            completed=progress.time,
            time=f"{progress.time:.4g} of {progress.end:.4g}",
            steps=f"{progress.counters.get('steps', 0):.0f}",
        )

    try:
        with bar:
            yield report
    except KeyboardInterrupt:
        if not locate(directory).exists():
            raise
        go_on = f"nrchain resume {shlex.quote(str(directory))}"
        complain(f"interrupted; what was reached is kept; go on with: {go_on}")
        raise typer.Exit(INTERRUPTED) from None


def _beside(trajectory: Trajectory, name: str = PICTURE) -> Path:
    """Where the picture of a trajectory goes; of a file named by its user, with that name."""
    from nrchain.trajectory.file import FILE_NAME

    assert trajectory.path is not None
    of = "" if trajectory.path.name == FILE_NAME else f"{trajectory.path.stem}-"
    return trajectory.path.with_name(of + name)


def _finish(trajectory: Trajectory) -> None:
    """Draw the picture, print what was done and where it is, and exit by how it ended."""
    from nrchain.run.work import DEFINITION

    places = [f"trajectory  {trajectory.path}"] if trajectory.path else []
    if picture := _picture(trajectory):
        places.append(f"picture     {picture}")
    _mention(counters_table(trajectory))
    _mention(DEFINITION, soft_wrap=True)
    _mention(effects_table(trajectory))
    _mention(*places, soft_wrap=True)
    if trajectory.path is None:
        complain(f"nothing is kept: {trajectory.reason or 'the file was removed meanwhile'}")
        raise typer.Exit(STOPPED)
    if trajectory.status != "completed":
        reached, end = trajectory.time[-1], trajectory.scene.run.end
        advice = f"; {trajectory.advice}" if trajectory.advice else ""
        complain(
            f"stopped early: {trajectory.reason}; kept are {len(trajectory.time)} of "
            f"{trajectory.scene.run.snapshots} snapshots, to t = {reached:.6g} of {end:.6g}{advice}"
        )
        raise typer.Exit(STOPPED)


def _picture(trajectory: Trajectory) -> Path | None:
    """The picture beside the file of a run; None where it cannot be made, which is said."""
    from nrchain.view.plots import draw_chain

    if trajectory.path is None:
        return None
    try:
        return draw_chain(trajectory, _beside(trajectory))
    except (OSError, ValueError, RuntimeError, MemoryError, ArithmeticError) as error:
        complain(f"note: there is no picture: {error}")
        return None
