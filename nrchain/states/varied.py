"""p → scene: a scene along one key, or along a line in several."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from nrchain.errors import SceneError
from nrchain.inputs.rules import is_number
from nrchain.scene.scene import Scene
from nrchain.states.parameters import Parameter, find_parameter

BETWEEN = 0.5 * (3.0 - math.sqrt(5.0))
"""Fraction of a range at which a key that takes only whole numbers has none."""


@dataclass(frozen=True)
class Line:
    """A scene along a line in the space of its numbers.

    Attributes
    ----------
    scene
        The scene that is varied.
    ranges
        (low, high) of each key, in order. The first one measures the place on the line.
    """

    scene: Scene
    ranges: Mapping[str, tuple[float, float]]

    @property
    def key(self) -> str:
        """The first key, whose value p is the place on the line."""
        return next(iter(self.ranges))

    @property
    def low(self) -> float:
        """Value of the first key at the beginning of the line."""
        return self.ranges[self.key][0]

    @property
    def high(self) -> float:
        """Value of the first key at the end of the line."""
        return self.ranges[self.key][1]

    @property
    def length(self) -> float:
        """|high − low| of the first key."""
        return abs(self.high - self.low)

    def values(self, value: float) -> dict[str, float]:
        """The values of all keys where the first has ``value``."""
        part = (value - self.low) / (self.high - self.low)
        further = {key: low + part * (high - low) for key, (low, high) in self.ranges.items()}
        return {**further, self.key: value}

    def at(self, value: float) -> Scene:
        """The scene where the first key has ``value``."""
        scene = self._first.changed(float(value))
        for key, place in list(self.values(value).items())[1:]:
            scene = find_parameter(scene, key).changed(float(place))
        return scene

    def __getstate__(self) -> dict[str, Any]:
        # how a key is changed is a function, which cannot be pickled
        return {"scene": self.scene, "ranges": self.ranges}

    @cached_property
    def _first(self) -> Parameter:
        return find_parameter(self.scene, self.key)

    def holds(self, value: float) -> bool:
        """Whether ``value`` is between the ends."""
        return min(self.low, self.high) <= value <= max(self.low, self.high)


def line(scene: Scene, along: Mapping[str, Any]) -> Line:
    """A checked line: every key matters to the motion, and the scene may be loaded all along it.

    Raises :class:`~nrchain.errors.SceneError` with the key, its range and what is allowed.
    """
    if not isinstance(along, Mapping) or not along:
        raise SceneError("along", along, 'must name a key and its ends, as {"slip.2s": (0, 150)}')
    ranges = {}
    for key, ends in along.items():
        try:
            low, high = ends
        except (TypeError, ValueError):
            low = high = math.nan
        if not (is_number(low) and is_number(high) and low != high):
            raise SceneError(f"along {key}", ends, "must be two different finite numbers")
        ranges[str(key)] = float(low), float(high)
    found = Line(scene, ranges)
    for part in (0.0, BETWEEN, 1.0):
        found.at(found.low + part * (found.high - found.low))
    return found
