"""Panels (d) and (e): a shipped scene at a few times, seen from the side and from above."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from nrchain.figures.sheet import below
from nrchain.run.simulation import simulate
from nrchain.scene.loading import load_scene
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.one_chain import CHAIN_WIDTH, VECTORS, draw_flat
from nrchain.view.shown import Shown, choose
from nrchain.view.style import INK, LINE, TEXT, style_axes
from nrchain.view.units import has_unit

SHAPE, SEEN = 0.18, 1e-3
"""Height over width of axes, and width over length of a chain that is seen to be bent."""


def run(name: str, changes: Mapping[str, Any]) -> Trajectory:
    """The trajectory of a shipped scene, with changes."""
    return simulate(load_scene(name, **changes))


def draw_evolution(
    panels: Sequence[Any], trajectory: Trajectory, *, times: int = 4, frames: bool = False
) -> None:
    """Draw a chain at some times on axes of x and y, and of x and z, with one scale for all.

    ``frames`` draws e₁ and e₂ of some spheres.
    """
    shown = choose(trajectory, times, "linear")
    least, most = shown.chains.min(axis=(0, 1)), shown.chains.max(axis=(0, 1))
    middle = (least + most) / 2
    margin = 3.0 + 2.0 * shown.length * frames
    width, length = (most - least)[1:].max(), (most - least)[0]
    across, along = width / 2 + margin, length / 2 + margin
    fits = int(SHAPE * along / across) if width > SEEN * length else 1
    stretch = max(1, fits)
    for axes, plane, name in zip(panels, ((0, 1), (0, 2)), "yz", strict=True):
        style_axes(axes)
        size = np.array([along, across])
        centre = middle[list(plane)]
        axes.update_datalim([centre - size, centre + size])
        axes.margins(0.0)
        axes.set_aspect(stretch, adjustable="datalim")
        draw_flat(axes, shown, plane, "auto", frames, float(stretch))
        axes.set(xlabel="x/a", ylabel=f"{name}/a")
        axes.yaxis.get_major_locator().set_params(nbins=3)
        for axis in (axes.xaxis, axes.yaxis):
            axis.label.set_style("italic")
    upper, lower = panels
    upper.figure.align_ylabels(panels)
    upper.tick_params(labelbottom=False)
    upper.set_xlabel("")
    if stretch > 1:
        words = f"y, z stretched {stretch} times"
        place = {"transform": upper.transAxes, "ha": "right", "va": "top"}
        upper.text(0.99, 0.95, words, color=INK, size=TEXT - 1, **place)
    _write_key(lower, shown, trajectory, frames)


def _write_key(axes: Any, shown: Shown, trajectory: Trajectory, frames: bool) -> None:
    """Write the key below the axes: the colour of each time, and the vectors of frames."""
    from matplotlib.lines import Line2D

    entries = {
        f"{time:.4g}": Line2D([], [], **LINE | {"color": colour, "linewidth": 2 * CHAIN_WIDTH})
        for time, colour in zip(shown.time, shown.colours, strict=True)
    }
    if frames:
        for name, look in zip(("$e_1$", "$e_2$"), VECTORS, strict=True):
            entries[name] = Line2D([], [], **LINE | look | {"color": INK, "markersize": 2.5})
    unit = r" $[\gamma_T d^2/\mu]$" if has_unit(trajectory.scene, "time") else ""
    handles = [Line2D([], [], linestyle="", marker=""), *entries.values()]
    axes.legend(
        handles,
        [f"$t${unit} =", *entries],
        ncols=len(handles),
        frameon=False,
        fontsize=TEXT - 1,
        labelcolor=INK,
        handlelength=1.2,
        handletextpad=0.3,
        columnspacing=0.8,
        **below(axes),
    )
