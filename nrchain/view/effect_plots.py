"""Draw the contribution of every effect to the motion: along the chain, and over time.

The scale is logarithmic, since sizes span orders of magnitude. Along the chain it shows |v| and
a|ω| of every sphere at the last state; over time it shows √⟨|v|² + a²|ω|²⟩. Contributions of zero
are not drawn.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nrchain.analysis.decomposition import Decomposition
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.chain_views import DISCERNIBLE
from nrchain.view.drawing import check_drawable, letters, new_figure, pick_evenly, save
from nrchain.view.style import (
    INK,
    LINE,
    PALE,
    PAPER,
    TEXT,
    TITLE,
    line_look,
    style_axes,
    write_title,
)

LEAST = 1e-12
"""Fraction of the largest size below which a size is rounding and is not drawn."""

MOST_TIMES = 200
"""Largest number of snapshots that are decomposed."""


def draw_effects(trajectory: Trajectory, path: str | Path) -> Path:
    """Draw every effect's twist along the chain at the last state, and its size over time.

    Returns the path, whose ending chooses PNG, PDF or SVG. An existing file is replaced.

    Raises :class:`~nrchain.errors.SceneError` for another ending, and
    :class:`~nrchain.errors.TrajectoryError` for a trajectory without snapshots and for a file that
    cannot be written.
    """
    path = check_drawable(trajectory, path)
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    room = ConstrainedLayoutEngine(h_pad=0.04167, w_pad=0.04167, hspace=0.02, wspace=0.02)
    figure = new_figure(9.0, 4.6, room)
    left, right = list(figure.subfigures(1, 2, squeeze=False).flat)
    lines = _draw_along(left.subplots(2, 1, sharex=True), trajectory)
    _draw_over_time(right.subplots(), trajectory)
    figure.legend(
        lines.values(),
        lines.keys(),
        loc="outside lower center",
        ncols=min(len(lines), 6),
        frameon=False,
        fontsize=TEXT,
        labelcolor=INK,
    )
    for part in (left, right):
        part.set(facecolor=PAPER, edgecolor=PAPER)
    title = letters(trajectory.scene.title)
    figure.suptitle(title, fontsize=TITLE, fontweight="bold", color=INK)
    save(figure, path)
    return path


def _draw_along(panels: Any, trajectory: Trajectory) -> dict[str, Any]:
    """Draw |v| and a|ω| of every effect at the last snapshot; return the lines by effect."""
    scene = trajectory.scene
    found = Decomposition(scene).at(trajectory.positions[-1], trajectory.frames[-1])
    twists = {name: part.twist for name, part in found.items()} | {"total": found.total.twist}
    spheres = np.arange(scene.chain.particles)
    marker = "." if len(spheres) <= DISCERNIBLE else ""
    lines = {}
    for axes in panels:
        style_axes(axes)
    for axes, columns, factor in (
        (panels[0], slice(0, 3), 1.0),
        (panels[1], slice(3, 6), scene.chain.radius),
    ):
        sizes = {n: factor * np.linalg.norm(t[:, columns], axis=1) for n, t in twists.items()}
        for name, values in _above_rounding(sizes).items():
            look = _line_style(name, list(twists)) | {
                "marker": marker,
                "markersize": 3,
                "markeredgewidth": 1.0,
            }
            lines[name], *_ = axes.plot(spheres, values, **look)
        _set_scale(axes, sizes)
    panels[1].xaxis.get_major_locator().set_params(integer=True)
    panels[0].tick_params(labelbottom=False)
    panels[0].set(ylabel="$|v|$")
    write_title(panels[0], f"along the chain at $t$ = {trajectory.time[-1]:.4g}")
    panels[1].set(ylabel=r"$a\,|\omega|$", xlabel="sphere")
    return {name: lines[name] for name in twists if name in lines}


def _draw_over_time(axes: Any, trajectory: Trajectory) -> None:
    """Draw √⟨|v|² + a²|ω|²⟩ of every effect against t."""
    chosen = pick_evenly(len(trajectory.time), MOST_TIMES)
    shown = Trajectory(
        trajectory.time[chosen],
        trajectory.positions[chosen],
        trajectory.frames[chosen],
        trajectory.scene,
    )
    sizes = Decomposition(trajectory.scene).sizes(shown)
    style_axes(axes)
    marker = {"marker": "." if len(chosen) < 3 else "", "markersize": 6, "markeredgewidth": 1.0}
    for name, values in _above_rounding(sizes).items():
        axes.plot(shown.time, values, **_line_style(name, list(sizes)) | marker)
    _set_scale(axes, sizes)
    axes.set(xlabel="$t$", ylabel=r"$\langle |v|^2 + a^2 |\omega|^2 \rangle^{1/2}$")
    write_title(axes, "over time")


def _above_rounding(sizes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The sizes above rounding, NaN elsewhere, of the effects that have any."""
    largest = max((float(values.max()) for values in sizes.values()), default=0.0)
    shown = {}
    for name, values in sizes.items():
        above = values > LEAST * largest
        if above.any():
            shown[name] = np.where(above, values, np.nan)
    return shown


def _line_style(name: str, names: list[str]) -> dict[str, Any]:
    """The colour and dashes of an effect: the same in every panel."""
    if name == "total":
        return LINE | {"color": INK, "linewidth": 1.8, "zorder": 1}
    return line_look(names.index(name)) | {"linewidth": 1.0, "zorder": 2}


def _set_scale(axes: Any, sizes: dict[str, np.ndarray]) -> None:
    """Set a logarithmic scale, or say that nothing moves."""
    axes.margins(0.05)
    if _above_rounding(sizes):
        axes.set_yscale("log")
    else:
        axes.text(
            0.5, 0.5, "nothing moves", transform=axes.transAxes, ha="center", color=PALE, size=TEXT
        )
