"""Draw branches of states: amplitude, speed and rotation against the key along which they run.

Stable parts are solid, unstable ones dashed. Special points are marked.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.states.branches.branch import StateBranch
from nrchain.states.branches.continuation import BranchDiagram
from nrchain.states.cycles.branch import CycleBranch
from nrchain.states.varied import Line
from nrchain.view.drawing import as_axes, check_picture, letters, new_figure, save
from nrchain.view.style import (
    COLOURS,
    INK,
    LABEL,
    LINE,
    PAPER,
    TEXT,
    TITLE,
    WIDTHS,
    style_axes,
    write_key,
)
from nrchain.view.units import Kind, words

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


QUANTITIES: dict[str, tuple[str, Kind]] = {
    "amplitude": ("distance from the line", "length"),
    "speed": ("speed |V|", "speed"),
    "spin": ("rotation |Ω|", "rate"),
}
"""What is drawn of states: its name on an axis, and its unit."""


def draw_branches(
    found: BranchDiagram, axes: Any = None, *, quantity: str = "amplitude", key: bool = True
) -> Any:
    """Draw a quantity of all branches on axes, and return the axes.

    Parameters
    ----------
    axes
        Of matplotlib; without, those of a new figure, one column wide.
    quantity
        ``"amplitude"``, ``"speed"`` or ``"spin"``, of the chain as a whole, in units of the scene.
    key
        Write the key of lines and marks into the axes.

    Raises :class:`~nrchain.errors.SceneError` for another quantity.
    """
    axes = as_axes(axes)
    values = [_values(branch, quantity) for branch in found.branches]
    return draw_line(axes, found.line, found.branches, values, _name(found, quantity), key)


def save_branches(found: BranchDiagram, path: str | Path, *, title: bool = True) -> Path:
    """Draw all branches, and return the path, whose ending chooses PNG, PDF or SVG.

    The panels show the amplitude, the speed and the rotation of the chain as a whole; one that
    vanishes on all branches is left out. An existing file is replaced. ``title`` writes that of the
    scene.

    Raises :class:`~nrchain.errors.SceneError` for another ending, and
    :class:`~nrchain.errors.TrajectoryError` for a file that cannot be written.
    """
    path = check_picture(path)
    panels = {
        name: [_values(branch, name) for branch in found.branches]
        for name in QUANTITIES
        if name == "amplitude" or _moves(found, name)
    }
    names = [_name(found, name) for name in panels]
    return save_panels(found.line, found.branches, panels.values(), names, path, title)


def save_panels(
    line: Line,
    branches: Sequence[StateBranch | CycleBranch],
    values: Iterable[Sequence[np.ndarray]],
    names: Sequence[str],
    path: Path,
    title: bool,
) -> Path:
    """Draw one panel for each quantity, with the key in common and one key of lines, and save."""
    figure = new_figure(WIDTHS["two"] * 0.75, 1.0 + 1.9 * len(names), "constrained")
    axes = np.atleast_1d(figure.subplots(len(names), 1, sharex=True))
    shown: dict[str, Any] = {}
    for axis, own, name in zip(axes, values, names, strict=True):
        style_axes(axis)
        shown = _draw_all(axis, branches, own) | shown
        axis.set_ylabel(name, size=LABEL, color=INK)
    _name_key(axes[-1], line)
    write_key(figure, shown, columns=4)
    figure.set(facecolor=PAPER, edgecolor=PAPER)
    if title:
        text = letters(line.scene.title)
        figure.suptitle(text, fontsize=TITLE, fontweight="bold", color=INK)
    save(figure, path)
    return path


def draw_line(
    axes: Any,
    line: Line,
    branches: Sequence[StateBranch | CycleBranch],
    values: Sequence[np.ndarray],
    name: str,
    key: bool,
) -> Any:
    """Draw values (m,) along each branch on axes; see :func:`draw_branches`."""
    style_axes(axes)
    shown = _draw_all(axes, branches, values)
    axes.set_ylabel(name, size=LABEL, color=INK)
    _name_key(axes, line)
    if key:
        axes.legend(shown.values(), shown.keys(), frameon=False, fontsize=TEXT, labelcolor=INK)
    return axes


def _draw_all(
    axes: Any, branches: Sequence[StateBranch | CycleBranch], values: Sequence[np.ndarray]
) -> dict[str, Any]:
    shown: dict[str, Any] = {}
    for number, (branch, own) in enumerate(zip(branches, values, strict=True)):
        shown = draw_branch(axes, branch, own, COLOURS[number % len(COLOURS)]) | shown
    return shown


def _name_key(axes: Any, line: Line) -> None:
    """Name the key along which branches run, and show its range."""
    axes.set_xlabel(letters(", ".join(line.ranges)), size=LABEL, color=INK)
    axes.set_xlim(*sorted((line.low, line.high)))


def _name(found: BranchDiagram, quantity: str) -> str:
    text, kind = QUANTITIES[quantity]
    return words(text, found.line.scene, kind)


def _values(branch: StateBranch, name: str) -> np.ndarray:
    if name not in QUANTITIES:
        raise SceneError("quantity", name, f"must be one of {', '.join(QUANTITIES)}")
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
