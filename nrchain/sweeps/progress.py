"""How far a sweep is: what its ``progress`` function gets."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass

from nrchain.progress import Shown

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

    def shown(self) -> Shown:
        """What the bar of a sweep shows."""
        failed = f"{self.failed} failed" if self.failed else ""
        return Shown(self.done, self.total, f"{self.done} of {self.total} points", failed)


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
