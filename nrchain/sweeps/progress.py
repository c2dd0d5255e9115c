"""How far a sweep is: what its ``progress`` function gets, and a bar of it."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

Report = Callable[["SweepProgress"], None]


@dataclass(frozen=True)
class SweepProgress:
    """How many points are done.

    Attributes
    ----------
    done, total
        Points that are finished, with those that were so before, and all points asked for.
    failed
        Points whose runs failed.
    left
        Estimate of the seconds until the end; None before the first point.
    """

    done: int
    total: int
    failed: int
    left: float | None


class Counter:
    """Counts the points of a sweep, and reports each."""

    def __init__(self, total: int, report: Report | None) -> None:
        self._total, self._report = total, report
        self._done = self._new = self._failed = 0
        self._start = clock.monotonic()

    def begin(self, done: int, failed: int) -> None:
        """Report that so many more points are known already."""
        self._done += done
        self._failed += failed
        self._tell()

    def add(self, has_failed: bool) -> None:
        """Report one more point."""
        self._done, self._new = self._done + 1, self._new + 1
        self._failed += has_failed
        self._tell()

    def _tell(self) -> None:
        if self._report is None:
            return
        left = None
        if self._new:
            each = (clock.monotonic() - self._start) / self._new
            left = each * (self._total - self._done)
        self._report(SweepProgress(self._done, self._total, self._failed, left))


@contextmanager
def bar(screen: Any = None) -> Iterator[Report]:
    """Show points done, failures, the time that has passed and an estimate of what is left.

    ``screen`` is a console of rich; by default standard error.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        MofNCompleteColumn(),
        BarColumn(bar_width=None),
        TextColumn("{task.fields[failed]}"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
    )
    with Progress(*columns, console=screen or Console(stderr=True), transient=True) as shown:
        task = shown.add_task("", total=None, failed="", left="")

        def update(progress: SweepProgress) -> None:
            shown.update(
                task,
                total=progress.total,
                completed=progress.done,
                failed=f"{progress.failed} failed" if progress.failed else "",
                left="" if progress.left is None else f"left {_clock(progress.left)}",
            )

        yield update


def _clock(seconds: float) -> str:
    """Hours, minutes and seconds, as ``0:02:05``."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}"
