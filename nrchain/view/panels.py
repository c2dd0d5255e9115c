"""Panels that show a part of space: their place in a figure, their scales and their axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.view.style import style_axes

SLENDER = 0.06
"""Ratio of width to length below which the directions across a chain are stretched."""
STRAIGHT = 1e-7
"""Ratio of width to length below which a chain is straight and the rest is rounding."""

AXES = ("x", "y", "z")

Box = tuple[float, float, float, float]
"""Left, bottom, width and height of a part of a figure, in inches."""


@dataclass(frozen=True)
class Viewport:
    """The part of space that the panels show: lengths in a, scales in inches per a.

    Attributes
    ----------
    middle
        ``(3,)``: the centre of all chains.
    width
        Their extent across x.
    along, across
        The scale of x, and that of y and z.
    height
        The height of a panel, in inches.
    """

    middle: np.ndarray
    width: float
    along: float
    across: float
    height: float

    @classmethod
    def fit(cls, chains: np.ndarray, wide: float, low: float, high: float) -> Viewport:
        """The view of panels ``wide`` inches wide and ``low`` to ``high`` inches high."""
        least, most = chains.min(axis=(0, 1)), chains.max(axis=(0, 1))
        middle = (least + most) / 2
        length, width = (most - least)[0], max((most - least)[1:])
        if width < STRAIGHT * length:
            width = 0.0
        if 0 < width < SLENDER * length:
            height = (low + high) / 2
            return cls(middle, width, wide / (1.06 * length), height / (1.3 * width), height)
        # the spheres have radius 1; the rest is margin
        room = (1.06 * length + 3, 1.1 * width + 3)
        scale = min(wide / room[0], high / room[1])
        return cls(middle, width, scale, scale, max(low, scale * room[1]))

    @property
    def stretched(self) -> bool:
        """Whether y and z have another scale than x."""
        return self.across != self.along

    @property
    def note(self) -> str:
        """The factor by which y and z are stretched, in words; empty where they are not."""
        factor = float(f"{self.across / self.along:.2g}")
        return f"y, z stretched {factor:g} times" if self.stretched else ""

    def limits(self, axis: int, inches: float, scale: float) -> tuple[float, float]:
        """The ends of an axis of so many inches, drawn at ``scale``."""
        half = inches / scale / 2
        return self.middle[axis] - half, self.middle[axis] + half


def add_axes(figure: Any, box: Box, **options: Any) -> Any:
    """Add axes at a place given in inches."""
    width, height = figure.get_size_inches()
    left, bottom, wide, tall = box
    place = (left / width, bottom / height, wide / width, tall / height)
    axes = figure.add_axes(place, **options)
    style_axes(axes)
    return axes


def label_axes(
    axes: Any,
    view: Viewport,
    shown: tuple[int, ...],
    inches: tuple[float, ...],
    scales: tuple[float, ...],
) -> None:
    """Set labels, limits and a few round ticks for the directions of space that are shown."""
    from matplotlib.ticker import MaxNLocator

    for name, direction, size, scale in zip(AXES, shown, inches, scales, strict=False):
        axes.set(
            **{
                f"{name}label": f"{AXES[direction]}/a",
                f"{name}lim": view.limits(direction, size, scale),
            }
        )
        axis = getattr(axes, f"{name}axis")
        # italics in place of mathematics, whose parser takes longer than the rest of the picture
        axis.label.set_style("italic")
        axis.set_major_locator(MaxNLocator(7 if size > 4 else 4, steps=[1, 2, 2.5, 5, 10]))
