"""error = |measured − predicted| ≤ tolerance: what a study reports, and whether it holds.

A study records predictions and measurements with a :class:`Recorder`. Records are plain
dataclasses, independent of files and screens. A listener is called at each check and each step.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, SupportsComplex, SupportsFloat

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Value = float | complex
"""A number in a record; NaN fails its check."""

Cell = str | int | float | bool | None
"""An entry of a table."""

DOTS_PER_INCH = 180

LIKE = 2.0
"""Factor by which times, and ratios of times, may differ between days and machines."""


@dataclass(frozen=True)
class Check:
    """One statement that either holds or fails.

    ``kind`` is ``"check"`` for an agreement, ``"difference"`` for a known disagreement of stated
    size, ``"bound"`` for a number within bounds, and ``"shortfall"`` for a target that is known to
    be missed. For a bound, ``predicted`` is the bound nearest to the number.
    """

    study: str
    name: str
    kind: str
    predicted: Value
    measured: Value
    error: float
    tolerance: float
    passed: bool
    source: str


@dataclass(frozen=True)
class Benchmark:
    """Cost of a task with nrchain and with a rival; ``ratio`` is theirs over ours."""

    study: str
    name: str
    ours: float
    theirs: float
    ratio: float
    what: str
    unit: str


@dataclass(frozen=True)
class Table:
    """A table of the report; those with ``first_page`` also appear before the studies."""

    study: str
    name: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    caption: str
    first_page: bool


@dataclass(frozen=True)
class Picture:
    """A figure as PNG."""

    name: str
    caption: str
    png: bytes = field(repr=False)


class Listener(Protocol):
    """Receives the checks and steps of a study as they happen."""

    def checked(self, check: Check) -> None: ...

    def stepped(self, description: str) -> None: ...


class Recorder:
    """Records the checks, tables, figures and text of one study.

    Parameters
    ----------
    study
        Name of the study, kept with every record.
    quick
        Whether the study uses fewer points: about 25 s instead of a few minutes.
    listener
        Receives every check and step.
    """

    def __init__(
        self, study: str, *, quick: bool = False, listener: Listener | None = None
    ) -> None:
        self.study, self.quick = study, quick
        self.checks: list[Check] = []
        self.benchmarks: list[Benchmark] = []
        self.tables: list[Table] = []
        self.pictures: list[Picture] = []
        self.paragraphs: list[str] = []
        self._listener = listener

    @property
    def failed(self) -> list[Check]:
        return [check for check in self.checks if not check.passed]

    def check(
        self,
        name: str,
        predicted: SupportsComplex | SupportsFloat,
        measured: SupportsComplex | SupportsFloat,
        tolerance: float,
        *,
        source: str,
        relative: bool = True,
    ) -> bool:
        """|measured − predicted| ≤ tolerance · |predicted|, or ≤ tolerance where that is zero.

        ``relative=False`` uses the absolute error. Numbers may be complex; NaN fails. ``source``
        names the equation or derivation of the prediction. Returns whether the check holds.
        """
        expected, found = _number(predicted), _number(measured)
        error = abs(found - expected)
        if relative and expected != 0:
            error /= abs(expected)
        return self._add(name, "check", expected, found, error, tolerance, source)

    def difference(
        self,
        name: str,
        stated: SupportsComplex | SupportsFloat,
        measured: SupportsComplex | SupportsFloat,
        tolerance: float,
        *,
        source: str,
    ) -> bool:
        """|measured − stated| ≤ tolerance · |stated|: a known difference has its stated size.

        For a misprint or a defect elsewhere: ``measured`` is its size, or the factor of the error.
        The check fails if the difference grows, and if it disappears. Raises ValueError if
        ``stated`` is 0 or the tolerance is 1 or more: it would pass without a difference.
        """
        expected, found = _number(stated), _number(measured)
        if expected == 0 or not tolerance < 1:
            raise ValueError(
                f"{name}: stated {expected} within {tolerance} would pass without a difference"
            )
        error = abs(found - expected) / abs(expected)
        return self._add(name, "difference", expected, found, error, tolerance, source)

    def bound(
        self,
        name: str,
        measured: SupportsFloat,
        *,
        most: float | None = None,
        least: float | None = None,
        source: str,
    ) -> bool:
        """least ≤ measured ≤ most, for slopes, counts and ratios; the error is the excess."""
        if most is None and least is None:
            raise ValueError(f"{name}: needs the most or the least that is allowed")
        found = float(measured)
        beyond = {
            limit: sign * (found - limit)
            for limit, sign in ((most, 1.0), (least, -1.0))
            if limit is not None
        }
        nearest = max(beyond, key=beyond.__getitem__)
        error = math.nan if math.isnan(found) else max(beyond[nearest], 0.0)
        return self._add(name, "bound", nearest, found, error, 0.0, source)

    def shortfall(
        self, name: str, measured: SupportsFloat, *, asked: float, reached: float, source: str
    ) -> bool:
        """reached/2 ≤ measured ≤ 2·reached: a target of ``asked`` is missed by as much as stated.

        For times and ratios of times. ``reached`` is the value measured when the target was given
        up; ``source`` gives the reason. The check fails if the value becomes worse, or so much
        better that the statement is out of date. Raises ValueError if ``reached`` is the target.
        """
        if reached == asked:
            raise ValueError(f"{name}: {reached} meets the bar of {asked}")
        found = float(measured)
        apart = max(found / reached, reached / found) if found > 0 else math.inf
        title = f"{name} ({asked:g} asked for)"
        return self._add(title, "shortfall", reached, found, apart - 1.0, LIKE - 1.0, source)

    def benchmark(
        self, name: str, ours: float, theirs: float, *, what: str, unit: str = "s"
    ) -> None:
        """Record the cost of a task here and with a rival, in ``unit``; ``what`` describes both."""
        ratio = float(theirs) / float(ours) if ours else math.inf
        self.benchmarks.append(
            Benchmark(self.study, name, float(ours), float(theirs), ratio, what, unit)
        )

    def figure(self, name: str, figure: Figure, caption: str) -> None:
        """Add a matplotlib ``Figure`` (made without pyplot) to the report."""
        png = io.BytesIO()
        figure.savefig(png, format="png", dpi=DOTS_PER_INCH, bbox_inches="tight", pad_inches=0.08)
        self.pictures.append(Picture(name, caption, png.getvalue()))

    def table(
        self,
        name: str,
        columns: Sequence[str],
        rows: Iterable[Sequence[Any]],
        caption: str,
        first_page: bool = False,
    ) -> None:
        """Add a table to the report; every row has one entry per column."""
        entries = tuple(tuple(_cell(entry) for entry in row) for row in rows)
        for row in entries:
            if len(row) != len(columns):
                raise ValueError(f"table {name}: {len(row)} entries in {len(columns)} columns")
        self.tables.append(
            Table(self.study, name, tuple(columns), entries, caption, bool(first_page))
        )

    def text(self, markdown: str) -> None:
        """Add a paragraph to the report, in Markdown."""
        self.paragraphs.append(markdown)

    def step(self, description: str) -> None:
        """Announce the next step of the study."""
        if self._listener:
            self._listener.stepped(description)

    def fail(self, name: str, reason: str) -> None:
        """Record that the study itself failed."""
        self._add(name, "check", 0.0, 1.0, 1.0, 0.0, reason)

    def _add(
        self,
        name: str,
        kind: str,
        predicted: Value,
        measured: Value,
        error: float,
        tolerance: float,
        source: str,
    ) -> bool:
        if any(check.name == name for check in self.checks):
            raise ValueError(f"two checks of study {self.study} are called {name!r}")
        passed = bool(error <= tolerance)
        check = Check(
            self.study,
            name,
            kind,
            predicted,
            measured,
            float(error),
            float(tolerance),
            passed,
            source,
        )
        self.checks.append(check)
        if self._listener:
            self._listener.checked(check)
        return passed


def _number(value: SupportsComplex | SupportsFloat) -> Value:
    """The value as float, or as complex if its type is complex; arrays of size 1 too."""
    if getattr(value, "dtype", None) is not None:
        value = value.item()  # type: ignore[union-attr]
    return value if isinstance(value, complex) else float(value)  # type: ignore[arg-type]


def _cell(entry: Any) -> Cell:
    if getattr(entry, "dtype", None) is not None:
        entry = entry.item()
    return entry if entry is None or isinstance(entry, str | bool | int | float) else str(entry)
