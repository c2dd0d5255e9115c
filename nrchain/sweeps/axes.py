"""Values of keys: lists, ranges with ends included, and random numbers between ends.

A text gives values as the command line does: ``"-100:100:21"`` is 21 numbers evenly spaced,
``"1:1000:4:log"`` four with constant ratio, ``"16,32,64"`` a list. Of numbers that are drawn only
the ends are given: ``"-100:100"``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.rules import is_number, is_whole
from nrchain.scene.scene import Scene
from nrchain.scene.toml import flat_keys, parse_assignment

LOG = "log"
"""The word that spaces or draws numbers by their logarithm."""

VALUES = "must be low:high:count, low:high:count:log or values, such as -100:100:21 or 16,32,64"
ENDS = "must be two different finite numbers low:high, or low:high:log above 0"


@dataclass(frozen=True)
class Ends:
    """The range from which the values of a key are drawn, evenly or by their logarithm."""

    low: float
    high: float
    is_log: bool = False

    def at(self, part: float) -> float:
        """The value at a part of the range, from 0 to 1."""
        if self.is_log:
            return float(self.low * (self.high / self.low) ** part)
        return float(self.low + part * (self.high - self.low))

    def whole_at(self, part: float) -> int:
        """A whole number of the range, each as likely as the others, or by its logarithm."""
        if self.is_log:
            return round(self.at(part))
        low, high = sorted((round(self.low), round(self.high)))
        return low + int(part * (high - low + 1))


def read_values(key: str, given: Any) -> list[Any]:
    """The values of a key; SceneError names the key."""
    if isinstance(given, str):
        return _read_text(key, given)
    if not isinstance(given, Iterable) or isinstance(given, Mapping):
        raise SceneError(f"grid {key}", given, "must be a list of values, or a text such as 0:1:5")
    values = [_plain(value) for value in given]
    if not values:
        raise SceneError(f"grid {key}", given, "must have a value")
    return values


def read_ends(name: str, key: str, given: Any) -> Ends:
    """The ends of the range of a key; SceneError names the argument and the key."""
    parts = given.split(":") if isinstance(given, str) else given
    try:
        low, high, *further = parts
        ends = Ends(float(low), float(high), further == [LOG])
    except (TypeError, ValueError):
        raise SceneError(f"{name} {key}", given, ENDS) from None
    good = is_number(ends.low) and is_number(ends.high) and ends.low != ends.high
    if not good or further not in ([], [LOG]):
        raise SceneError(f"{name} {key}", given, ENDS)
    if ends.is_log and min(ends.low, ends.high) <= 0.0:
        raise SceneError(f"{name} {key}", given, "both ends of low:high:log must be above 0")
    return ends


def whole_numbers(scene: Scene, values: Mapping[str, Any]) -> dict[str, Any]:
    """The values, with 16 in place of 16.0 where the scene has a whole number."""
    held = flat_keys(scene.to_mapping())
    return {
        key: int(value)
        if isinstance(value, float) and value.is_integer() and is_whole(held.get(key))
        else value
        for key, value in values.items()
    }


def _read_text(key: str, text: str) -> list[Any]:
    parts = text.split(":")
    if len(parts) == 1:
        items = [item for item in _split(text) if item]
        if not items:
            raise SceneError(f"grid {key}", text, VALUES)
        return [parse_assignment(f"{key}={item}")[1] for item in items]
    is_log = parts[3:] == [LOG]
    try:
        low, high, count = float(parts[0]), float(parts[1]), int(parts[2])
    except (ValueError, IndexError):
        raise SceneError(f"grid {key}", text, VALUES) from None
    if wrong := VALUES if parts[3:] and not is_log else _wrong_range(low, high, count, is_log):
        raise SceneError(f"grid {key}", text, wrong)
    space = np.geomspace if is_log else np.linspace
    return [float(value) for value in space(low, high, count)]


def _wrong_range(low: float, high: float, count: int, is_log: bool) -> str:
    """What a range must be, if it is not; else empty."""
    if not (math.isfinite(low) and math.isfinite(high)):
        return "both ends must be finite"
    if count < 1:
        return "the count, which is the third number, must be at least 1"
    if is_log and min(low, high) <= 0.0:
        return "both ends of low:high:count:log must be above 0"
    return ""


def _split(text: str) -> list[str]:
    """The parts between commas that stand outside brackets."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter in "[{") - (letter in "]}")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as numbers and lists of Python."""
    return value.tolist() if hasattr(value, "tolist") else value
