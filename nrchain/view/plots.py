"""Pictures of a chain at several times: its three projections, or in space.

Lengths are in units of the sphere radius a. Directions across the chain are drawn on the scale of
the direction along it, and the spheres with it, unless the chain is so slender that its shape would
be lost; then they are stretched, and the picture says by how much.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.errors import SceneError, TrajectoryError
from nrchain.scene.scene import slip_text
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.drawing import (
    INK,
    LINE,
    PALE,
    TEXT,
    TITLE,
    letters,
    new_figure,
    picture_path,
    require_matplotlib,
    save,
    settle,
    style,
    write_title,
)

VIEWS = ("planes", "3d")

SLENDER = 0.06
"""Width over length below which the directions across a chain are stretched."""
STRAIGHT = 1e-7
"""Width over length below which a chain is straight, and what is left is rounding."""
DISCERNIBLE = 250
"""Spheres beyond which a chain is drawn as a line."""
LEAST_DIAMETER = 2.2
"""Points below which a sphere is drawn as a dot of this size."""

AXES = ("x", "y", "z")

Box = tuple[float, float, float, float]
"""Left, bottom, width and height of a part of a figure, in inches."""


def draw_chain(
    trajectory: Trajectory, path: str | Path, *, view: str = "planes", times: int = 6
) -> Path:
    """Draw the chain at ``times`` snapshots, first to last, and return the path of the picture.

    ``view`` is ``"planes"`` for the projections on xy, xz and yz, or ``"3d"``; the ending of
    ``path`` chooses PNG, PDF or SVG. Raises :class:`~nrchain.errors.SceneError` for another view,
    ending or number of times, and :class:`~nrchain.errors.TrajectoryError` if there is nothing to
    draw. A file that exists is replaced.
    """
    if view not in VIEWS:
        raise SceneError("view", view, f"must be one of {', '.join(VIEWS)}")
    if times < 1:
        raise SceneError("times", times, "must be at least 1")
    path = picture_path(path)
    if not len(trajectory.time):
        raise TrajectoryError("the trajectory has no finished snapshot to draw")

    require_matplotlib()
    chosen = np.unique(np.linspace(0, len(trajectory.time) - 1, times).round().astype(int))
    chains = trajectory.positions[chosen] / trajectory.scene.chain.radius
    colours = _colours(len(chosen))
    picture = (_draw_planes if view == "planes" else _draw_space)(chains, colours)
    picture.write_title(trajectory)
    picture.draw_bar(colours, trajectory.time[chosen])
    picture.save(path)
    return path


@dataclass(frozen=True)
class _Frame:
    """The part of space that the panels show: lengths in a, scales in inches per a.

    ``middle (3,)`` is the centre of all chains, ``width`` their extent across x, ``along`` and
    ``across`` the scales of x and of y and z, ``height`` that of a panel in inches.
    """

    middle: np.ndarray
    width: float
    along: float
    across: float
    height: float

    @classmethod
    def fit(cls, chains: np.ndarray, wide: float, low: float, high: float) -> _Frame:
        """The frame of panels ``wide`` inches wide and ``low`` to ``high`` inches high."""
        least, most = chains.min(axis=(0, 1)), chains.max(axis=(0, 1))
        middle = (least + most) / 2
        length, width = (most - least)[0], max((most - least)[1:])
        if width < STRAIGHT * length:
            width = 0.0
        if 0 < width < SLENDER * length:
            height = (low + high) / 2
            return cls(middle, width, wide / (1.06 * length), height / (1.3 * width), height)
        # The spheres have radius 1; the rest is air.
        room = (1.06 * length + 3, 1.1 * width + 3)
        scale = min(wide / room[0], high / room[1])
        return cls(middle, width, scale, scale, max(low, scale * room[1]))

    @property
    def stretched(self) -> bool:
        return self.across != self.along

    @property
    def note(self) -> str:
        """What a reader must know of the scales, if anything."""
        factor = float(f"{self.across / self.along:.2g}")
        return f"$y$, $z$ stretched {factor:g} times" if self.stretched else ""

    def limits(self, axis: int, inches: float, scale: float) -> tuple[float, float]:
        half = inches / scale / 2
        return self.middle[axis] - half, self.middle[axis] + half


@dataclass(frozen=True)
class _Picture:
    """A figure with the chains in it, and where the rest goes, in inches.

    ``corner`` is the left and the bottom of the title, ``bar`` the place of the colour bar,
    ``note`` a remark on the scales, ``crop`` what to keep of the figure if not all that is drawn.
    """

    figure: Any
    corner: tuple[float, float]
    bar: Box
    note: str
    crop: Box | None = None

    def write_title(self, trajectory: Trajectory) -> None:
        """The scene's title, and below it what was run and how it ended."""
        scene = trajectory.scene
        words = [slip_text(scene), f"{scene.chain.ends} ends", f"$N$ = {scene.chain.particles}"]
        if len(trajectory.time) == 1 or trajectory.status == "stopped":
            stopped = "stopped at " * (trajectory.status == "stopped")
            words.append(f"{stopped}$t$ = {trajectory.time[-1]:.4g}")
        if self.note:
            words.append(self.note)
        title = letters(scene.title)
        (left, bottom), (width, height) = self.corner, self.figure.get_size_inches()
        for up, text, look in (
            (0.32, title, {"fontsize": TITLE, "fontweight": "bold", "color": INK}),
            (0.12, "   ·   ".join(words), {"fontsize": TEXT, "color": PALE}),
        ):
            self.figure.text(left / width, (bottom + up) / height, text, **look)

    def draw_bar(self, colours: np.ndarray, times: np.ndarray) -> None:
        """One field of colour a time, if there are several."""
        if len(times) == 1:
            return
        axes = _add_axes(self.figure, self.bar)
        axes.grid(False)
        axes.imshow(
            colours[:, None, :],
            origin="lower",
            aspect="auto",
            interpolation="nearest",
            extent=(0, 1, -0.5, len(times) - 0.5),
        )
        labelled = np.unique(np.linspace(0, len(times) - 1, min(len(times), 9)).round().astype(int))
        axes.set_xticks([])
        axes.set_yticks(labelled, [f"{t:.4g}" for t in times[labelled]])
        axes.yaxis.tick_right()
        axes.tick_params(length=0, pad=3)
        write_title(axes, "$t$", pad=5)

    def save(self, path: Path) -> None:
        from matplotlib.transforms import Bbox

        crop: Any = Bbox.from_bounds(*self.crop) if self.crop else None
        settle(self.figure)
        if any(text.get_window_extent().x1 > self.figure.bbox.x1 for text in self.figure.texts):
            crop = "tight"  # a title that runs out of the figure widens it, at twice the time
        save(self.figure, path, crop)


