"""Draw branches of states: amplitude, speed and rotation against the key along which they run.

Stable parts are solid, unstable ones dashed. Special points are marked.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.states.branches.branch import StateBranch
from nrchain.states.branches.continuation import BranchDiagram
from nrchain.states.cycles.branch import CycleBranch
from nrchain.states.varied import Line
from nrchain.view.drawing import check_picture, letters, new_figure, save
from nrchain.view.style import COLOURS, INK, LABEL, LINE, PAPER, TITLE, style_axes, write_key

STABLE, UNSTABLE = "-", (0, (4, 2))

MARKERS = {
    "fold": (">", "fold"),
    "pitchfork": ("s", "pitchfork"),
    "transcritical": ("D", "transcritical point"),
    "branch point": ("X", "branch point"),
    "Hopf": ("o", "Hopf point"),
    "period doubling": ("^", "period doubling"),
    "Neimark–Sacker": ("h", "Neimark–Sacker point"),
}

VANISHING = 1e-9
"""Speeds and rotations below this, in a and radians per unit time of the fastest mode, are none."""


def draw_branches(found: BranchDiagram, path: str | Path) -> Path:
    """Draw all branches, and return the path, whose ending chooses PNG, PDF or SVG.

    The panels show the amplitude, the speed and the rotation of the chain as a whole; one that
    vanishes on all branches is left out. An existing file is replaced.

    Raises :class:`~nrchain.errors.SceneError` for another ending, and
    :class:`~nrchain.errors.TrajectoryError` for a file that cannot be written.
    """
    path = check_picture(path)
    panels = [one for one in _PANELS if one[0] == "amplitude" or _moves(found, one[0])]
    figure = new_figure(7.2, 1.4 + 2.6 * len(panels), "constrained")
    axes = np.atleast_1d(figure.subplots(len(panels), 1, sharex=True))
    shown: dict[str, Any] = {}
    for axis, (name, label) in zip(axes, panels, strict=True):
        style_axes(axis)
        for number, branch in enumerate(found.branches):
            colour = COLOURS[number % len(COLOURS)]
            shown = draw_branch(axis, branch, _values(branch, name), colour) | shown
        axis.set_ylabel(label, size=LABEL, color=INK)
    return finish(figure, axes, found.line, shown, path)


def finish(figure: Any, axes: Any, line: Line, shown: Mapping[str, Any], path: Path) -> Path:
    """Label the axis of the key, add the key of lines and marks, and save."""
    axes[-1].set_xlabel(letters(", ".join(line.ranges)), size=LABEL, color=INK)
    axes[-1].set_xlim(*sorted((line.low, line.high)))
    write_key(figure, shown, columns=5)
    figure.set(facecolor=PAPER, edgecolor=PAPER)
    title = letters(line.scene.title)
    figure.suptitle(title, fontsize=TITLE, fontweight="bold", color=INK)
    save(figure, path)
    return path


_PANELS = (
    ("amplitude", "distance from the line"),
    ("speed", "speed |V|"),
    ("spin", "rotation |Ω|"),
)


def _values(branch: StateBranch, name: str) -> np.ndarray:
    if name == "spin":
        return np.linalg.norm(branch.rotation, axis=1)
    return np.asarray(getattr(branch, name))


def _moves(found: BranchDiagram, name: str) -> bool:
    fastest = max(float(np.abs(branch.rates).max()) for branch in found.branches)
    scale = found.line.scene.chain.radius if name == "speed" else 1.0
    return any(_values(one, name).max() > VANISHING * scale * fastest for one in found.branches)


def draw_branch(
    axes: Any, branch: StateBranch | CycleBranch, values: np.ndarray, colour: str
) -> dict[str, Any]:
    """Draw values (m,) along a branch; return a line of each kind for the key."""
    lines: dict[str, Any] = {}
    path, stable = _path(branch, values)
    edges = [0, *(np.flatnonzero(np.diff(stable)) + 1), len(stable)]
    for begin, end in pairwise(edges):
        word, dashes = ("stable", STABLE) if stable[begin] else ("unstable", UNSTABLE)
        own = LINE | {"color": colour, "linewidth": 1.4, "linestyle": dashes}
        (lines[word],) = axes.plot(*path[begin : end + 1].T, **own)
    points: tuple[Any, ...] = branch.special
    for special, height in zip(points, _heights(branch, values), strict=True):
        marker, word = MARKERS[special.kind]
        look = {"marker": marker, "markersize": 5.0, "markerfacecolor": PAPER, "linestyle": ""}
        look |= {"color": colour, "markeredgecolor": colour, "markeredgewidth": 1.1, "zorder": 3}
        (lines[word],) = axes.plot([special.value], [height], **look)
    return lines


def _path(branch: StateBranch | CycleBranch, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k, 2): a branch with its special points, and whether each piece is stable."""
    points = np.column_stack([branch.values, values])
    special = [one.value for one in branch.special]
    marks = list(zip(special, _heights(branch, values), strict=True))
    after = [one.index + 1 for one in branch.special]
    path = np.insert(points, after, marks, axis=0) if marks else points
    ends = (
        np.insert(branch.is_stable, after, branch.is_stable[after]) if marks else branch.is_stable
    )
    return path, ends[:-1]


def _heights(branch: StateBranch | CycleBranch, heights: np.ndarray) -> list[float]:
    """What is drawn of a branch at its special points, between the states next to them."""
    found = []
    for special in branch.special:
        sides = slice(special.index, special.index + 2)
        order = np.argsort(branch.values[sides])
        found.append(
            float(np.interp(special.value, branch.values[sides][order], heights[sides][order]))
        )
    return found
