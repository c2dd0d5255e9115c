"""error = |measured − predicted| ≤ tolerance: what a study reports, and whether it holds.

A study is handed a :class:`Recorder` and tells it what it predicts and what it measures. Nothing
here knows of files or screens: records are plain dataclasses, and a listener hears of each check
and each step as it happens.
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
"""A number of a record; a NaN among them fails its check."""

Cell = str | int | float | bool | None
"""An entry of a table."""

DOTS_PER_INCH = 180

LIKE = 2.0
"""Factor within which seconds, and ratios of them, are those of another day or machine."""


@dataclass(frozen=True)
class Check:
    """One statement that either holds or fails.

    ``kind`` is ``"check"`` for an agreement, ``"difference"`` for a known disagreement that must
    stay as large as stated, ``"bound"`` for a number that must lie within bounds, ``"shortfall"``
    for a bar that is known not to be met; for a bound ``predicted`` is the bound nearest the
    number.
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
    """What something costs here and elsewhere; ``ratio`` is theirs over ours, above 1 if we win."""

    study: str
    name: str
    ours: float
    theirs: float
    ratio: float
    what: str
    unit: str


@dataclass(frozen=True)
class Table:
    """Rows of a report; ``first_page`` tables are also shown before all studies."""

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
    """Whoever wants to know how a study goes on."""

    def checked(self, check: Check) -> None: ...

    def stepped(self, description: str) -> None: ...


class Recorder:
    """Takes down what one study predicts, measures and shows.

    Parameters
    ----------
    study
        Name of the study, kept with every record.
    quick
        Whether the study should do with fewer points: some 25 s in place of a few minutes.
    listener
        Hears of every check and step.
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

        ``relative=False`` takes the error as it is. Numbers may be complex; NaN fails. ``source``
        is the equation of the paper or the derivation that predicts. Returns whether it holds.
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
        """|measured − stated| ≤ tolerance · |stated|: a known difference is as large as it was.

        For a misprint or a defect elsewhere: ``measured`` is its size, or the factor by which the
        other is off. It fails when the difference has gone as much as when it has grown. A
        difference of nothing, or a tolerance of 1 or more, would pass without one: ValueError.
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
        """least ≤ measured ≤ most, for slopes, counts and ratios; the error is what is too much."""
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
        """reached/2 ≤ measured ≤ 2·reached: a bar of ``asked`` is missed by as much as stated.

        For seconds and ratios of them. ``reached`` is what was measured when the bar was given up,
        and ``source`` says why. Fails where it has become worse, and where it has become so much
        better that the statement is out of date. ValueError if ``reached`` is the bar itself.
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
        """What a task costs here and elsewhere, in ``unit``; ``what`` says which task and rival."""
        ratio = float(theirs) / float(ours) if ours else math.inf
        self.benchmarks.append(
            Benchmark(self.study, name, float(ours), float(theirs), ratio, what, unit)
        )

    def figure(self, name: str, figure: Figure, caption: str) -> None:
        """Keep a matplotlib ``Figure`` (made without pyplot) for the report."""
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
        """Keep a table for the report; every row has one entry a column."""
        entries = tuple(tuple(_cell(entry) for entry in row) for row in rows)
        for row in entries:
            if len(row) != len(columns):
                raise ValueError(f"table {name}: {len(row)} entries in {len(columns)} columns")
        self.tables.append(
            Table(self.study, name, tuple(columns), entries, caption, bool(first_page))
        )

    def text(self, markdown: str) -> None:
        """A paragraph of the report, in Markdown: what the study found."""
        self.paragraphs.append(markdown)

    def step(self, description: str) -> None:
        """Say what the study does next."""
        if self._listener:
            self._listener.stepped(description)

    def fail(self, name: str, reason: str) -> None:
        """Take down that the study itself went wrong: a check that nothing fails, failed."""
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
    """A float, or a complex number if the type is one; arrays of one number count as numbers."""
    if getattr(value, "dtype", None) is not None:
        value = value.item()  # type: ignore[union-attr]
    return value if isinstance(value, complex) else float(value)  # type: ignore[arg-type]


def _cell(entry: Any) -> Cell:
    if getattr(entry, "dtype", None) is not None:
        entry = entry.item()
    return entry if entry is None or isinstance(entry, str | bool | int | float) else str(entry)
