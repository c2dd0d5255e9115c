"""The two standard pictures of chains: three projections, or perspective."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from nrchain.view.drawing import new_figure, settle
from nrchain.view.one_chain import (
    ABOVE,
    INSIDE,
    LEAST_DIAMETER,
    draw_flat,
    draw_in_space,
    frame_key,
)
from nrchain.view.panels import Box, Viewport, add_axes, label_axes
from nrchain.view.picture import Picture
from nrchain.view.shown import Shown
from nrchain.view.style import WIDTHS


def draw_planes(shown: Shown, spheres: str = "auto", frames: bool = False) -> Picture:
    """Draw panel xy above xz with x in common, and beside them yz, the view along the chain."""
    left, bottom, wide, gap = 0.5, 0.42, 3.75, 0.12
    margin = 3.0 + 2.0 * shown.length * frames
    window = Viewport.fit(shown.chains, wide, 0.8, 1.9, margin, stretch=spheres != "scale")
    tall = 2 * window.height + gap
    side = min(tall, 1.4)
    right, low = left + wide + 0.6, bottom + (tall - side) / 2
    bar = (right + side + 0.15, low, 0.1, side)
    figure = new_figure(WIDTHS["two"], bottom + tall + 0.56)

    upper = add_axes(figure, (left, bottom + window.height + gap, wide, window.height))
    lower = add_axes(figure, (left, bottom, wide, window.height), sharex=upper)
    scales, inches = (window.along, window.across), (wide, window.height)
    # too small to be seen: as dots
    kind = "dots" if spheres == "auto" and 2 * 72 * window.along < LEAST_DIAMETER else spheres
    for axes, plane in ((upper, (0, 1)), (lower, (0, 2))):
        label_axes(axes, window, plane, inches, scales)
        draw_flat(axes, shown, plane, kind, frames, window.across / window.along)
    upper.tick_params(labelbottom=False)
    upper.set_xlabel("")
    figure.align_ylabels([upper, lower])

    end_on = add_axes(figure, (right, low, side, side))
    scale = side / (1.3 * window.width if window.stretched else 1.2 * window.width + margin)
    label_axes(end_on, window, (1, 2), (side, side), (scale, scale))
    draw_flat(end_on, shown, (1, 2), "scale" if spheres == "scale" else "dots", frames)
    if frames:
        frame_key(end_on, ABOVE)
    return Picture(figure, (left, bottom + tall), bar, window.note)


def draw_space(shown: Shown, spheres: str = "auto", frames: bool = False) -> Picture:
    """Draw one panel in perspective, with x from left to right."""
    length = 4.0
    margin = 3.0 + 2.0 * shown.length * frames
    window = Viewport.fit(shown.chains, length, 1.3, 3.2, margin, stretch=spheres != "scale")
    figure = new_figure(6.6, 6.6)
    axes = add_axes(figure, (0.4, 0.4, 5.0, 5.0), projection="3d")
    inches, scales = (
        (length, window.height, window.height),
        (window.along, window.across, window.across),
    )
    label_axes(axes, window, (0, 1, 2), inches, scales)
    axes.set_box_aspect(inches)
    axes.view_init(elev=24, azim=-66)
    axes.xaxis.labelpad = 14
    ratio = window.across / window.along
    draw_in_space(axes, shown, spheres, frames, (1.0, ratio, ratio))
    if frames:
        frame_key(axes, INSIDE)

    left, bottom, right, top = _bounds(axes)
    bar = (right + 0.2, bottom + 0.4, 0.1, min(top - bottom - 0.8, 2.2))
    crop = (left - 0.1, bottom - 0.1, bar[0] + 0.6 - left, top + 0.6 - bottom)
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
