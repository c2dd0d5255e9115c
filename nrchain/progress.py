"""The progress bar of long computations, in a terminal and in a notebook.

A computation takes ``progress``: True for a bar, or a function that is called with its reports. The
bar goes to standard error, and only if that is a terminal or the computation runs in a notebook.
"""

from __future__ import annotations

import html
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from nrchain.errors import SceneError

if TYPE_CHECKING:
    from rich.console import Console

Report = TypeVar("Report")

INTERVAL = 0.2
"""Least seconds between two drawings of a bar in a notebook."""


@dataclass(frozen=True)
class Shown:
    """What a bar shows: how much is done of a total, a text before the bar and one after it.

    Without a ``total`` the bar only moves.
    """

    done: float
    total: float | None = None
    before: str = ""
    after: str = ""


@contextmanager
def updates(
    progress: bool | Callable[[Report], None] | None, show: Callable[[Report], Shown]
) -> Iterator[Callable[[Report], None] | None]:
    """What a computation calls with its reports, for the ``progress`` that a user gave it.

    ``show`` turns a report into what the bar shows. Raises :class:`~nrchain.errors.SceneError` for
    a ``progress`` that is neither a flag nor a function.
    """
    if progress is None or progress is False:
        yield None
    elif progress is True:
        with bar() as draw:
            yield None if draw is None else lambda report: draw(show(report))
    elif callable(progress):
        yield progress
    else:
        raise SceneError("progress", progress, "must be True, False or a function")


@contextmanager
def bar() -> Iterator[Callable[[Shown], None] | None]:
    """What draws the bar; None where there is neither a terminal nor a notebook."""
    from rich.console import Console

    screen = Console(stderr=True, markup=False, emoji=False, highlight=False)
    if screen.is_jupyter:
        with _notebook_bar() as draw:
            yield draw
    elif screen.is_terminal:
        with terminal_bar(screen) as draw:
            yield draw
    else:
        yield None


@contextmanager
def terminal_bar(screen: Console) -> Iterator[Callable[[Shown], None]]:
    """The bar in a terminal, which disappears at the end."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.progress import TimeRemainingColumn as TimeLeft

    columns = (
        TextColumn("{task.fields[before]}", markup=False),
        BarColumn(bar_width=None),
        TextColumn("{task.fields[after]}", markup=False),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeLeft(),
    )
    with Progress(*columns, console=screen, transient=True) as lines:
        task = lines.add_task("", total=None, before="", after="")

        def draw(shown: Shown) -> None:
            lines.update(
                task,
                total=shown.total,
                completed=shown.done,
                before=shown.before,
                after=shown.after,
            )

        yield draw


@contextmanager
def _notebook_bar() -> Iterator[Callable[[Shown], None]]:
    """The bar below a cell of a notebook, which stays as it ends. Needs no widgets."""
    # a notebook has IPython; nrchain does not require it
    from IPython.display import HTML, display  # type: ignore[import-not-found, unused-ignore]

    began = time.monotonic()
    latest = Shown(0.0)
    drawn = began
    place: Any = display(HTML(bar_html(latest, 0.0)), display_id=True)

    def draw(shown: Shown) -> None:
        nonlocal latest, drawn
        latest, now = shown, time.monotonic()
        if now - drawn >= INTERVAL:
            drawn = now
            place.update(HTML(bar_html(shown, now - began)))

    try:
        yield draw
    finally:
        place.update(HTML(bar_html(latest, time.monotonic() - began)))


def bar_html(shown: Shown, seconds: float) -> str:
    """The bar as HTML, with the seconds it took so far and those that are left.

    >>> bar_html(Shown(1.0, 4.0, "t = 1 of 4"), 2.0)
    't = 1 of 4 <progress value="0.25" max="1"></progress>  2 s, 6 s left'
    """
    part = shown.done / shown.total if shown.total else 0.0
    value = f'value="{part:.3g}" ' if shown.total else ""
    left = f", {seconds * (1.0 / part - 1.0):.0f} s left" if 0.0 < part < 1.0 else ""
    before, after = html.escape(shown.before), html.escape(shown.after)
    return f'{before} <progress {value}max="1"></progress> {after} {seconds:.0f} s{left}'
