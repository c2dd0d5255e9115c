"""Arrows of forces and torques, in the plane, out of it and into it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nrchain.figures.keys import Glyph, write_glyphs
from nrchain.figures.sheet import key_place
from nrchain.view.style import COLOURS, DASHES, INK, LINE, PAPER

FORCE: dict[str, Any] = {"color": COLOURS[0], "linewidth": 1.3}
TORQUE: dict[str, Any] = {"color": COLOURS[1], "linewidth": 1.3, "linestyle": DASHES[2]}
"""Forces are solid, torques are dotted."""

NEGLIGIBLE = 0.02
"""Fraction of the largest force or torque below which no arrow is drawn."""

TURN = np.radians(260.0)
"""The angle of a round arrow."""


def draw_sphere(axes: Any, centre: np.ndarray, colour: Any = PAPER, edge: Any = INK) -> None:
    """Draw a sphere of radius 1 on axes in units of a."""
    from matplotlib.patches import Circle

    circle = Circle(tuple(centre), 1.0)
    circle.set(facecolor=colour, edgecolor=edge, linewidth=0.8, zorder=4)
    axes.add_patch(circle)


def draw_axis(axes: Any, centre: np.ndarray, direction: np.ndarray, *, polar: bool) -> None:
    """Draw e₁ of a squirmer: an arrow if it is polar, with two heads if it is not."""
    half = 0.8 * direction
    look = {"color": PAPER, "linewidth": 1.3}
    _arrow(axes, centre - half, centre + half, look, "-|>" if polar else "<|-|>", 5)


def draw_arrow(
    axes: Any,
    begin: np.ndarray,
    vector: np.ndarray,
    look: dict[str, Any],
    heads: int = 1,
    size: float = 7.0,
) -> None:
    """Draw a vector from a point, with a second head on a torque in the plane."""
    shaft = np.stack([begin, begin + 0.9 * vector])
    axes.plot(*shaft.T, **LINE | look | {"zorder": 6})
    for end in (1.0, 0.68)[:heads]:
        _arrow(axes, begin + 0.9 * end * vector, begin + end * vector, _solid(look), "-|>", size)


def _solid(look: dict[str, Any]) -> dict[str, Any]:
    """The look of a head: dashes are for lines."""
    return {name: value for name, value in look.items() if name != "linestyle"}


def _arrow(
    axes: Any, begin: np.ndarray, end: np.ndarray, look: dict[str, Any], style: str, size: float
) -> None:
    from matplotlib.patches import FancyArrowPatch

    arrow = FancyArrowPatch(
        tuple(begin), tuple(end), arrowstyle=style, mutation_scale=size, shrinkA=0, shrinkB=0
    )
    arrow.set(zorder=6, joinstyle="miter", capstyle="butt", **look)
    axes.add_patch(arrow)


def draw_turn(axes: Any, centre: np.ndarray, sense: float, look: dict[str, Any]) -> None:
    """Draw a round arrow about a sphere: anticlockwise for a torque towards the reader."""
    angle = np.pi / 2 - sense * TURN / 2 + sense * np.linspace(0.0, TURN, 40)
    path = centre + 1.4 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    axes.plot(*path.T, **LINE | look | {"zorder": 5})
    _arrow(axes, path[-4], path[-1], _solid(look), "-|>", 6)


def draw_normal(axes: Any, centre: np.ndarray, sense: float, size: float, colour: Any) -> None:
    """Draw ⊙ for a vector towards the reader, ⊗ for one away from the reader."""
    ring = {"linestyle": "", "marker": "o", "markersize": size, "markerfacecolor": "none"}
    ring |= {"markeredgecolor": colour, "markeredgewidth": 1.0, "zorder": 6}
    inner = ring | {"marker": "o" if sense > 0 else "x", "markerfacecolor": colour}
    inner |= {"markersize": 0.3 * size if sense > 0 else 0.6 * size}
    for look in (ring, inner):
        axes.plot(*centre[:, None], **LINE | look)


ORIGIN = np.zeros(2)
RIGHT = np.array([1.0, 0.0])


def force_glyph() -> Glyph:
    """A straight arrow, for a key."""
    return Glyph(lambda axes: draw_arrow(axes, -2.2 * RIGHT, 4.4 * RIGHT, FORCE))


def normal_force_glyph() -> Glyph:
    """The signs ⊙ and ⊗, for a key."""

    def draw(axes: Any) -> None:
        for sense in (1.0, -1.0):
            draw_normal(axes, -1.3 * sense * RIGHT, sense, 6.5, FORCE["color"])

    return Glyph(draw)


def turn_glyph() -> Glyph:
    """A round arrow, for a key."""
    return Glyph(lambda axes: draw_turn(axes, -0.5 * RIGHT[::-1], -1.0, TORQUE))


def torque_glyph() -> Glyph:
    """An arrow with two heads, one behind the other, for a key."""
    return Glyph(lambda axes: draw_arrow(axes, -2.4 * RIGHT, 4.8 * RIGHT, TORQUE, 2))


def axis_glyph(*, polar: bool) -> Glyph:
    """A squirmer with its axis, for a key."""

    def draw(axes: Any) -> None:
        draw_sphere(axes, ORIGIN, INK)
        draw_axis(axes, ORIGIN, RIGHT, polar=polar)

    return Glyph(draw, 5.0)


def write_arrow_key(axes: Any, entries: Sequence[tuple[str, Glyph]], columns: int = 3) -> None:
    """Write a key below axes, an entry a kind of arrow."""
    owner, place = key_place(axes)
    write_glyphs(owner, entries, columns, **place)
