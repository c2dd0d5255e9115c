"""Options of films, and the bar that shows how many frames are drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from enum import StrEnum
from typing import Annotated

import typer

from nrchain.cli.terminal import console
from nrchain.errors import SceneError

Update = Callable[[int, int], None]


class Spacing(StrEnum):
    """How the times of a picture or a film are chosen."""

    linear = "linear"
    logarithmic = "logarithmic"


FPS = 25.0

FramesPerSecond = Annotated[
    float | None,
    typer.Option("--fps", help="Frames per second of a film.", show_default=f"{FPS:g}"),
]


def refuse_options(options: Mapping[str, object], where: str) -> None:
    """Raise :class:`~nrchain.errors.SceneError` for options that are given and apply elsewhere."""
    for name, value in options.items():
        if value is not None:
            raise SceneError(f"--{name}", getattr(value, "value", value), f"applies to {where}")


@contextmanager
def frames_bar() -> Iterator[Update | None]:
    """Show how many frames are drawn, where standard error is a terminal."""
    screen = console(stderr=True)
    if not screen.is_terminal:
        yield None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    columns = (BarColumn(), MofNCompleteColumn(), "frames, left", TimeRemainingColumn())
    with Progress(*columns, console=screen, transient=True) as bar:
        task = bar.add_task("", total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
