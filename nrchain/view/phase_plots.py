"""Draw a phase diagram: regions by colour and marker, and thresholds as lines.

Each point colours the quarter of every cell that is next to it. Colours differ in lightness, and
each kind has its marker, so that the picture is read in grey too. Where several kinds are stable,
the quarter has the colour of the first, hatched in that of the second, and all their markers. The
straight chain buckles on solid lines and flutters on dashed ones.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nrchain.diagrams.diagram import PhaseDiagram
from nrchain.diagrams.plane import Plane
from nrchain.view.drawing import as_axes, check_picture, letters, new_figure, save
from nrchain.view.style import INK, LINE, PAPER, TEXT, WIDTHS, style_axes, write_title

LOOKS: dict[str, tuple[str, str]] = {
    "straight": ("#f2f2f2", "."),
    "buckled": ("#b3d0ea", "s"),
    "coiled": ("#4e79c4", "D"),
    "swimming": ("#c7e9c0", ">"),
    "spinning": ("#74c476", "p"),
    "rotating shape": ("#fdae6b", "o"),
    "standing oscillation": ("#e8735a", "_"),
    "travelling oscillation": ("#c02a2a", "x"),
    "irregular": ("#54207a", "*"),
    "touching": ("#7d7d7d", "v"),
    "torn": ("#303030", "^"),
    "unsettled": ("#ffffff", "1"),
    "failed": ("#ffffff", "$?$"),
}
"""Colour and marker of each kind."""

OTHER = ("#d9d9d9", "h")
"""Those of a kind that is not listed."""

DARK = ("#4e79c4", "#c02a2a", "#54207a", "#7d7d7d", "#303030")
"""Colours on which markers are white."""

THRESHOLDS: dict[bool, dict[str, Any]] = {
    False: {"linestyle": "-", "label": "straight chain buckles"},
    True: {"linestyle": (0, (4, 2)), "label": "straight chain flutters"},
}

MARKER, CROWDED = 14.0, 800
"""Area of a marker, in square points, and number of points from which on it is smaller."""


def draw_phases(diagram: PhaseDiagram, axes: Any = None, *, key: bool = True) -> Any:
    """Draw regions and thresholds on axes, and return the axes.

    ``axes`` are of matplotlib; without, those of a new figure, one column wide. ``key`` writes the
    key of colours, markers and lines beside the axes.
    """
    axes = as_axes(axes, height=3.0)
    entries = _draw_diagram(axes, diagram)
    if key:
        _write_key(axes, entries, {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)})
    return axes


def save_phases(diagram: PhaseDiagram, path: str | Path, *, title: bool = True) -> Path:
    """Draw regions and thresholds, and return the path, whose ending chooses PNG, PDF or SVG.

    An existing file is replaced. ``title`` writes that of the scene.

    Raises :class:`~nrchain.errors.SceneError` for another ending, and
    :class:`~nrchain.errors.TrajectoryError` for a file that cannot be written.
    """
    path = check_picture(path)
    save(phase_figure(diagram, title), path)
    return path


def phase_figure(diagram: PhaseDiagram, title: bool = True) -> Any:
    """The figure of a diagram, as :func:`save_phases` saves it."""
    figure = new_figure(WIDTHS["two"] * 0.75, 4.4, "constrained")
    axes = figure.subplots()
    entries = _draw_diagram(axes, diagram)
    if title:
        write_title(axes, letters(diagram.scene.title))
    _write_key(figure, entries, {"loc": "outside lower center", "ncols": 3})
    figure.set(facecolor=PAPER, edgecolor=PAPER)
    return figure


def _draw_diagram(axes: Any, diagram: PhaseDiagram) -> list[tuple[Any, str]]:
    """Draw all of a diagram on axes; return the entries of its key."""
    style_axes(axes)
    axes.grid(False)
    entries = [*_draw_regions(axes, diagram), *_draw_curves(axes, diagram)]
    axes.set(
        xlabel=letters(diagram.x.key),
        ylabel=letters(diagram.y.key),
        xlim=(diagram.x.low, diagram.x.high),
        ylim=(diagram.y.low, diagram.y.high),
    )
    return entries


def _write_key(parent: Any, entries: list[tuple[Any, str]], place: dict[str, Any]) -> None:
    from matplotlib.legend_handler import HandlerTuple

    parent.legend(
        [handle for handle, _ in entries],
        [text for _, text in entries],
        handler_map={tuple: HandlerTuple(ndivide=1)},
        frameon=False,
        fontsize=TEXT,
        labelcolor=INK,
        **place,
    )


def _draw_regions(axes: Any, diagram: PhaseDiagram) -> list[tuple[Any, str]]:
    """Draw the quarters of all cells and the markers; return one entry of the key for each kind."""
    from matplotlib.collections import PolyCollection

    plane = Plane(diagram.scene, diagram.x, diagram.y, diagram.levels)
    kinds = {point.site: point.kinds for point in diagram.points}
    quarters: dict[tuple[str, ...], list[np.ndarray]] = {}
    for i, j, side in diagram.cells:
        for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
            site = i + a * side, j + b * side
            if site in kinds:
                corners = _quarter(plane, site, (0.5 - a) * side, (0.5 - b) * side)
                quarters.setdefault(kinds[site], []).append(corners)
    size = MARKER * min(1.0, CROWDED / max(len(diagram.points), 1))
    entries = []
    for own in sorted(quarters, key=lambda one: (len(one), one)):
        fill = _fill(own)
        area = PolyCollection(quarters[own], linewidth=0.0, antialiased=False, zorder=1, **fill)
        axes.add_collection(area)
        at = np.array([(point.x, point.y) for point in diagram.points if point.kinds == own])
        for kind in own:
            axes.scatter(*at.T, s=size, **_marker(kind, own), zorder=3, clip_on=False)
        entries.append((_entry(own, fill), " or ".join(own)))
    return entries


def _quarter(plane: Plane, site: tuple[int, int], wide: float, tall: float) -> np.ndarray:
    """The corners (4, 2) of the quarter of a cell that is next to a point."""
    i, j = site
    around = ((i, j), (i + wide, j), (i + wide, j + tall), (i, j + tall))
    return np.array([plane.place(place) for place in around])


def _look(kind: str) -> tuple[str, str]:
    return LOOKS.get(kind, OTHER)


def _fill(kinds: tuple[str, ...]) -> dict[str, Any]:
    colour = _look(kinds[0])[0]
    if len(kinds) == 1:
        return {"facecolor": colour}
    return {"facecolor": colour, "hatch": "////", "edgecolor": _look(kinds[1])[0]}


def _marker(kind: str, kinds: tuple[str, ...]) -> dict[str, Any]:
    ink = PAPER if _look(kinds[0])[0] in DARK and len(kinds) == 1 else INK
    return {"marker": _look(kind)[1], "color": ink, "linewidth": 0.6}


def _entry(kinds: tuple[str, ...], fill: dict[str, Any]) -> tuple[Any, ...]:
    """The symbol of the key: a patch with the markers upon it."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    markers = [
        Line2D([], [], linestyle="", markersize=4.5, **_marker(kind, kinds)) for kind in kinds
    ]
    look: dict[str, Any] = {"edgecolor": INK, "linewidth": 0.4} | fill
    patch = Patch(**look)
    return patch, *markers


def _draw_curves(axes: Any, diagram: PhaseDiagram) -> list[tuple[Any, str]]:
    """Draw the thresholds; return one line of each kind."""
    lines: dict[bool, Any] = {}
    for curve in diagram.curves:
        look = LINE | THRESHOLDS[curve.flutters] | {"color": INK, "linewidth": 1.6, "zorder": 4}
        (line,) = axes.plot(curve.x, curve.y, **look)
        lines.setdefault(curve.flutters, line)
    return [(line, line.get_label()) for line in lines.values()]
