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
    def fit(
        cls,
        chains: np.ndarray,
        wide: float,
        low: float,
        high: float,
        margin: float,
        *,
        stretch: bool,
    ) -> Viewport:
        """The view of panels ``wide`` inches wide and ``low`` to ``high`` inches high.

        ``margin`` is the length that spheres of radius 1 and vectors need beside the centres.

        Without ``stretch``, all directions have one scale however slender the chain is.
        """
        least, most = chains.min(axis=(0, 1)), chains.max(axis=(0, 1))
        middle = (least + most) / 2
        length, width = (most - least)[0], max((most - least)[1:])
        if width < STRAIGHT * length:
            width = 0.0
        if stretch and 0 < width < SLENDER * length:
            height = (low + high) / 2
            return cls(middle, width, wide / (1.06 * length), height / (1.3 * width), height)
        room = (1.06 * length + margin, 1.1 * width + margin)
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


def equal_scales(axes: Any, chains: np.ndarray, directions: tuple[int, ...]) -> None:
    """Style axes, give their directions one scale that holds all chains, and name them."""
    from matplotlib.ticker import MaxNLocator

    least, most = chains.min(axis=(0, 1)) - 2.0, chains.max(axis=(0, 1)) + 2.0
    style_axes(axes)
    for name, direction in zip(AXES, directions, strict=False):
        getattr(axes, f"{name}axis").label.set_style("italic")
        getattr(axes, f"set_{name}label")(f"{AXES[direction]}/a")
    if len(directions) == 3:
        half = np.maximum(most - least, 0.15 * (most - least).max()) / 2
        for name, middle, width in zip(AXES, (least + most) / 2, half, strict=True):
            getattr(axes, f"set_{name}lim")(middle - width, middle + width)
            ticks = MaxNLocator(7 if width > 0.5 * half.max() else 3, steps=[1, 2, 2.5, 5, 10])
            getattr(axes, f"{name}axis").set_major_locator(ticks)
        axes.set_box_aspect(half)
        axes.xaxis.labelpad = 8.0
    else:
        axes.update_datalim(np.array([least, most])[:, directions])
        axes.margins(0.02)
        axes.set_aspect("equal", adjustable="datalim")


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
        axis.set_major_locator(MaxNLocator(7 if size > 3 else 4, steps=[1, 2, 2.5, 5, 10]))
