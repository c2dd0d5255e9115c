"""Panels (d) and (e): a shipped scene at a few times, seen from the side and from above.

The panels show the length of the chain and no more, so that y and z mostly have another scale than
x. Vectors of frames have one length on paper and their direction in space.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.figures.keys import Glyph, write_glyphs
from nrchain.figures.sheet import is_above, key_place
from nrchain.run.simulation import simulate
from nrchain.scene.loading import load_scene
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.one_chain import CHAIN_WIDTH
from nrchain.view.shown import Shown, choose
from nrchain.view.style import INK, LINE, MARKERS, TEXT, style_axes
from nrchain.view.units import has_unit

STRAIGHT = 1e-7
"""Width over length of a chain below which it is straight and the rest is rounding."""

ROOM = 1.3
"""Height of axes over that of the chain."""

FRAMES, FEWER = 7, 5
"""Most frames that are drawn along a chain, on wide axes and on narrow ones."""

LENGTHS, THICKNESSES = (5.0, 10.0), (2.4, 0.9)
"""Of e₁, which lies on the chain, and of e₂, in points."""

MARK, SMALLER = 2.6, 1.8
"""Size of the marks of spheres, in points, on wide axes and on narrow ones."""

NICE = np.array([1.0, 1.5, 2.0, 3.0, 5.0, 7.0])


@dataclass(frozen=True)
class Evolution:
    """Axes of a chain at some times, and what of it they must show.

    Attributes
    ----------
    panels
        The axes.
    middle
        ``(3,)``: of the chain at all times, in a.
    length, width
        Of the chain at all times, along x and across it, in a.
    stems
        Points on paper that vectors of frames need on either side.
    """

    panels: Sequence[Any]
    middle: np.ndarray
    length: float
    width: float
    stems: float

    def stretch(self) -> None:
        """Choose the scale of y and z for axes whose place in the figure is known, and write it."""
        upper = self.panels[0]
        wide, tall = upper.get_window_extent().size * 72.0 / upper.figure.dpi
        left, right = upper.get_xlim()
        scale = wide / (right - left)
        factor = 1.0
        if self.width > 0.0:
            fits = (tall - 2.0 * self.stems) / (ROOM * self.width) / scale
            nice = np.outer(10.0 ** np.arange(8), NICE).ravel()
            factor = float(nice[nice <= max(fits, 1.0)].max())
            scale *= min(fits, 1.0)
            for axes in self.panels:
                axes.set_xlim(*(self.middle[0] + wide / scale * np.array([-0.5, 0.5])))
        half = tall / (2.0 * scale * factor)
        for axes, middle in zip(self.panels, self.middle[1:], strict=False):
            axes.set_ylim(middle - half, middle + half)
        if factor > 1.0:
            names = "y" if len(self.panels) == 1 else "y, z"
            last = self.panels[-1]
            # beside the letter of the panel there may be no room
            axes = upper if is_above(upper, last) else last
            words = f"{names} stretched {factor:g} times"
            axes.set_title(words, loc="right", fontsize=TEXT - 1, color=INK, pad=4.0, y=1.0)


def run(name: str, changes: Mapping[str, Any]) -> Trajectory:
    """The trajectory of a shipped scene, with changes."""
    return simulate(load_scene(name, **changes))


def draw_evolution(
    panels: Sequence[Any], trajectory: Trajectory, *, times: int = 4, frames: bool = False
) -> Evolution:
    """Draw a chain at some times on axes of x and y, and of x and z if there are two.

    ``frames`` draws e₁ and e₂ of some spheres. :meth:`Evolution.stretch` chooses the scale of y
    and z once the axes have their places.
    """
    shown = choose(trajectory, times, "linear")
    least, most = shown.chains.min(axis=(0, 1)), shown.chains.max(axis=(0, 1))
    length, width = float((most - least)[0]), float((most - least)[1:].max())
    width = width if width > STRAIGHT * length else 0.0
    middle = (least + most) / 2
    narrow = not is_above(panels[0], panels[-1])
    for axes, across in zip(panels, (1, 2), strict=False):
        style_axes(axes)
        _draw_chains(axes, shown, (0, across), frames, narrow)
        axes.xaxis.get_major_locator().set_params(nbins=5 if narrow else 9)
        axes.set_xlim(least[0] - 0.04 * length, most[0] + 0.04 * length)
        half = ROOM * width / 2 or 1.0
        axes.set_ylim(middle[across] - half, middle[across] + half)
        axes.set(xlabel="x/a", ylabel=f"{'xyz'[across]}/a")
        axes.yaxis.get_major_locator().set_params(nbins=4)
        for axis in (axes.xaxis, axes.yaxis):
            axis.label.set_style("italic")
    panels[0].figure.align_ylabels(panels)
    if len(panels) == 2 and not narrow:
        panels[0].tick_params(labelbottom=False)
        panels[0].set_xlabel("")
    _write_key(panels[-1], shown, trajectory, frames)
    return Evolution(panels, middle, length, width, LENGTHS[1] * frames)


def _draw_chains(
    axes: Any, shown: Shown, plane: tuple[int, int], frames: bool, narrow: bool
) -> None:
    """Draw projected chains, a colour and a marker a time."""
    for number, (chain, colour) in enumerate(zip(shown.chains, shown.colours, strict=True)):
        look = _look(number, colour) | ({"markersize": SMALLER} if narrow else {})
        axes.plot(*chain[:, plane].T, **look)
        if frames:
            picked = np.arange(0, len(chain), -(-len(chain) // (FEWER if narrow else FRAMES)))
            for vector in range(2):
                _draw_vectors(axes, shown, number, plane, vector, picked)


def _look(number: int, colour: Any) -> dict[str, Any]:
    """Line and marks of the chain at a time."""
    marker = MARKERS[number % len(MARKERS)]
    look = {"color": colour, "linewidth": CHAIN_WIDTH, "solid_joinstyle": "round"}
    return LINE | look | {"marker": marker, "markersize": MARK}


def _draw_vectors(
    axes: Any,
    shown: Shown,
    number: int,
    plane: tuple[int, int],
    vector: int,
    picked: np.ndarray,
) -> None:
    """Draw e₁ or e₂ of the picked spheres, in points on paper from their centres."""
    from matplotlib.collections import LineCollection

    directions = shown.frames[number, picked, vector][:, plane]
    stems = LENGTHS[vector] / 72.0 * directions
    lines = LineCollection(
        list(np.stack([0.0 * stems, stems], axis=1)),
        offsets=shown.chains[number, picked][:, plane],
        offset_transform=axes.transData,
        colors=[shown.colours[number]],
        linewidths=THICKNESSES[vector],
        zorder=3,
        capstyle="butt",
    )
    lines.set_transform(axes.figure.dpi_scale_trans)
    axes.add_collection(lines, autolim=False)


def _write_key(axes: Any, shown: Shown, trajectory: Trajectory, frames: bool) -> None:
    """Write the key below the axes: line and mark of each time, and the vectors of frames."""
    from matplotlib.lines import Line2D

    unit = r" $[\gamma_T d^2/\mu]$" if has_unit(trajectory.scene, "time") else ""
    entries: list[tuple[str, Any]] = [(f"$t${unit} =", Line2D([], [], linestyle="", marker=""))]
    for number, (time, colour) in enumerate(zip(shown.time, shown.colours, strict=True)):
        entries.append((f"{time:.4g}", Line2D([], [], **_look(number, colour))))
    if frames:
        entries += [("$e_1$", _stem(0)), ("$e_2$", _stem(1))]
    look = {"fontsize": TEXT - 1, "handlelength": 1.6, "handletextpad": 0.3, "columnspacing": 0.6}
    owner, place = key_place(axes)
    write_glyphs(owner, entries, len(entries), **look, **place)


def _stem(vector: int) -> Glyph:
    """A piece of the chain with e₁ along it or e₂ across it, in points."""

    def draw(axes: Any) -> None:
        low = -3.0 * vector
        axes.plot([-5.5, 5.5], [low, low], **LINE | {"color": INK, "linewidth": CHAIN_WIDTH})
        look = LINE | {"color": INK, "linewidth": THICKNESSES[vector]}
        end = (LENGTHS[0], 0.0) if vector == 0 else (0.0, LENGTHS[1])
        axes.plot([0.0, end[0]], [low, low + end[1]], **look | {"solid_capstyle": "butt"})
        axes.plot([0.0], [low], **LINE | {"color": INK, "marker": "o", "markersize": MARK})

    return Glyph(draw, 1.0)