def _draw_planes(chains: np.ndarray, colours: np.ndarray) -> _Picture:
    """Panels xy over xz with x in common, and beside them yz, the view along the chain."""
    left, bottom, wide, gap = 0.62, 0.5, 4.7, 0.14
    frame = _Frame.fit(chains, wide, 0.95, 2.4)
    tall = 2 * frame.height + gap
    side = min(tall, 2.6)
    right, low = left + wide + 0.75, bottom + (tall - side) / 2
    bar = (right + side + 0.2, low, 0.12, side)
    figure = new_figure(bar[0] + 0.75, bottom + tall + 0.64)

    upper = _add_axes(figure, (left, bottom + frame.height + gap, wide, frame.height))
    lower = _add_axes(figure, (left, bottom, wide, frame.height), sharex=upper)
    scales, inches = (frame.along, frame.across), (wide, frame.height)
    diameter = 0.0 if frame.stretched else 2 * 72 * frame.along
    for axes, plane in ((upper, (0, 1)), (lower, (0, 2))):
        _prepare(axes, frame, plane, inches, scales)
        for chain, colour in zip(chains, colours, strict=True):
            _draw_flat(axes, chain[:, plane], colour, diameter)
    upper.tick_params(labelbottom=False)
    upper.set_xlabel("")
    figure.align_ylabels([upper, lower])

    end_on = _add_axes(figure, (right, low, side, side))
    scale = side / (1.3 * frame.width if frame.stretched else 1.2 * frame.width + 3)
    _prepare(end_on, frame, (1, 2), (side, side), (scale, scale))
    for chain, colour in zip(chains, colours, strict=True):
        _draw_flat(end_on, chain[:, 1:], colour, 0.0)
    return _Picture(figure, (left, bottom + tall), bar, frame.note)


