"""Panels of a film: drawn once, with a chain in them that moves from image to image."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.view.drawing import new_figure, settle
from nrchain.view.one_chain import DISCERNIBLE, LEAST_DIAMETER
from nrchain.view.panels import Viewport, add_axes, label_axes
from nrchain.view.style import COLOURS, INK, LINE, PALE, TEXT, TITLE

GHOST = "0.75"
"""Colour of the chain at the first snapshot."""
CHAIN, SIDE = COLOURS[3], COLOURS[1]
"""Colours of the chain, and of e₂ of its spheres."""


@dataclass(frozen=True)
class MovingChain:
    """A chain in one panel.

    Attributes
    ----------
    axes
        The panel.
    directions
        The directions of space that it shows.
    line, spheres, sides
        The line through the centres; the spheres and the lines along e₂, if they are shown.
    """

    axes: Any
    directions: tuple[int, ...]
    line: Any
    spheres: Any = None
    sides: Any = None

    def move(self, chain: np.ndarray, ends: np.ndarray) -> None:
        """Show a chain (N, 3) whose lines along e₂ end at (N, 3)."""
        points = chain[:, self.directions]
        if len(self.directions) == 3:
            self.line.set_data_3d(*points.T)
        else:
            self.line.set_data(*points.T)
        if self.spheres is not None:
            self.spheres.set_offsets(points)
        if self.sides is not None:
            self.sides.set_segments(np.stack([points, ends[:, self.directions]], axis=1))

    def draw(self) -> None:
        """Draw what moves."""
        for part in (self.line, self.sides, self.spheres):
            if part is not None:
                self.axes.draw_artist(part)


class FilmPanels:
    """A figure whose panels stay while the chain moves."""

    def __init__(
        self, figure: Any, chains: np.ndarray, parts: list[MovingChain], note: str, side: float
    ) -> None:
        self.unit = ""
        self.figure, self.chains, self.parts, self.note = figure, chains, parts, note
        self._side = side
        width, height = figure.get_size_inches()
        self._clock = figure.text(
            1 - 0.12 / width,
            1 - 0.2 / height,
            "",
            ha="right",
            va="center",
            fontsize=TITLE,
            color=INK,
        )
        self._clock.set_animated(True)

    def write_title(self, title: str, words: str) -> None:
        """Write two lines above the panels."""
        width, height = self.figure.get_size_inches()
        bold = {"fontsize": TITLE, "fontweight": "bold", "color": INK}
        for down, text, look in (
            (0.2, title, bold),
            (0.4, words, {"fontsize": TEXT, "color": PALE}),
        ):
            self.figure.text(0.12 / width, 1 - down / height, text, va="center", **look)

    def write_key(self) -> None:
        """Write what the pale chain is, and the lines along e₂ if they are drawn."""
        from matplotlib.lines import Line2D

        looks = {"start": GHOST}
        if self._side and any(part.sides is not None for part in self.parts):
            looks["e₂"] = SIDE
        width, height = self.figure.get_size_inches()
        self.figure.legend(
            [Line2D([], [], **LINE | {"color": colour}) for colour in looks.values()],
            list(looks),
            loc="center right",
            bbox_to_anchor=(1 - 0.12 / width, 1 - 0.44 / height),
            ncols=len(looks),
            frameon=False,
            fontsize=TEXT,
            labelcolor=INK,
            handlelength=1.2,
            borderpad=0.0,
            borderaxespad=0.0,
        )

    def images(self, times: np.ndarray, frames: np.ndarray, width: int) -> Iterator[np.ndarray]:
        """One image (height, width, 3) of bytes for each time, with ``frames`` (F, N, 3, 3)."""
        settle(self.figure)
        self.figure.set_dpi(width / self.figure.get_size_inches()[0])
        canvas = self.figure.canvas
        canvas.draw()
        still = canvas.copy_from_bbox(self.figure.bbox)
        for time, chain, axes in zip(times, self.chains, frames, strict=True):
            canvas.restore_region(still)
            for part in self.parts:
                part.move(chain, chain + self._side * axes[:, 1])
                part.draw()
            self._clock.set_text(f"t = {time:.4g} {self.unit}".rstrip())
            self.figure.draw_artist(self._clock)
            yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def planes_panels(chains: np.ndarray, side: float) -> FilmPanels:
    """Panel xy above xz with x in common, and beside them yz, for chains (F, N, 3) in radii.

    ``side`` is the length of the lines along e₂, in radii.
    """
    left, bottom, wide, gap, above = 0.62, 0.5, 4.7, 0.14, 0.62
    window = Viewport.fit(chains, wide, 0.95, 2.4, 3.0 + 2.0 * side, stretch=True)
    tall = 2 * window.height + gap
    square = min(tall, 2.6)
    right, low = left + wide + 0.75, bottom + (tall - square) / 2
    figure = new_figure(right + square + 0.2, bottom + tall + above)
    upper = add_axes(figure, (left, bottom + window.height + gap, wide, window.height))
    lower = add_axes(figure, (left, bottom, wide, window.height), sharex=upper)
    end_on = add_axes(figure, (right, low, square, square))
    scales, inches = (window.along, window.across), (wide, window.height)
    scale = square / (1.3 * window.width if window.stretched else 1.2 * window.width + 3 + 2 * side)
    label_axes(end_on, window, (1, 2), (square, square), (scale, scale))
    to_scale = 0.0 if window.stretched else 2 * 72 * window.along
    parts = []
    for axes, plane, diameter in (
        (upper, (0, 1), to_scale),
        (lower, (0, 2), to_scale),
        (end_on, (1, 2), 0.0),
    ):
        if axes is not end_on:
            label_axes(axes, window, plane, inches, scales)
        parts.append(_flat(axes, plane, chains[0], diameter))
    upper.tick_params(labelbottom=False)
    upper.set_xlabel("")
    figure.align_ylabels([upper, lower])
    return FilmPanels(figure, chains, parts, window.note, side)


def space_panels(chains: np.ndarray, side: float) -> FilmPanels:
    """One panel in perspective, with x from left to right, for chains (F, N, 3) in radii."""
    length = 5.0
    window = Viewport.fit(chains, length, 1.6, 4.0, 3.0, stretch=True)
    figure = new_figure(6.6, window.height + 2.4)
    axes = add_axes(figure, (0.2, 0.0, 6.2, window.height + 2.1), projection="3d")
    inches = (length, window.height, window.height)
    label_axes(axes, window, (0, 1, 2), inches, (window.along, window.across, window.across))
    axes.set_box_aspect(inches, zoom=1.1)
    axes.view_init(elev=24, azim=-66)
    axes.xaxis.labelpad = 14
    marker = "o" if chains.shape[1] <= DISCERNIBLE else ""
    look = LINE | {"marker": marker, "markersize": LEAST_DIAMETER, "markeredgewidth": 1.0}
    axes.plot(*chains[0].T, **look | {"color": GHOST, "linewidth": 0.9})
    (line,) = axes.plot(*chains[0].T, **look | {"color": CHAIN, "linewidth": 0.9, "animated": True})
    return FilmPanels(figure, chains, [MovingChain(axes, (0, 1, 2), line)], window.note, side)


def _flat(axes: Any, plane: tuple[int, int], chain: np.ndarray, diameter: float) -> MovingChain:
    """The moving chain of a projection, with spheres to scale if ``diameter`` (points) allows."""
    from matplotlib.collections import EllipseCollection, LineCollection

    look = LINE | {"linewidth": 0.9, "solid_joinstyle": "round"}
    axes.plot(*chain[:, plane].T, **look | {"color": GHOST})
    small = diameter < LEAST_DIAMETER
    marked = len(chain) <= DISCERNIBLE
    dots = {"marker": "o", "markersize": LEAST_DIAMETER} if small and marked else {}
    (line,) = axes.plot(*chain[:, plane].T, **look | {"color": CHAIN, "animated": True} | dots)
    if small or not marked:
        return MovingChain(axes, plane, line)
    size = np.full(len(chain), 2.0)
    spheres = EllipseCollection(
        size, size, 0 * size, units="xy", offsets=chain[:, plane], offset_transform=axes.transData
    )
    spheres.set(
        facecolor=CHAIN, edgecolor="white", linewidth=0.04 * diameter, zorder=2, animated=True
    )
    axes.add_collection(spheres, autolim=False)
    sides = LineCollection([], colors=SIDE, linewidths=1.0, animated=True)
    axes.add_collection(sides, autolim=False)
    return MovingChain(axes, plane, line, spheres, sides)
