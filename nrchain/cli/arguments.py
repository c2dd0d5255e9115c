"""Arguments that several commands share, and what they name: a scene, or a run."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrchain.cli.completion import complete_key, complete_scene
from nrchain.cli.exits import show, show_if_possible
from nrchain.cli.records import show_json
from nrchain.cli.terminal import note, paragraph, warn
from nrchain.errors import NrchainError, TrajectoryError

if TYPE_CHECKING:
    from nrchain.exchange.start import StartingFrame
    from nrchain.planning.choice import Choice
    from nrchain.scene.scene import Scene

RUNS = Path("runs")
"""Folder of runs whose place is not given."""

Run = Annotated[Path, typer.Argument(help="Directory or file of a run.", show_default=False)]
SceneName = Annotated[
    str,
    typer.Argument(
        help="Name of a shipped scene, or a TOML file.",
        show_default=False,
        autocompletion=complete_scene,
    ),
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        autocompletion=complete_key,
        help="Change a key of the scene, such as slip.2s=50, in the units of the scene."
        " Can be repeated.",
    ),
]


class Style(Enum):
    """How much a command prints on standard output."""

    SHORT, FULL, NOTHING, JSON = range(4)

    @classmethod
    def of(cls, *, as_json: bool = False, quiet: bool = False, verbose: bool = False) -> Style:
        """The style of the options ``--json``, ``-q`` and ``-v``, of which one may be given."""
        options = {
            "--json": (as_json, cls.JSON),
            "-q": (quiet, cls.NOTHING),
            "-v": (verbose, cls.FULL),
        }
        given = [name for name, (is_given, _) in options.items() if is_given]
        if len(given) > 1:
            raise NrchainError(f"{' and '.join(given)} exclude each other")
        return options[given[0]][1] if given else cls.SHORT

    @property
    def is_text(self) -> bool:
        """Whether there is text for a reader."""
        return self in (Style.SHORT, Style.FULL)


Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, and no more.")
]
Verbose = Annotated[
    bool, typer.Option("-v", "--verbose", help="Print tables of all counts, effects and errors.")
]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing on standard output.")]
OverwritePicture = Annotated[
    bool, typer.Option("--overwrite", help="Replace the file that -o names.")
]


def picture_option(default: str) -> Any:
    """The option ``-o`` for a picture; ``default`` says where it goes without."""
    help_text = "File to write: PNG, PDF or SVG."
    return typer.Option("-o", "--output", help=help_text, show_default=default)


def show_picture(path: Path | None, style: Style) -> None:
    """Print the path of a picture that is written; None for a window, which has none."""
    if style is Style.JSON:
        show_json({"picture": path})
    elif style.is_text and path is not None:
        show(str(path), soft_wrap=True)


def load(
    name: str,
    changes: Sequence[str] | None,
    start: StartingFrame | None = None,
    *,
    lines: bool = True,
) -> tuple[Scene, Choice | None]:
    """The scene with the changes of ``--set``, at the start of ``--from``.

    Where it has ``effects = "auto"``, choose its effects and, with ``lines``, print the choice.
    """
    from nrchain.scene.loading import load_scene
    from nrchain.scene.toml import parse_assignment

    scene = load_scene(name, **dict(parse_assignment(change) for change in changes or ()))
    if start is not None:
        from nrchain.exchange.start import scene_at

        scene = scene_at(start, scene)
    if scene.effects != "auto":
        return scene, None
    from nrchain.planning.auto import choose

    scene, choice = choose(scene)
    if lines:
        show_if_possible(*map(paragraph, choice.lines()), soft_wrap=True)
    return scene, choice


def report_risks(scene: Scene, warnings: Sequence[str]) -> None:
    """Note the keys of a scene that have no effect, and report its warnings."""
    from nrchain.planning.description import without_effect

    for key, why in without_effect(scene):
        note(f"{key} has no effect: {why}")
    for text in warnings:
        warn(text)


def find_run(given: Path) -> Path:
    """The directory or file of a run; raise :class:`TrajectoryError` for one found in runs/."""
    nearby = RUNS / given
    if not given.exists() and nearby.exists():
        raise TrajectoryError(f"{given}: there is no such trajectory; did you mean {nearby}?")
    return given


def find_start(place: str) -> StartingFrame:
    """The frame that ``PATH[:FRAME]`` names."""
    from nrchain.exchange.start import read_start, split_frame

    find_run(split_frame(place)[0])
    return read_start(place)
