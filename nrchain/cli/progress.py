"""What a run shows while it goes on: a bar of the time reached, and afterwards its warnings."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING
from warnings import catch_warnings

import typer

from nrchain.cli.terminal import console, report, warn
from nrchain.errors import SceneWarning
from nrchain.progress import terminal_bar
from nrchain.run.interruption import INTERRUPTED

if TYPE_CHECKING:
    from nrchain.run.recording import Progress

    Update = Callable[[Progress], None]


@contextmanager
def progress_bar(place: Path, *, hidden: bool = False) -> Iterator[Update | None]:
    """Show the time reached by the run at ``place``; if interrupted, say how to continue it.

    Nothing is to be updated where the bar is ``hidden`` or standard error is no terminal.
    """
    from nrchain.trajectory.file import locate

    screen = console(stderr=True)
    try:
        with terminal_bar(screen) if screen.is_terminal and not hidden else nullcontext() as draw:
            yield None if draw is None else lambda progress: draw(progress.shown())
    except KeyboardInterrupt:
        if not locate(place).exists():
            raise
        command = f"nrchain resume {shlex.quote(str(place))}"
        report(f"interrupted; the snapshots so far are kept; to continue: {command}")
        raise typer.Exit(INTERRUPTED) from None


@contextmanager
def report_warnings(known: Collection[str] = ()) -> Iterator[None]:
    """Collect the warnings of a run; afterwards report those that are not ``known``."""
    with catch_warnings(record=True, action="always", category=SceneWarning) as caught:
        yield
    for text in (str(one.message) for one in caught or ()):
        if text not in known:
            warn(text)
