"""Two views of chains ``(T, N, 3)``, in units of the radius: three projections, or perspective."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from nrchain.view.drawing import new_figure, settle
from nrchain.view.panels import Box, Viewport, add_axes, label_axes
from nrchain.view.picture import Picture
from nrchain.view.style import LINE

DISCERNIBLE = 250
"""Largest number of spheres that are drawn one by one; a longer chain is a line."""
LEAST_DIAMETER = 2.2
"""Least diameter of a sphere, in points; a smaller one is drawn as a dot of this size."""


def draw_planes(chains: np.ndarray, colours: np.ndarray) -> Picture:
    """Draw panel xy above xz with x in common, and beside them yz, the view along the chain."""
    left, bottom, wide, gap = 0.62, 0.5, 4.7, 0.14
    window = Viewport.fit(chains, wide, 0.95, 2.4)
    tall = 2 * window.height + gap
    side = min(tall, 2.6)
    right, low = left + wide + 0.75, bottom + (tall - side) / 2
    bar = (right + side + 0.2, low, 0.12, side)
    figure = new_figure(bar[0] + 0.75, bottom + tall + 0.64)

    upper = add_axes(figure, (left, bottom + window.height + gap, wide, window.height))
    lower = add_axes(figure, (left, bottom, wide, window.height), sharex=upper)
    scales, inches = (window.along, window.across), (wide, window.height)
    diameter = 0.0 if window.stretched else 2 * 72 * window.along
    for axes, plane in ((upper, (0, 1)), (lower, (0, 2))):
        label_axes(axes, window, plane, inches, scales)
        for chain, colour in zip(chains, colours, strict=True):
            _draw_flat(axes, chain[:, plane], colour, diameter)
    upper.tick_params(labelbottom=False)
    upper.set_xlabel("")
    figure.align_ylabels([upper, lower])

    end_on = add_axes(figure, (right, low, side, side))
    scale = side / (1.3 * window.width if window.stretched else 1.2 * window.width + 3)
    label_axes(end_on, window, (1, 2), (side, side), (scale, scale))
    for chain, colour in zip(chains, colours, strict=True):
        _draw_flat(end_on, chain[:, 1:], colour, 0.0)
    return Picture(figure, (left, bottom + tall), bar, window.note)


def draw_space(chains: np.ndarray, colours: np.ndarray) -> Picture:
    """Draw one panel in perspective, with x from left to right."""
    length = 5.0
    window = Viewport.fit(chains, length, 1.6, 4.0)
    figure = new_figure(8.0, 8.0)
    axes = add_axes(figure, (0.5, 0.5, 6.0, 6.0), projection="3d")
    inches, scales = (
        (length, window.height, window.height),
        (window.along, window.across, window.across),
    )
    label_axes(axes, window, (0, 1, 2), inches, scales)
    axes.set_box_aspect(inches)
    axes.view_init(elev=24, azim=-66)
    axes.xaxis.labelpad = 14
    marker = "o" if chains.shape[1] <= DISCERNIBLE else ""
    for chain, colour in zip(chains, colours, strict=True):
        look = LINE | {"marker": marker, "markersize": LEAST_DIAMETER, "markeredgewidth": 1.0}
        axes.plot(*chain.T, **look | {"color": colour, "linewidth": 0.9})

    left, bottom, right, top = _bounds(axes)
    bar = (right + 0.25, bottom + 0.4, 0.12, min(top - bottom - 0.8, 2.6))
    crop = (left - 0.1, bottom - 0.1, bar[0] + 0.7 - left, top + 0.7 - bottom)
    return Picture(figure, (left + 0.1, top), bar, window.note, crop)


def _bounds(axes: Any) -> Box:
    """Left, bottom, right and top of the drawing of a panel in perspective, in inches."""
    settle(axes.figure)
    axes.figure.canvas.draw()
    renderer = axes.figure.canvas.get_renderer()
    limits = (axes.get_xlim(), axes.get_ylim(), axes.get_zlim(), (1.0,))
    corners = np.array(list(itertools.product(*limits))) @ axes.get_proj().T
    points = [axes.transData.transform(corners[:, :2] / corners[:, 3:])]
    points += [
        axis.get_tightbbox(renderer).get_points() for axis in (axes.xaxis, axes.yaxis, axes.zaxis)
    ]
    inches = np.concatenate(points) / axes.figure.dpi
    # whole tenths: letters of another font or renderer leave the size of the picture
    return (*np.floor(10 * inches.min(axis=0)) / 10, *np.ceil(10 * inches.max(axis=0)) / 10)


def _draw_flat(axes: Any, chain: np.ndarray, colour: np.ndarray, diameter: float) -> None:
    """Draw a projected chain ``(N, 2)``, with spheres to scale if ``diameter`` (points) allows."""
    from matplotlib.collections import EllipseCollection

    look = LINE | {"color": colour, "linewidth": 0.9}
    axes.plot(*chain.T, solid_joinstyle="round", **look)
    if len(chain) > DISCERNIBLE:
        return
    if diameter < LEAST_DIAMETER:
        dots = LINE | {"linestyle": "", "marker": "o", "markersize": LEAST_DIAMETER}
        axes.plot(*chain.T, color=colour, **dots)
        return
    size = np.full(len(chain), 2.0)
    spheres = EllipseCollection(
        size, size, 0 * size, units="xy", offsets=chain, offset_transform=axes.transData
    )
    spheres.set(facecolor=colour, edgecolor="white", linewidth=0.04 * diameter, zorder=2)
    axes.add_collection(spheres, autolim=False)
