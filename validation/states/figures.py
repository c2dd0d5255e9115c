"""Figures: the branches of pushers, and those of the mix that goes round."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import nrchain

BRANCHES_CAPTION = (
    "Clamped chains of N = 20 with isotropic links, R = 10⁸: largest distance of a sphere from the "
    "axis. Left: pushers buckle at three pitchforks (squares). Right: with 2s = 60 and growing 3t "
    "the buckled chain straightens, and goes round its axis beyond a Hopf point (circle); its "
    "rotation Ω is drawn below. Solid: stable. Dashed: unstable."
)

MARKERS = {"pitchfork": "s", "transcritical": "D", "fold": ">", "Hopf": "o"}


def branches(pushers: nrchain.BranchDiagram, mix: nrchain.BranchDiagram) -> Figure:
    """Amplitudes against 2s, and amplitudes and rotation against 3t."""
    figure = Figure(figsize=(8.4, 4.6), layout="constrained")
    panels = figure.subplots(2, 2, height_ratios=(2, 1))
    _draw(panels[0, 0], pushers, lambda branch: branch.amplitude)
    _draw(panels[0, 1], mix, lambda branch: branch.amplitude)
    _draw(panels[1, 1], mix, lambda branch: np.abs(branch.rotation[:, 0]))
    panels[0, 0].set(ylabel="distance from the axis / a")
    panels[1, 1].set(xlabel="3t", ylabel="Ω")
    panels[0, 0].set(xlabel="2s")
    panels[1, 0].set_axis_off()
    return figure


def _draw(panel: Any, found: nrchain.BranchDiagram, height: Any) -> None:
    for number, branch in enumerate(found.branches):
        heights, stable = height(branch), branch.is_stable
        edges = [0, *(np.flatnonzero(np.diff(stable)) + 1), len(branch)]
        for begin, end in pairwise(edges):
            part = slice(begin, min(end + 1, len(branch)))
            dashes = "-" if stable[begin] else (0, (4, 2))
            panel.plot(branch.values[part], heights[part], color=f"C{number}", linestyle=dashes)
        for special in branch.special:
            at = np.interp(special.value, *_sides(branch, heights, special.index))
            look = {"markerfacecolor": "white", "color": f"C{number}", "zorder": 3}
            panel.plot([special.value], [at], MARKERS[special.kind], **look)


def _sides(
    branch: nrchain.StateBranch, heights: np.ndarray, index: int
) -> tuple[np.ndarray, np.ndarray]:
    sides = slice(index, index + 2)
    order = np.argsort(branch.values[sides])
    return branch.values[sides][order], heights[sides][order]
