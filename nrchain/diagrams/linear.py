"""Re Λ₁(x, y) and where it is zero: growth of the straight chain, and how long its runs must be."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from nrchain.jobs.crew import FAILED
from nrchain.jobs.ledger import Result
from nrchain.run.interruption import Interruption
from nrchain.scene.scene import Scene
from nrchain.states.critical import critical_strength
from nrchain.states.spectrum import spectrum

MODES = 6
"""Leading eigenvalues among which the fastest frequency is sought."""

TIMES = 40.0
"""Length of a run in units of 1/|Re Λ₁|, and in periods of the leading mode."""

SLOWEST = 10.0
"""Largest 1/|Re Λ₁| that a run waits for, in units of the median over the coarse grid."""

LONGER, LONGEST = 5.0, 3000.0
"""How much longer a second run is, after one that has not settled, and how much at most."""

A_PERIOD = 24
"""Snapshots in the shortest period of the leading modes."""

LEAST_SNAPSHOTS, MOST_SNAPSHOTS = 401, 8001


@dataclass(frozen=True)
class Rate:
    """The leading mode of the straight chain at a point.

    Attributes
    ----------
    growth, frequency
        Re Λ₁ and |Im Λ₁|; NaN where the straight chain has no spectrum.
    fastest
        The largest |Im Λ| of the leading modes.
    why
        Why there is no spectrum.
    """

    growth: float = math.nan
    frequency: float = math.nan
    fastest: float = 0.0
    why: str = ""

    @classmethod
    def of(cls, result: Result) -> Rate:
        """The rate of the result of :func:`rate`."""
        if FAILED in result:
            return cls(why=result[FAILED])
        return cls(result["growth"], result["frequency"], result["fastest"])

    @property
    def sign(self) -> int:
        """1 where the straight chain grows, −1 where it decays, and 0 where it has no spectrum."""
        return 0 if math.isnan(self.growth) else 1 if self.growth > 0.0 else -1


def rate(scene: Scene, interruption: Interruption | None = None) -> Result:
    """Growth and frequency of the leading mode of the straight chain."""
    found = spectrum(scene, modes=MODES)
    return {
        "growth": found.leading.growth,
        "frequency": abs(found.leading.frequency),
        "fastest": max(abs(mode.frequency) for mode in found.modes),
    }


def crossing(
    scene: Scene, key: str, low: float, high: float, interruption: Interruption | None = None
) -> Result:
    """The value of a key between two others at which the growth is zero."""
    found = critical_strength(scene, key, (low, high))
    return {"value": found.value, "error": found.error, "frequency": found.frequency}


@dataclass(frozen=True)
class Length:
    """How long a run goes, and how many snapshots it takes.

    ``is_capped`` says that rates ask for a longer run; ``most`` is the largest end that is allowed.
    """

    end: float
    snapshots: int
    is_capped: bool = False
    most: float = math.inf

    def longer(self, growth: float | None = None) -> Length | None:
        """The length of another run, after one of this length that has not settled.

        It is :data:`LONGER` times as long. ``growth`` is Re Λ₁ of the state that is found from its
        end. If this state is stable, or so slowly left that the run has not shown it, the next run
        lasts at least :data:`TIMES` times 1/|Re Λ₁| longer. None if it may not last longer.
        """
        end, snapshots = LONGER * self.end, math.ceil(LONGER * self.snapshots)
        if growth and growth * self.end < 1.0 and self.end + TIMES / abs(growth) > end:
            end, snapshots = self.end + TIMES / abs(growth), self.snapshots
        allowed = min(end, self.most, LONGEST * self.end)
        if allowed < 1.5 * self.end:
            return None
        return Length(allowed, min(snapshots, MOST_SNAPSHOTS), allowed < end, self.most)


class Lengths:
    """End and snapshots of runs, from the rates of the straight chain.

    A run lasts :data:`TIMES` times 1/|Re Λ₁|, at least that of the median over the coarse grid and
    at most :data:`SLOWEST` times as long, and as many periods of the leading mode. ``longest``
    limits it further. Without any rate the runs are as long as that of the scene.
    """

    def __init__(self, scene: Scene, coarse: Collection[Rate], longest: float | None) -> None:
        times = [1.0 / abs(one.growth) for one in coarse if one.sign and one.growth]
        self._scene, self._longest = scene, math.inf if longest is None else longest
        self._usual = float(np.median(times)) if times else math.nan

    def of(self, rate: Rate) -> Length:
        """The length of the runs at a point."""
        if math.isnan(self._usual):
            run = self._scene.run
            end = min(run.end, self._longest)
            return Length(end, run.snapshots, end < run.end, self._longest)
        most = SLOWEST * self._usual
        slow = 1.0 / abs(rate.growth) if rate.sign and rate.growth else most
        period = 2.0 * math.pi / rate.frequency if rate.sign and rate.frequency else 0.0
        wanted = TIMES * (max(slow, self._usual) + period)
        end = min(TIMES * (min(max(slow, self._usual), most) + min(period, most)), self._longest)
        count = LEAST_SNAPSHOTS
        if rate.fastest:
            count = max(count, math.ceil(end * rate.fastest * A_PERIOD / (2.0 * math.pi)) + 1)
        if count > MOST_SNAPSHOTS:
            end *= (MOST_SNAPSHOTS - 1) / (count - 1)
            count = MOST_SNAPSHOTS
        return Length(end, count, end < wanted * (1.0 - 1e-12), self._longest)
