"""p → scene: a scene along one key, or along a line in several."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from nrchain.errors import SceneError
from nrchain.inputs.rules import is_number
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.states.parameters import parameters

CHAIN = "chain.spacing", "chain.radius", "chain.viscosity"
"""Keys of the chain that may vary; its number of spheres and its ends may not."""

BETWEEN = 0.5 * (3.0 - math.sqrt(5.0))
"""Fraction of a range at which a key that takes only whole numbers has none."""


def varied(scene: Scene, key: str) -> Callable[[float], Scene]:
    """The scene with another value of a key on which its motion depends.

    ``key`` is dotted and has one number for a value, such as ``slip.2s``, whether the scene names
    it or not. ``slip.2s[3]`` is one number of a list.
    """
    numbers = {one.key: one.changed for one in parameters(scene)}
    if key in numbers:
        return numbers[key]
    section = str(key).partition(".")[0]
    if key not in CHAIN and section not in {"elasticity", "slip", *scene.further}:
        allowed = f"must be a number on which motion depends, such as {', '.join(numbers)}"
        raise SceneError("key", key, allowed)
    return lambda value: load_scene(scene, **{key: value})


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
        scene = self.scene
        for key, place in self.values(value).items():
            scene = varied(scene, key)(float(place))
        return scene

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
