"""(x, y) → scene: the plane of two keys, and the lattice of points on which it is explored.

Points are named by whole numbers (i, j). Points of the first, coarse grid are 2^levels apart; each
level halves the distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from nrchain.effects.registry import acting
from nrchain.errors import SceneError
from nrchain.inputs.rules import is_number, is_whole
from nrchain.scene.loading import require_chosen
from nrchain.scene.scene import Scene
from nrchain.states.parameters import find_parameter

COUNT = 9
"""Points of the first grid along each axis, unless another number is given."""

MOST_LEVELS = 8

Site = tuple[int, int]
"""A point of the lattice."""


@dataclass(frozen=True)
class Axis:
    """A key, the range that it covers, and the number of points of the first grid."""

    key: str
    low: float
    high: float
    count: int = COUNT

    @classmethod
    def read(cls, name: str, given: Any) -> Axis:
        """The axis of ``(key, low, high)`` or ``(key, low, high, count)``."""
        if isinstance(given, Axis):
            given = (given.key, given.low, given.high, given.count)
        allowed = "must be (key, low, high) or (key, low, high, points), as ('slip.2s', 0.0, 100.0)"
        if isinstance(given, str) or not isinstance(given, Sequence) or len(given) not in (3, 4):
            raise SceneError(name, given, allowed)
        key, low, high, *count = given
        if not isinstance(key, str):
            raise SceneError(name, given, allowed)
        if not (is_number(low) and is_number(high) and low < high):
            raise SceneError(f"{name}: {key}", (low, high), "must go from a number to a larger one")
        if count and not (is_whole(count[0]) and count[0] >= 2):
            raise SceneError(f"{name}: {key}", count[0], "must have at least 2 points")
        return cls(key, float(low), float(high), *map(int, count))


@dataclass(frozen=True)
class Plane:
    """A scene with two of its numbers varied.

    Attributes
    ----------
    scene
        The scene that is varied.
    x, y
        The axes.
    levels
        How often the distance of points may be halved.
    """

    scene: Scene
    x: Axis
    y: Axis
    levels: int

    @property
    def step(self) -> int:
        """Distance of points of the first grid, in points of the finest."""
        return 2**self.levels

    @cached_property
    def ends(self) -> Site:
        """The largest i and j."""
        return (self.x.count - 1) * self.step, (self.y.count - 1) * self.step

    def place(self, site: tuple[float, float]) -> tuple[float, float]:
        """(x, y) of a point, which may lie between those of the lattice."""
        return _along(self.x, site[0], self.ends[0]), _along(self.y, site[1], self.ends[1])

    def at(self, site: Site) -> Scene:
        """The scene of a point."""
        x, y = self.place(site)
        changed = find_parameter(self.scene, self.x.key).changed(x)
        return find_parameter(changed, self.y.key).changed(y)

    def check(self) -> None:
        """Raise :class:`~nrchain.errors.SceneError` for what no diagram can be drawn of."""
        require_chosen(self.scene)
        for effect in acting(self.scene):
            if not effect.covariant:
                allowed = (
                    "does not move and rotate with the chain, which then has no states of steady"
                    " motion; remove it for a phase diagram"
                )
                raise SceneError(effect.key, effect.value(self.scene), allowed)
        for name, axis in (("x", self.x), ("y", self.y)):
            try:
                find_parameter(self.scene, axis.key)
            except SceneError as error:
                raise SceneError(name, axis.key, error.allowed) from None
        if self.x.key == self.y.key:
            raise SceneError("y", self.y.key, "must be another key than x")
        if not (is_whole(self.levels) and 0 <= self.levels <= MOST_LEVELS):
            raise SceneError(
                "levels", self.levels, f"must be a whole number from 0 to {MOST_LEVELS}"
            )
        right, top = self.ends
        for corner in ((0, 0), (right, 0), (0, top), (right, top)):
            self.at(corner)


def _along(axis: Axis, place: float, end: int) -> float:
    """The value at a place from 0 to ``end``; both ends are exact."""
    share = place / end
    return axis.low * (1.0 - share) + axis.high * share