def _draw_space(chains: np.ndarray, colours: np.ndarray) -> _Picture:
    """One panel in perspective, with x from left to right."""
    length = 5.0
    frame = _Frame.fit(chains, length, 1.6, 4.0)
    figure = new_figure(8.0, 8.0)
    axes = _add_axes(figure, (0.5, 0.5, 6.0, 6.0), projection="3d")
    inches, scales = (length, frame.height, frame.height), (frame.along, frame.across, frame.across)
    _prepare(axes, frame, (0, 1, 2), inches, scales)
    axes.set_box_aspect(inches)
    axes.view_init(elev=24, azim=-66)
    axes.xaxis.labelpad = 14
    marker = "o" if chains.shape[1] <= DISCERNIBLE else ""
    for chain, colour in zip(chains, colours, strict=True):
        look = LINE | {"marker": marker, "markersize": LEAST_DIAMETER, "markeredgewidth": 1.0}
        axes.plot(*chain.T, color=colour, linewidth=0.9, **look)

    left, bottom, right, top = _bounds(axes)
    bar = (right + 0.25, bottom + 0.4, 0.12, min(top - bottom - 0.8, 2.6))
    crop = (left - 0.1, bottom - 0.1, bar[0] + 0.7 - left, top + 0.7 - bottom)
    return _Picture(figure, (left + 0.1, top), bar, frame.note, crop)


def _bounds(axes: Any) -> Box:
    """Left, bottom, right and top of what a panel in perspective fills, in inches."""
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
    return (*inches.min(axis=0), *inches.max(axis=0))


def _add_axes(figure: Any, box: Box, **options: Any) -> Any:
    """Axes at a place given in inches."""
    width, height = figure.get_size_inches()
    left, bottom, wide, tall = box
    place = (left / width, bottom / height, wide / width, tall / height)
    axes = figure.add_axes(place, **options)
    style(axes)
    return axes


def _prepare(
    axes: Any,
    frame: _Frame,
    shown: tuple[int, ...],
    inches: tuple[float, ...],
    scales: tuple[float, ...],
) -> None:
    """Set labels, limits and a few plain ticks for the directions of space that are shown."""
    from matplotlib.ticker import MaxNLocator

    for name, direction, size, scale in zip(AXES, shown, inches, scales, strict=False):
        axes.set(
            **{
                f"{name}label": f"${AXES[direction]}/a$",
                f"{name}lim": frame.limits(direction, size, scale),
            }
        )
        axis = getattr(axes, f"{name}axis")
        axis.set_major_locator(MaxNLocator(7 if size > 4 else 4, steps=[1, 2, 2.5, 5, 10]))


def _draw_flat(axes: Any, chain: np.ndarray, colour: np.ndarray, diameter: float) -> None:
    """A projected chain ``(N, 2)``; its spheres to scale if ``diameter``, in points, allows it."""
    from matplotlib.collections import EllipseCollection

    axes.plot(*chain.T, color=colour, linewidth=0.9, solid_joinstyle="round", **LINE)
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


def _colours(count: int) -> np.ndarray:
    """From light to dark ``(count, 4)``; the last state stands out."""
    from matplotlib import colormaps

    return colormaps["viridis_r"](np.linspace(0.08, 0.95, count) if count > 1 else [0.75])
