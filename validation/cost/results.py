"""Results of the four work–precision maps, and the target errors that they mark."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nrchain.accuracy.timing import Measured
from nrchain.theory.lattice_sums import Reach

TARGETS = (1e-2, 1e-3, 1e-6)
"""Errors for which tables and figures mark the cheapest choice."""
TARGET_NAMES = {1e-2: "1 %", 1e-3: "0.1 %", 1e-6: "1e-6"}
DEFAULT = "radau", 1e-6
"""Integrator and tolerance of a scene that names none."""


@dataclass(frozen=True)
class Setting:
    """An integrator at one tolerance (rtol = atol): its error and its time."""

    scheme: str
    tolerance: float
    measured: Measured

    @property
    def is_default(self) -> bool:
        return (self.scheme, self.tolerance) == DEFAULT


@dataclass(frozen=True)
class Map:
    """All settings of one scene; ``floor`` bounds the error of the reference."""

    name: str
    settings: list[Setting]
    floor: float

    def cheapest(self, level: float) -> Setting | None:
        """The setting of least median processor time with an error of at most ``level``."""
        good = [s for s in self.settings if s.measured.error <= level]
        return min(good, key=lambda s: s.measured.median, default=None)


@dataclass(frozen=True)
class Reached:
    """One mode at one reach: relative errors against all pairs, and times.

    ``until``: time up to which trajectories are compared. It is the end of the scene, or earlier
    if the run with all pairs stops earlier.
    ``path``: largest distance from the run with all pairs, over the longest path of a sphere.
    ``rate``: relative error of Λ.
    ``once``: seconds of one right-hand side of 2048 spheres.

    ``path`` and ``measured`` are None where the reach covers the whole chain of the scene.
    """

    label: str
    reach: Reach
    until: float
    path: float | None
    measured: Measured | None
    rate: float
    once: float

    @property
    def is_default(self) -> bool:
        return self.reach == 1


@dataclass(frozen=True)
class Case:
    """Relative error of the velocities at one distance, by level of the model."""

    distance: float
    errors: dict[str, float]


@dataclass(frozen=True)
class Priced:
    """A level at d = 10a: its error, and the seconds of one evaluation for five spheres."""

    level: str
    error: float
    seconds: float


@dataclass(frozen=True)
class Resolved:
    """A wave of n spheres: relative error of Λ by kind, and the cost of one decay time."""

    count: int
    errors: dict[str, float]
    measured: Measured | None


def marks(one: Map, setting: Setting) -> str:
    """Marks of a setting: "default", and the targets that it meets in the least time."""
    found = ["default"] if setting.is_default else []
    return ", ".join(found + [TARGET_NAMES[v] for v in TARGETS if one.cheapest(v) is setting])


def rate_marks(row: Sequence[Reached], point: Reached) -> str:
    """Marks of a reach: "default", and the targets for which it is the shortest."""
    found = ["default"] if point.is_default else []
    return ", ".join(found + [TARGET_NAMES[v] for v in TARGETS if least_reach(row, v) is point])


def least_reach(row: Sequence[Reached], level: float) -> Reached | None:
    """The shortest reach whose error of the rate is at most ``level``."""
    return next((p for p in row if p.rate <= level), None)
