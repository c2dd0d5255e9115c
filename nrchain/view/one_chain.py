"""Chains on one pair of axes: a line and spheres for each time, and the vectors of their frames."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from nrchain.view.shown import Shown
from nrchain.view.style import INK, LINE, PAPER, TEXT

PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
"""The directions that each projection shows."""

DISCERNIBLE = 250
"""Largest number of spheres that are drawn one by one; a longer chain is a line."""
LEAST_DIAMETER = 2.2
"""Least diameter of a sphere, in points; a smaller one is drawn as a dot of this size."""

CORNERS = 24
"""Of a disc that stands for a sphere in perspective."""

CHAIN_WIDTH = 0.8
"""Of the line through the centres, in points."""

VECTORS: tuple[dict[str, Any], ...] = (
    {"linewidth": 2.2, "solid_capstyle": "butt"},
    {"linewidth": 0.9, "solid_capstyle": "butt"},
)
"""The looks of e₁, which lies on the line of the chain, and of e₂."""

HEADS: tuple[dict[str, Any], ...] = (
    {},
    {"marker": "o", "markersize": 2.2, "markeredgewidth": 0.6, "markerfacecolor": PAPER},
)
"""The looks of their heads."""

INSIDE: dict[str, Any] = {"loc": "upper right"}
ABOVE: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 0.97)}
"""Places of a key."""


def draw_flat(
    axes: Any,
    shown: Shown,
    plane: tuple[int, int],
    spheres: str = "auto",
    frames: bool = False,
    stretch: float = 1.0,
) -> None:
    """Draw projected chains; ``stretch`` is the scale of the vertical over the horizontal axis.

    Stretched chains have dots for spheres, and vectors of frames that are not stretched.
    """
    from matplotlib.collections import EllipseCollection

    many = shown.chains.shape[1] > DISCERNIBLE
    dots = spheres == "dots" or (not many and spheres == "auto")
    round_ones = spheres == "scale" or (spheres == "auto" and not many and stretch == 1.0)
    edge = 0.25 if spheres == "scale" else 0.0
    for number, (chain, colour) in enumerate(zip(shown.chains, shown.colours, strict=True)):
        flat = chain[:, plane]
        look = LINE | {"color": colour, "linewidth": CHAIN_WIDTH, "solid_joinstyle": "round"}
        if dots:
            look |= {"marker": "o", "markersize": LEAST_DIAMETER}
        axes.plot(*flat.T, **look)
        if round_ones:
            size = np.full(len(flat), 2.0)
            discs = EllipseCollection(
                size, size, 0 * size, units="xy", offsets=flat, offset_transform=axes.transData
            )
            discs.set(facecolor=colour, edgecolor=PAPER, linewidth=edge, zorder=2)
            axes.add_collection(discs, autolim=False)
        if frames:
            for vector in range(2):
                begin, arrow = shown.arrows(number, vector)
                flat_arrow = arrow[:, plane] / np.array([1.0, stretch])
                _draw_vectors(axes, begin[:, plane], flat_arrow, colour, vector)


def draw_in_space(
    axes: Any,
    shown: Shown,
    spheres: str = "auto",
    frames: bool = False,
    stretch: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> None:
    """Draw chains in perspective; ``stretch`` holds the scales of the axes over that of x."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    dots = spheres == "dots" or (spheres == "auto" and shown.chains.shape[1] <= DISCERNIBLE)
    for number, (chain, colour) in enumerate(zip(shown.chains, shown.colours, strict=True)):
        look = LINE | {"color": colour, "linewidth": CHAIN_WIDTH}
        if dots:
            look |= {"marker": "o", "markersize": LEAST_DIAMETER, "markeredgewidth": 1.0}
        axes.plot(*chain.T, **look)
        if spheres == "scale":
            discs = Poly3DCollection(_discs(axes, chain))
            discs.set(facecolor=colour, edgecolor=PAPER, linewidth=0.25)
            axes.add_collection3d(discs)
        if frames:
            for vector in range(2):
                begin, arrow = shown.arrows(number, vector)
                _draw_vectors(axes, begin, arrow / np.array(stretch), colour, vector)


def frame_key(axes: Any, place: Mapping[str, Any]) -> None:
    """Write the key of the vectors of frames at a place in or beside the axes."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], **LINE | look | head | {"color": INK, "markeredgecolor": INK})
        for look, head in zip(VECTORS, HEADS, strict=True)
    ]
    axes.legend(
        handles,
        ["e₁", "e₂"],
        **place,
        ncols=2,
        frameon=False,
        fontsize=TEXT,
        labelcolor=INK,
    )


def _draw_vectors(
    axes: Any, begin: np.ndarray, arrow: np.ndarray, colour: np.ndarray, vector: int
) -> None:
    """Draw vectors (m, 2) or (m, 3) as one line with gaps, with a mark at their heads."""
    gap = np.full_like(begin, np.nan)
    points = np.stack([begin, begin + arrow, gap], axis=1).reshape(-1, begin.shape[1])
    look = LINE | VECTORS[vector] | {"color": colour, "zorder": 3}
    axes.plot(*points.T, **look)
    if head := HEADS[vector]:
        ends = {"linestyle": "", "markeredgecolor": colour}
        axes.plot(*(begin + arrow).T, **look | head | ends)


def _discs(axes: Any, chain: np.ndarray) -> np.ndarray:
    """(N, CORNERS, 3): discs of radius 1 about points, facing the eye of axes in perspective."""
    height, side = np.radians([axes.elev, axes.azim])
    right = np.array([-np.sin(side), np.cos(side), 0.0])
    eye = np.array([np.cos(height) * np.cos(side), np.cos(height) * np.sin(side), np.sin(height)])
    angle = 2.0 * np.pi * np.arange(CORNERS)[:, None] / CORNERS
    return chain[:, None, :] + np.cos(angle) * right + np.sin(angle) * np.cross(eye, right)
