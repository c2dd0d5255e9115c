"""Which observables have no value at some points of a sweep, and why."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from nrchain.jobs.crew import FAILED

NUMBER = re.compile(r"[-+−]?\d[\d.]*(?:e[-+]?\d+)?")
"""Numbers in a reason, by which the reasons of two points may differ."""


@dataclass(frozen=True)
class WithoutValue:
    """An observable that has no value at some points whose runs ended.

    Attributes
    ----------
    name
        The observable.
    points
        The number of points where it has no value.
    total
        The number of points where it was observed.
    cause
        The most frequent reason, of one of these points; empty where none has a reason, as for the
        period of a steady state.
    """

    name: str
    points: int
    total: int
    cause: str

    def __str__(self) -> str:
        cause = f"; most often: {self.cause}" if self.cause else ""
        return f"{self.name} at {self.points} of {self.total} points{cause}"


def without_value(points: Iterable[Any], names: Sequence[str]) -> list[WithoutValue]:
    """The observables, of those named, that lack values; failed runs do not count."""
    ended = [point for point in points if point.outcome != FAILED]
    found = []
    for name in names:
        observed = [point for point in ended if name in point.observables]
        empty = [point for point in observed if not has_value(point.observables[name])]
        if empty:
            reasons = [point.unmeasured[name] for point in empty if name in point.unmeasured]
            found.append(WithoutValue(name, len(empty), len(observed), most_frequent(reasons)))
    return found


def has_value(value: Any) -> bool:
    """Whether an observable is there: neither None nor NaN."""
    return value is not None and value == value


def most_frequent(reasons: Sequence[str]) -> str:
    """The first of the most frequent reasons; empty without any.

    >>> most_frequent(["no wave at t = 2.5", "too short", "no wave at t = 3"])
    'no wave at t = 2.5'
    """
    if not reasons:
        return ""
    kinds = [NUMBER.sub("#", reason) for reason in reasons]
    return reasons[kinds.index(Counter(kinds).most_common(1)[0][0])]
