"""Draw a sweep: an observable as lines over one key, or as a map over two.

Maps of numbers are coloured squares, or points where the sweep fills no grid. Words, such as kinds
of attractors, have a colour and a marker each. A point without a value is a hollow cross.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.sweeps.points import portable
from nrchain.sweeps.result import Sweep, SweepPoint
from nrchain.sweeps.without_value import has_value
from nrchain.view.drawing import check_picture, letters, new_figure, save
from nrchain.view.phase_plots import LOOKS
from nrchain.view.style import (
    COLOURS,
    INK,
    MARKERS,
    PALE,
    PAPER,
    TEXT,
    WIDTHS,
    line_look,
    style_axes,
)
from nrchain.view.sweep_units import label

NUMBERS = "viridis"
"""The colour map of numbers, from dark to light."""

MISSING: dict[str, Any] = {"marker": "x", "color": PALE, "linewidths": 0.8, "s": 18.0}
"""The look of a point without a value."""

MOST_LINES = 6
"""Values of a second key that are drawn as lines; more of them make a map."""

WIDE = 30.0
"""Ratio of the ends of an axis from which on it is logarithmic, if its values are so spaced."""

ASIDE = 0.1
"""By which the marks of a word are apart, line by line, in distances of words."""

TICKS = 5
"""Most intervals along x, so that numbers of four signs stay apart in one column."""

HEIGHT = 2.6
"""Of a panel, in inches."""


def save_sweep(
    sweep: Sweep,
    path: str | Path,
    names: Sequence[str] | None = None,
    *,
    x: str | None = None,
    y: str | None = None,
    at: Mapping[str, Any] | None = None,
) -> tuple[Path, dict[str, Any]]:
    """Draw observables, a panel each, and return the path and the values of keys not drawn.

    One key makes lines. A second one makes lines too while it has few values, and else a map. Keys
    that are not drawn keep the value ``at`` gives, or their first.

    An existing file is replaced. Raises :class:`~nrchain.errors.SceneError` for keys and values
    that the sweep does not have, and for another ending than PNG, PDF or SVG.
    """
    path = check_picture(path)
    shown = list(names or sweep.observables[:1])
    if not sweep.points or not shown:
        raise SceneError("sweep", str(sweep.folder), "has no finished point to draw")
    for name in shown:
        sweep.column(name)
    across, along = _axes_of(sweep, x, y)
    fixed = _fixed(sweep, {across, along} - {None}, at or {})
    figure = new_figure(WIDTHS["one"], HEIGHT * len(shown), "constrained")
    panels = figure.subplots(len(shown), squeeze=False)[:, 0]
    for panel, name in zip(panels, shown, strict=True):
        if along is not None and (y is not None or _needs_map(sweep, name, along)):
            draw_map(sweep, name, across, along, at=fixed, axes=panel)
        else:
            draw_lines(sweep, name, across, by=along, at=fixed, axes=panel)
    save(figure, path)
    given = portable(dict(at or {}))
    return path, {key: value for key, value in fixed.items() if key not in given}


def _needs_map(sweep: Sweep, name: str, along: str) -> bool:
    """Whether lines would be too many, or of words, which lie on each other."""
    if not all(map(_is_number, sweep.column(along))):
        return False
    return bool(_words(sweep.column(name))) or len(_values(sweep, along)) > MOST_LINES


def draw_lines(
    sweep: Sweep,
    name: str,
    x: str,
    *,
    by: str | None = None,
    at: Mapping[str, Any] | None = None,
    axes: Any = None,
) -> Any:
    """Draw an observable over a key, one line for each value of the key ``by``; return the axes.

    ``at`` holds values of other keys. Without ``axes``, a figure of one column is made.
    """
    axes = _styled(axes)
    words = _words(sweep.column(name))
    values = [None] if by is None else _values(sweep, by)
    for number, value in enumerate(values):
        fixed = {**(at or {}), **({} if by is None else {by: value})}
        points = [point for point in _chosen(sweep, fixed) if _is_number(point.values[x])]
        points.sort(key=lambda point: point.values[x])
        known = [point for point in points if _has_value(point, name)]
        # words of several lines would lie on each other
        aside = ASIDE * (number - (len(values) - 1) / 2.0) if words else 0.0
        height = [_height(point.observables[name], words) + aside for point in known]
        look = line_look(number, marker=True)
        if words:
            look["linestyle"] = ""
        said = None if by is None else letters(f"{by} = {_short(value)}")
        axes.plot([p.values[x] for p in known], height, **look, label=said)
        missing = [p.values[x] for p in points if not _has_value(p, name)]
        if missing:
            base = axes.get_xaxis_transform()
            axes.scatter(missing, np.zeros(len(missing)), transform=base, clip_on=False, **MISSING)
    if words:
        axes.set_yticks(range(len(words)), [letters(word) for word in words])
        axes.set_ylim(-0.5, len(words) - 0.5)
    _scale(axes, "x", sweep, x)
    axes.set_xlabel(label(x, sweep.scene, sweep.keys))
    axes.set_ylabel(label(name, sweep.scene, sweep.keys))
    if by is not None:
        _write_key(axes)
    return axes


def draw_map(
    sweep: Sweep,
    name: str,
    x: str,
    y: str,
    *,
    at: Mapping[str, Any] | None = None,
    axes: Any = None,
) -> Any:
    """Draw an observable over two keys, as squares or points of colour; return the axes.

    ``at`` holds values of other keys. Without ``axes``, a figure of one column is made.
    """
    axes = _styled(axes)
    axes.grid(False)
    for key in (x, y):
        if not all(map(_is_number, sweep.column(key))):
            raise SceneError("key", key, "must have numbers, to be an axis of a map")
    points = _chosen(sweep, at or {})
    known = [point for point in points if _has_value(point, name)]
    places = np.array([(point.values[x], point.values[y]) for point in known], float)
    words = _words(sweep.column(name))
    for axis, key in (("x", x), ("y", y)):
        _scale(axes, axis, sweep, key)
    if words:
        _draw_words(axes, places, [str(p.observables[name]) for p in known], words)
    elif known:
        numbers = np.array([point.observables[name] for point in known], float)
        drawn = _draw_numbers(axes, places, numbers)
        bar = axes.figure.colorbar(drawn, ax=axes, format=_number)
        bar.set_label(label(name, sweep.scene, sweep.keys), size=TEXT, color=INK)
        bar.ax.tick_params(labelsize=TEXT, labelcolor=INK, width=0.6, length=2.5, color=PALE)
        bar.outline.set(linewidth=0.6, edgecolor=PALE)
    missing = [(p.values[x], p.values[y]) for p in points if not _has_value(p, name)]
    if missing:
        axes.scatter(*zip(*missing, strict=True), **MISSING, label="no value", zorder=4)
    if words or missing:
        _write_key(axes)
    axes.set_xlabel(label(x, sweep.scene, sweep.keys))
    axes.set_ylabel(label(y, sweep.scene, sweep.keys))
    return axes


def _draw_numbers(axes: Any, places: np.ndarray, numbers: np.ndarray) -> Any:
    """Squares where the places fill a grid, else points."""
    xs, ys = (np.unique(places[:, k]) for k in (0, 1))
    if len(xs) < 2 or len(ys) < 2 or len(places) != len(xs) * len(ys):
        return axes.scatter(
            *places.T, c=numbers, cmap=NUMBERS, s=16.0, edgecolors=PALE, linewidths=0.3, zorder=3
        )
    order = np.lexsort((places[:, 0], places[:, 1]))
    table = numbers[order].reshape(len(ys), len(xs))
    edges = [
        _edges(values, scale)
        for values, scale in ((xs, axes.get_xscale()), (ys, axes.get_yscale()))
    ]
    return axes.pcolormesh(*edges, table, cmap=NUMBERS, rasterized=True)


def _draw_words(axes: Any, places: np.ndarray, said: Sequence[str], words: Sequence[str]) -> None:
    for number, word in enumerate(words):
        own = places[[k for k, one in enumerate(said) if one == word]]
        if not len(own):
            continue
        marker = LOOKS[word][1] if word in LOOKS else MARKERS[number % len(MARKERS)]
        colour = COLOURS[number % len(COLOURS)]
        axes.scatter(
            *own.T,
            s=20.0,
            color=colour,
            marker=marker,
            linewidths=0.8,
            label=letters(word),
            zorder=3,
        )


def _write_key(axes: Any) -> None:
    """Write the key of lines or markers above the axes."""
    axes.legend(
        frameon=False,
        fontsize=TEXT,
        labelcolor=INK,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=2,
    )


def _edges(values: np.ndarray, scale: str) -> np.ndarray:
    """Edges half-way between the values, on a linear or logarithmic axis."""
    on = np.log(values) if scale == "log" else values
    middle = (on[:-1] + on[1:]) / 2.0
    ends = [2.0 * on[0] - middle[0]], [2.0 * on[-1] - middle[-1]]
    edges = np.concatenate([ends[0], middle, ends[1]])
    return np.exp(edges) if scale == "log" else edges


def _axes_of(sweep: Sweep, x: str | None, y: str | None) -> tuple[str, str | None]:
    """The key along x, and the second one: those given, or the first with several values."""
    for name, key in (("x", x), ("y", y)):
        if key is not None and key not in sweep.keys:
            raise SceneError(name, key, f"must be a key of the sweep: {', '.join(sweep.keys)}")
    if x is not None and x == y:
        raise SceneError("y", y, "must differ from x")
    varied = [key for key in sweep.keys if len(_values(sweep, key)) > 1] or list(sweep.keys[:1])
    free = [key for key in varied if key not in (x, y)]
    numeric = [key for key in free if all(map(_is_number, sweep.column(key)))]
    across = x if x is not None else next(iter(numeric or free), None)
    if across is None:
        raise SceneError("x", x, "must be given: the sweep varies no further key")
    rest = [key for key in free if key != across]
    return across, y if y is not None else next(iter(rest), None)


def _fixed(sweep: Sweep, drawn: set[str | None], at: Mapping[str, Any]) -> dict[str, Any]:
    """The values of all keys that are not drawn."""
    for key, value in portable(dict(at)).items():
        if key not in sweep.keys or key in drawn:
            free = ", ".join(one for one in sweep.keys if one not in drawn) or "none"
            raise SceneError(f"at {key}", value, f"must be a key that is not drawn: {free}")
        if value not in _values(sweep, key):
            there = ", ".join(map(_short, _values(sweep, key)))
            raise SceneError(f"at {key}", value, f"must be a value of the sweep: {there}")
    first = {key: _values(sweep, key)[0] for key in sweep.keys if key not in drawn}
    return first | portable(dict(at))


def _values(sweep: Sweep, key: str) -> list[Any]:
    """The different values of a key, in order."""
    found: list[Any] = []
    for value in sweep.column(key):
        if value not in found:
            found.append(value)
    return sorted(found) if all(map(_is_number, found)) else found


def _chosen(sweep: Sweep, fixed: Mapping[str, Any]) -> list[SweepPoint]:
    return [
        point
        for point in sweep.points
        if all(point.values[key] == value for key, value in fixed.items())
    ]


def _words(values: Sequence[Any]) -> list[str]:
    """The different words of an observable, those of attractors first; none for numbers."""
    found = {value for value in values if isinstance(value, str)}
    return [kind for kind in LOOKS if kind in found] + sorted(found - set(LOOKS))


def _height(value: Any, words: Sequence[str]) -> float:
    return float(words.index(str(value))) if words else float(value)


def _has_value(point: SweepPoint, name: str) -> bool:
    return has_value({**point.values, **point.observables}.get(name))


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float))


def _scale(axes: Any, axis: str, sweep: Sweep, key: str) -> None:
    """Make an axis logarithmic where the values of its key are spaced so."""
    held = [value for value in _values(sweep, key) if _is_number(value)]
    if all(isinstance(value, int) for value in held):
        getattr(axes, f"{axis}axis").get_major_locator().set_params(integer=True)
    values = np.array(held, float)
    if len(values) < 3 or values.min() <= 0.0 or values.max() < WIDE * values.min():
        return
    steps = np.diff(np.log(values))
    if steps.max() < 2.0 * steps.min():
        getattr(axes, f"set_{axis}scale")("log")


def _styled(axes: Any) -> Any:
    if axes is None:
        axes = new_figure(WIDTHS["one"], HEIGHT, "constrained").subplots()
    style_axes(axes)
    axes.set_facecolor(PAPER)
    axes.xaxis.get_major_locator().set_params(nbins=TICKS)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(_number)
    return axes


def _number(value: float, place: int | None = None) -> str:
    """A number beside an axis, whole: a factor above the axis would meet the key of the lines."""
    return f"{value:.6g}".replace("-", "\N{MINUS SIGN}")


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
