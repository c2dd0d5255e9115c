"""The look of all pictures: widths of print, letters of 8 points, colours, dashes and markers.

Every colour of a line or a marker has a contrast of at least 3 with white, and all of them differ
for each kind of colour blindness. Dashes and markers change with the colour, so that a picture is
read in grey too. The functions style parts of a figure one by one: no setting of matplotlib
changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

WIDTHS = {"one": 3.375, "two": 7.0}
"""Inches: the widths of one and of two columns of a journal."""

TEXT, LABEL, TITLE = 8.0, 8.0, 9.0
"""Font sizes, in points."""

INK, PALE, GRID, PAPER = "0.15", "0.4", "0.92", "white"
"""Colours of letters and sums, of frames and remarks, of the grid, and of the background."""

COLOURS = ("#332288", "#ee6677", "#b8860b", "#3a86c8", "#aa3377", "#7a4b00")
"""Of lines and markers, in turn. The first two differ most in lightness."""

DASHES: tuple[Any, ...] = (
    "-",
    (0, (4, 1.5)),
    (0, (1.2, 1.2)),
    (0, (6, 1.5, 1.2, 1.5)),
    (0, (8, 2)),
)
"""Of lines, in turn; with :data:`COLOURS`, 30 lines differ."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X")
"""In turn."""

WIDTH, MARKER = 1.2, 3.5
"""The width of a line and the size of a marker, in points."""

LEAST_CONTRAST = 3.0
"""Of a line or a marker with white."""

LINE: dict[str, Any] = {
    "linestyle": "-",
    "linewidth": WIDTH,
    "solid_capstyle": "projecting",
    "dash_capstyle": "butt",
    "marker": "",
    "markersize": MARKER,
    "markerfacecolor": "auto",
    "markeredgecolor": "auto",
    "markeredgewidth": 0.0,
}
"""The default look of a line."""

TIMES, EARLY, LATE = "inferno", 0.66, 0.08
"""The colour map of times, and its part from the first time to the last: light to dark."""

SIZES = "Greys"
"""The colour map of a magnitude that fills an area behind lines."""


def contrast(colour: Any) -> float:
    """(1 + 0.05)/(L + 0.05): the contrast of a colour with white, L being its luminance.

    From 1, of white, to 21, of black: Web Content Accessibility Guidelines 2.2, "contrast ratio".

    >>> round(contrast("black"), 6), round(contrast("white"), 6)
    (21.0, 1.0)
    """
    from matplotlib.colors import to_rgb

    given = np.array(to_rgb(colour))
    linear = np.where(given <= 0.04045, given / 12.92, ((given + 0.055) / 1.055) ** 2.4)
    return float(1.05 / (np.dot([0.2126, 0.7152, 0.0722], linear) + 0.05))


def line_look(number: int, *, marker: bool = False, solid: bool = False) -> dict[str, Any]:
    """Colour, dashes and, if asked for, marker of line ``number``; ``solid`` leaves dashes out.

    >>> line_look(1)["color"], line_look(7)["color"], line_look(1, marker=True)["marker"]
    ('#ee6677', '#ee6677', 's')
    """
    look = LINE | {"color": COLOURS[number % len(COLOURS)]}
    if not solid:
        look["linestyle"] = DASHES[number % len(DASHES)]
    if marker:
        look["marker"] = MARKERS[number % len(MARKERS)]
    return look


def marker_look(number: int, *, hollow: bool = False) -> dict[str, Any]:
    """Colour and marker of points ``number``, without a line; ``hollow`` ones are white inside."""
    look = line_look(number, marker=True) | {"linestyle": "", "markeredgewidth": 0.8}
    return look | {"markerfacecolor": PAPER} if hollow else look


def time_colours(count: int) -> np.ndarray:
    """Colours ``(count, 4)`` from light to dark: the last state stands out."""
    from matplotlib import colormaps

    return colormaps[TIMES](np.linspace(EARLY, LATE, count) if count > 1 else [LATE])


def style_axes(axes: Any) -> None:
    """Style axes: a pale frame and grid, small ticks outside, dark letters."""
    from matplotlib.ticker import MaxNLocator, NullLocator, ScalarFormatter

    axes.set_facecolor(PAPER)
    axes.patch.set(edgecolor=PAPER, linewidth=0.0)
    axes.set_axisbelow(True)
    for spine in axes.spines.values():
        spine.set(visible=True, color=PALE, linewidth=0.6)
    for name in axes._axis_names:
        axis = getattr(axes, f"{name}axis")
        axis.set_tick_params(
            which="both",
            direction="out",
            length=2.5,
            width=0.6,
            pad=3.0,
            color=PALE,
            labelcolor=INK,
            labelsize=TEXT,
        )
        axis.set_minor_locator(NullLocator())
        axis.set_major_locator(MaxNLocator(9, steps=[1, 2, 2.5, 5, 10]))
        formatter = ScalarFormatter(useOffset=False, useMathText=False, useLocale=False)
        formatter.set_powerlimits((-5, 6))
        axis.set_major_formatter(formatter)
        axis.label.set(size=LABEL, color=INK, weight="normal")
        axis.labelpad = 3.0
        _style_grid(axes, axis)

    sides = {"bottom": True, "top": False, "left": True, "right": False}
    labels = {f"label{side}": shown for side, shown in sides.items()}
    if len(axes._axis_names) == 2:
        axes.tick_params(which="both", **sides, **labels)


def _style_grid(axes: Any, axis: Any) -> None:
    look = {"color": GRID, "linewidth": 0.5, "linestyle": "-"}
    if hasattr(axis, "set_pane_color"):
        # three-dimensional axes read the look of their grid here, or else from the settings
        axis._axinfo["grid"].update(look)
        axis._axinfo["tick"]["linewidth"] = {True: 0.6, False: 0.6}
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set(color=PALE, linewidth=0.6)
        axes.grid(True)
    else:
        axis.grid(True, which="major", alpha=1.0, **look)


def write_title(axes: Any, text: str, pad: float = 6.0, slant: str = "normal") -> None:
    """Write a title above axes, in the size of labels."""
    look = {"fontsize": LABEL, "fontweight": "normal", "fontstyle": slant, "color": INK}
    axes.set_title(text, loc="center", pad=pad, y=1.0, **look)


def write_letter(axes: Any, letter: str) -> None:
    """Write the letter of a panel, as (a), above its upper left corner."""
    look = {"fontsize": LABEL, "fontweight": "bold", "fontstyle": "normal", "color": INK}
    axes.set_title(f"({letter})", loc="left", pad=4.0, y=1.0, **look)


def write_key(figure: Any, lines: Mapping[str, Any], columns: int, *, ink: bool = True) -> None:
    """Write a key of lines and marks below a figure, in the colour of letters if ``ink``."""
    figure.legend(
        lines.values(),
        lines.keys(),
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        fontsize=TEXT,
        labelcolor=INK,
    )
    if ink:
        for line in figure.legends[0].get_lines():
            line.set(color=INK, markeredgecolor=INK)
