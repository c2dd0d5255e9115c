"""The result of a measurement of error against work, and the advice that follows from it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from nrchain.accuracy.cost.settings import LIMITS, Axis, Changes
from nrchain.accuracy.timing import Measured
from nrchain.errors import SceneError
from nrchain.notebook import record_html, table_html
from nrchain.run.work import (
    DEFINITION,
    FEWEST_STEPS,
    LARGEST_FACTOR,
    RunCost,
    extrapolation_factors,
)
from nrchain.scene.scene import Scene
from nrchain.wording import brief, digits, span

MARGIN = 2.0
"""Safety factor: the error of a recommended setting is below the target by at least this factor."""

RESOLVED = 10.0
"""The smallest error that the reference resolves, in units of its own error."""


@dataclass(frozen=True)
class Point:
    """A setting of an axis: its name, its changes to the scene, and what was measured of it."""

    axis: Axis
    setting: str
    changes: Changes
    measured: Measured

    __repr__ = brief
    _repr_html_ = record_html


@dataclass(frozen=True)
class Advice:
    """The cheapest setting that reaches a target, or the most accurate one if none does.

    Attributes
    ----------
    target
        The global error asked for, in radii and radians.
    point
        The recommended setting.
    reached
        Whether it reaches the target over the whole run, with a margin.
    known
        Whether ``error`` and ``seconds`` are those of the whole run; else of the part that was run.
    error
        The global error of the setting, in radii and radians.
    seconds
        Its processor time in seconds (least, most); None for a run of too few steps to time.
    sure
        How well error and time are known, one sentence an entry.
    """

    target: float
    point: Point
    reached: bool
    known: bool
    error: float
    seconds: tuple[float, float] | None
    sure: list[str]

    __repr__ = brief
    _repr_html_ = record_html

    def lines(self) -> list[str]:
        """Error and processor time in words, and how well both are known."""
        time = f"{span(*map(digits, self.seconds))} s" if self.seconds else "not known"
        part = "for the whole run" if self.known else "for the part that was run"
        return [f"global error {self.error:.1e}, processor time {time}, {part}", *self.sure]

    @property
    def arguments(self) -> str:
        """The setting as options of ``nrchain run``."""
        return " ".join(f"--set {key}={value}" for key, value in self.point.changes.items())


@dataclass(frozen=True)
class WorkPrecision:
    """Error against work of a scene, measured up to t = ``reached``.

    Attributes
    ----------
    own
        The cost of the unchanged scene, as a run and a plan report it.
    points
        What was measured, one point a setting.
    reference
        The name of the reference run.
    reference_error
        Its distance from an independent run, in radii and radians.
    skipped
        What was not measured, and why.
    """

    scene: Scene
    reached: float
    own: RunCost
    points: list[Point]
    reference: str
    reference_error: float
    skipped: list[str] = field(default_factory=list)

    __repr__ = brief

    def _repr_html_(self) -> str:
        rows = [
            (one.axis, one.setting, one.measured.error, *one.measured.work, one.measured.median)
            for one in self.points
        ]
        counts = ("steps", "right-hand sides", "Jacobians", "solves")
        heads = ("", "setting", "error", *counts, "processor time (s)")
        return table_html(f"Error against work, up to t = {self.reached:.6g}", rows, heads)

    @property
    def part(self) -> float:
        """The fraction of the run that the short runs cover."""
        return self.reached / self.scene.run.end

    def whole_run(self, measured: Measured) -> tuple[float, float] | None:
        """Processor time of the whole run in seconds (least, most); None if not known.

        The range is that of the repetitions, extrapolated by
        :func:`nrchain.work.extrapolation_factors`.
        """
        factors = extrapolation_factors(self.part, measured.late)
        if factors is None or measured.work.steps < FEWEST_STEPS:
            return None
        least, most = factors
        return min(measured.seconds) * least, max(measured.seconds) * most

    def notes(self) -> list[str]:
        """What the numbers mean, one line each: the part of the run, the references, the gaps."""
        lines = [
            "the short runs cover the whole run"
            if self.part == 1.0
            else f"the short runs cover t = 0 to {self.reached:.4g}, {self.part:.2g} of the run",
            f"the unchanged scene: {self.own.words()}",
            DEFINITION,
            f"error of stepping: largest distance from {self.reference}, in radii and radians; an "
            f"independent run differs from it by {self.reference_error:.1e}",
            "error of reach and model: largest distance from the last run of that list, at the "
            "tolerances of the scene",
        ]
        if self.scene.run.max_steps is not None or self.scene.run.max_seconds is not None:
            lines.append(f"the short runs ignore {' and '.join(LIMITS)}")
        return lines + [f"not measured: {reason}" for reason in self.skipped]

    def advise(self, target: float) -> Advice:
        """The cheapest stepping whose global error, in radii and radians, is below a target.

        The measured error must be below the target by the factor :data:`MARGIN`. Where the short
        runs end before the run does, their error is extrapolated in proportion to time. Where they
        cover less than 1/:data:`nrchain.work.LARGEST_FACTOR` of the run, nothing is extrapolated:
        the advice is for the part that they cover.

        Raises :class:`~nrchain.errors.SceneError` for a target that is not a number above 0.
        """
        check_target(target)
        known = self.part * LARGEST_FACTOR >= 1.0
        floor, share = RESOLVED * self.reference_error, self.part if known else 1.0
        stepping = [point for point in self.points if point.axis == "stepping"]
        errors = [max(point.measured.error, floor) / share for point in stepping]
        good = [k for k, error in enumerate(errors) if error * MARGIN <= target]
        if good:
            best = min(good, key=lambda k: stepping[k].measured.median)
        else:
            best = min(range(len(errors)), key=errors.__getitem__)
        point, error = stepping[best], errors[best]
        times = point.measured.seconds
        seconds = self.whole_run(point.measured) if known else (min(times), max(times))
        sure = list(self._confidence(point, error, target, known))
        return Advice(target, point, bool(good) and known, known, error, seconds, sure)

    def _confidence(self, point: Point, error: float, target: float, known: bool) -> Iterator[str]:
        """How well the advice is known: its margin, its reference, its repetitions, its range."""
        if not known:
            yield (
                f"not known for the whole run: the short runs cover {self.part:.2g} of it, and are "
                f"extrapolated by no more than a factor of {LARGEST_FACTOR:g}; a larger --budget "
                "covers more"
            )
        if not error:
            yield "no two runs differ: the chain does not move"
        elif error * MARGIN <= target:
            yield f"the error is below the target by a factor of {target / error:.2g}"
        else:
            yield (
                f"no setting reaches {target:.2g} with the required margin of a factor of "
                f"{MARGIN:g}; this one is the most accurate"
            )
        yield (
            f"the error is the distance from {self.reference}, which agrees with an independent "
            f"run to {self.reference_error:.1e}"
        )
        seconds = point.measured.seconds
        if len(seconds) > 1:
            took = span(digits(min(seconds)), digits(max(seconds)))
            yield f"{len(seconds)} repetitions took {took} s"
        else:
            yield f"one run took {digits(seconds[0])} s; the budget allowed no repetition"
        if self.part == 1.0:
            yield "measured over the whole run: nothing is extrapolated"
        elif known:
            yield (
                f"measured up to t = {self.reached:.4g}, {self.part:.2g} of the run, and "
                "extrapolated: the error in proportion to time, the work at the same pace; a chain "
                "that buckles, coils or accelerates later has a larger error and takes more work"
            )


def check_target(target: float) -> None:
    """Raise :class:`~nrchain.errors.SceneError` for an error that is not a number above 0."""
    if not (math.isfinite(target) and target > 0):
        raise SceneError("target", target, "must be a finite number above 0")
