"""Figures for files, which matplotlib's settings neither break nor are changed by.

The settings, ``rcParams``, belong to the process: a figure that changes them for a while changes
what other threads draw. What a figure needs is therefore named on its parts, and nothing is drawn
through pyplot or a backend of the screen. Fonts are those of the settings.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from nrchain.errors import SceneError
from nrchain.trajectory.file import refusing

FORMATS = (".png", ".pdf", ".svg")

INK, PALE, GRID, PAPER = "0.15", "0.4", "0.92", "white"
TEXT, LABEL, TITLE = 8.5, 9.5, 11.0
"""Sizes of letters, in points."""

LINE: dict[str, Any] = {
    "linestyle": "-",
    "solid_capstyle": "projecting",
    "dash_capstyle": "butt",
    "marker": "",
    "markerfacecolor": "auto",
    "markeredgecolor": "auto",
    "markeredgewidth": 0.0,
}
"""What a line is drawn with unless it says otherwise."""

DOTS_PER_INCH = 200

UNKNOWN = "□"
"""Stands for a letter that no font has."""


def picture_path(path: str | Path) -> Path:
    """The path of a picture; :class:`~nrchain.errors.SceneError` for an ending of none."""
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise SceneError("picture", str(path), f"must end in one of {', '.join(FORMATS)}")
    return path


def require_matplotlib() -> None:
    """Import matplotlib, or refuse an MPLBACKEND with which it cannot be imported.

    Its import fails where the variable, as set by a notebook for what it starts, names a backend
    that is not installed.
    """
    try:
        import matplotlib  # noqa: F401
    except ValueError as error:
        given = os.environ.get("MPLBACKEND")
        if given is None:
            raise
        allowed = "is no backend that matplotlib finds here; start Python without this variable"
        raise SceneError("MPLBACKEND", given, f"{allowed}, or with MPLBACKEND=agg") from error


def new_figure(width: float, height: float, layout: Any = "none") -> Any:
    """A white figure of so many inches, with the canvas of a file."""
    require_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(
        figsize=(width, height),
        dpi=100,
        facecolor=PAPER,
        edgecolor=PAPER,
        linewidth=0.0,
        frameon=True,
        layout=layout,
    )
    FigureCanvasAgg(figure)
    return figure


def style(axes: Any) -> None:
    """The look of axes: a pale frame and grid, small ticks outside, dark letters."""
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
            pad=3.5,
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
        axis.labelpad = 4.0
        _style_grid(axes, axis)

    sides = {"bottom": True, "top": False, "left": True, "right": False}
    labels = {f"label{side}": shown for side, shown in sides.items()}
    if len(axes._axis_names) == 2:
        axes.tick_params(which="both", **sides, **labels)


def _style_grid(axes: Any, axis: Any) -> None:
    look = {"color": GRID, "linewidth": 0.5, "linestyle": "-"}
    if hasattr(axis, "set_pane_color"):
        # axes in space draw their grid from this table, and ask the settings for it otherwise
        axis._axinfo["grid"].update(look)
        axis._axinfo["tick"]["linewidth"] = {True: 0.6, False: 0.6}
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set(color=PALE, linewidth=0.6)
        axes.grid(True)
    else:
        axis.grid(True, which="major", alpha=1.0, **look)


def write_title(axes: Any, text: str, pad: float = 6.0) -> None:
    """A title above axes, in the size of labels."""
    look = {"fontsize": LABEL, "fontweight": "normal", "color": INK}
    axes.set_title(text, loc="center", pad=pad, y=1.0, **look)


def letters(text: str) -> str:
    """Plain text, with :data:`UNKNOWN` for what the fonts lack: matplotlib would warn of it."""
    from matplotlib.font_manager import FontProperties, findfont, get_font

    families = FontProperties().get_family()
    known = {
        code
        for family in families
        for code in get_font(findfont(FontProperties(family=[family]))).get_charmap()
    }
    # a dollar sign would begin mathematics
    shown = "".join(letter if ord(letter) in known else UNKNOWN for letter in text)
    return shown.replace("$", r"\$")


def save(figure: Any, path: Path, crop: Any = None) -> None:
    """Write the figure, or the box of inches ``crop`` of it; ``"tight"``: as much as is drawn.

    Raises :class:`~nrchain.errors.TrajectoryError` where the file cannot be written.
    """
    from matplotlib.transforms import Bbox

    settle(figure)
    box = Bbox.from_bounds(0, 0, *figure.get_size_inches()) if crop is None else crop
    with refusing(path, "cannot be drawn"):
        figure.savefig(
            path,
            format=path.suffix[1:].lower(),
            dpi=DOTS_PER_INCH,
            facecolor=PAPER,
            edgecolor=PAPER,
            transparent=False,
            bbox_inches=box,
            pad_inches=0.1,
        )


def settle(figure: Any) -> None:
    """Letters by matplotlib itself, not by TeX, and no sketching, in every part of a figure.

    To be called before anything is measured, and by :func:`save`.
    """
    from matplotlib.text import Text

    for axes in figure.axes:
        for name in axes._axis_names:
            # makes the first tick, from which all others take their look
            getattr(axes, f"{name}axis").get_ticklabels(which="both")
    for part in figure.findobj():
        part.set(sketch_params=None, path_effects=[])
        if isinstance(part, Text):
            part.set(usetex=False, parse_math=True, math_fontfamily="cm")
