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
from nrchain.errors import SceneError
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.drawing import (
    as_axes,
    check_drawable,
    check_snapshots,
    letters,
    new_figure,
    pick_evenly,
    save,
)
from nrchain.view.one_chain import DISCERNIBLE
from nrchain.view.style import (
    INK,
    LINE,
    PALE,
    PAPER,
    TEXT,
    TITLE,
    WIDTHS,
    line_look,
    style_axes,
    write_title,
)
from nrchain.view.units import label

LEAST = 1e-12
"""Fraction of the largest size below which a size is rounding and is not drawn."""

MOST_TIMES = 200
"""Largest number of snapshots that are decomposed."""


PANELS = ("velocity", "angular velocity", "over time")
"""What of the effects a panel shows."""


def draw_effects(
    trajectory: Trajectory, axes: Any = None, *, panel: str = "over time", key: bool = True
) -> Any:
    """Draw the contribution of every effect on axes, and return the axes.

    Parameters
    ----------
    axes
        Of matplotlib; without, those of a new figure, one column wide.
    panel
        ``"velocity"``: |v| of every sphere at the last state; ``"angular velocity"``: a|ω| there;
        ``"over time"``: √⟨|v|² + a²|ω|²⟩ of up to :data:`MOST_TIMES` snapshots.
    key
        Write the key of the lines into the axes.

    Raises :class:`~nrchain.errors.SceneError` for another panel, and
    :class:`~nrchain.errors.TrajectoryError` for a trajectory without snapshots.
    """
    if panel not in PANELS:
        raise SceneError("panel", panel, f"must be one of {', '.join(PANELS)}")
    check_snapshots(trajectory)
    axes = as_axes(axes)
    if panel == "over time":
        lines = _draw_over_time(axes, trajectory)
    else:
        lines = _draw_along(axes, trajectory, panel)
    if key:
        axes.legend(lines.values(), lines.keys(), frameon=False, fontsize=TEXT, labelcolor=INK)
    return axes


def save_effects(trajectory: Trajectory, path: str | Path, *, title: bool = True) -> Path:
    """Draw every effect's twist along the chain at the last state, and its size over time.

    Returns the path, whose ending chooses PNG, PDF or SVG. An existing file is replaced. ``title``
    writes that of the scene.

    Raises :class:`~nrchain.errors.SceneError` for another ending, and
    :class:`~nrchain.errors.TrajectoryError` for a trajectory without snapshots and for a file that
    cannot be written.
    """
    path = check_drawable(trajectory, path)
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    room = ConstrainedLayoutEngine(h_pad=0.04167, w_pad=0.04167, hspace=0.02, wspace=0.02)
    figure = new_figure(WIDTHS["two"], 3.8, room)
    left, right = list(figure.subfigures(1, 2, squeeze=False).flat)
    upper, lower = left.subplots(2, 1, sharex=True)
    lines = _draw_along(upper, trajectory, "velocity")
    lines |= _draw_along(lower, trajectory, "angular velocity")
    upper.tick_params(labelbottom=False)
    upper.set_xlabel("")
    write_title(upper, f"along the chain at $t$ = {trajectory.time[-1]:.4g}")
    over_time = right.subplots()
    lines = _draw_over_time(over_time, trajectory) | lines
    write_title(over_time, "over time")
    figure.legend(
        lines.values(),
        lines.keys(),
        loc="outside lower center",
        ncols=max(1, min(len(lines), 6)),
        frameon=False,
        fontsize=TEXT,
        labelcolor=INK,
    )
    for part in (left, right):
        part.set(facecolor=PAPER, edgecolor=PAPER)
    if title:
        words = letters(trajectory.scene.title)
        figure.suptitle(words, fontsize=TITLE, fontweight="bold", color=INK)
    save(figure, path)
    return path


def _draw_along(axes: Any, trajectory: Trajectory, panel: str) -> dict[str, Any]:
    """Draw |v| or a|ω| of every effect at the last snapshot; return the lines by effect."""
    scene = trajectory.scene
    found = Decomposition(scene).at(trajectory.positions[-1], trajectory.frames[-1])
    twists = {name: part.twist for name, part in found.items()} | {"total": found.total.twist}
    spheres = np.arange(scene.chain.particles)
    marker = "." if len(spheres) <= DISCERNIBLE else ""
    moves = panel == "velocity"
    columns, factor = (slice(0, 3), 1.0) if moves else (slice(3, 6), scene.chain.radius)
    sizes = {n: factor * np.linalg.norm(t[:, columns], axis=1) for n, t in twists.items()}
    style_axes(axes)
    lines = {}
    for name, values in _above_rounding(sizes).items():
        look = {"marker": marker, "markersize": 3, "markeredgewidth": 1.0}
        (lines[name],) = axes.plot(spheres, values, **_line_style(name, list(twists)) | look)
    _set_scale(axes, sizes)
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set(ylabel=label("|v|" if moves else r"a\,|\omega|", scene, "speed"), xlabel="sphere")
    return {name: lines[name] for name in twists if name in lines}


def _draw_over_time(axes: Any, trajectory: Trajectory) -> dict[str, Any]:
    """Draw √⟨|v|² + a²|ω|²⟩ of every effect against t; return the lines by effect."""
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
    lines = {}
    for name, values in _above_rounding(sizes).items():
        (lines[name],) = axes.plot(shown.time, values, **_line_style(name, list(sizes)) | marker)
    _set_scale(axes, sizes)
    size = r"\langle |v|^2 + a^2 |\omega|^2 \rangle^{1/2}"
    scene = trajectory.scene
    axes.set(xlabel=label("t", scene, "time"), ylabel=label(size, scene, "speed"))
    return lines


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
