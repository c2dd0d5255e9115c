"""Draw branches of cycles: amplitude and period against the key along which they run.

Stable parts are solid, unstable ones dashed. Special points are marked.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nrchain.states.cycles.continuation import CycleDiagram
from nrchain.view.branch_plots import draw_branch, finish
from nrchain.view.drawing import check_picture, new_figure
from nrchain.view.style import COLOURS, INK, LABEL, style_axes

PANELS = ("amplitudes", "largest excursion"), ("periods", "period T")


def draw_cycles(found: CycleDiagram, path: str | Path) -> Path:
    """Draw all branches, and return the path, whose ending chooses PNG, PDF or SVG.

    An existing file is replaced.

    Raises :class:`~nrchain.errors.SceneError` for another ending, and
    :class:`~nrchain.errors.TrajectoryError` for a file that cannot be written.
    """
    path = check_picture(path)
    figure = new_figure(7.2, 1.4 + 2.6 * len(PANELS), "constrained")
    axes = figure.subplots(len(PANELS), 1, sharex=True)
    shown: dict[str, Any] = {}
    for axis, (name, label) in zip(axes, PANELS, strict=True):
        style_axes(axis)
        for number, branch in enumerate(found.branches):
            colour = COLOURS[number % len(COLOURS)]
            shown = draw_branch(axis, branch, getattr(branch, name), colour) | shown
        axis.set_ylabel(label, size=LABEL, color=INK)
    return finish(figure, axes, found.line, shown, path)
