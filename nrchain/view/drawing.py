"""Figures for files: independent of matplotlib's settings, and without a change to them.

The settings, ``rcParams``, belong to the process: a figure that changes them changes what other
threads draw. So every part of a figure gets its look by name. Nothing uses pyplot or a backend of
the screen. Only the fonts are those of the settings.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.errors import SceneError, TrajectoryError
from nrchain.trajectory.file import file_errors
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.style import PAPER, WIDTHS

FORMATS = (".png", ".pdf", ".svg")

DOTS_PER_INCH = 300

COMPRESSION = 3
"""Level of compression of PNG files: faster than the usual 6, for files an eighth larger."""

UNKNOWN = "□"
"""Replaces a letter that no font has."""


def check_drawable(trajectory: Trajectory, path: str | Path) -> Path:
    """The path of a picture of a trajectory, with matplotlib ready to draw it.

    Raises errors as :func:`check_picture`, and :class:`~nrchain.errors.TrajectoryError` for a
    trajectory without snapshots.
    """
    path = check_picture(path)
    check_snapshots(trajectory)
    return path


def check_snapshots(trajectory: Trajectory) -> None:
    """Raise :class:`~nrchain.errors.TrajectoryError` for a trajectory without snapshots."""
    if not len(trajectory.time):
        running = trajectory.status == "running"
        why = ": its run has just begun, or was killed at once" if running else ""
        raise TrajectoryError(f"the trajectory has no finished snapshot to draw{why}")


def as_axes(axes: Any, *, height: float = 2.4, projection: str | None = None) -> Any:
    """The axes given, or those of a new figure, one column wide and ``height`` inches high.

    Raises :class:`~nrchain.errors.SceneError` for anything else than axes, such as a path.
    """
    if axes is None:
        figure = new_figure(WIDTHS["one"], height, "constrained")
        return figure.add_subplot(projection=projection)
    require_axes(axes)
    return axes


def require_axes(axes: Any) -> None:
    """Raise :class:`~nrchain.errors.SceneError` for anything else than axes of matplotlib."""
    if not hasattr(axes, "_axis_names"):
        allowed = "must be axes of matplotlib; a function save_… writes a file"
        raise SceneError("axes", str(axes), allowed)


def check_picture(path: str | Path) -> Path:
    """The path of a picture, with matplotlib ready to draw it.

    Raises :class:`~nrchain.errors.SceneError` for a path with another ending than :data:`FORMATS`.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise SceneError("picture", str(path), f"must end in one of {', '.join(FORMATS)}")
    require_matplotlib()
    return path


def pick_evenly(count: int, most: int) -> np.ndarray:
    """At most ``most`` of the indices 0 … ``count`` − 1, evenly spaced, from the first to the last.

    >>> pick_evenly(10, 4), pick_evenly(3, 4)
    (array([0, 3, 6, 9]), array([0, 1, 2]))
    """
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def require_matplotlib() -> None:
    """Import matplotlib; raise :class:`~nrchain.errors.SceneError` for a bad MPLBACKEND.

    A notebook sets this variable for the programs it starts. The import of matplotlib fails if the
    variable names an unknown backend.
    """
    try:
        import matplotlib  # noqa: F401
    except ValueError as error:
        given = os.environ.get("MPLBACKEND")
        if given is None:
            raise
        allowed = "is not a backend of matplotlib; unset this variable, or set MPLBACKEND=agg"
        raise SceneError("MPLBACKEND", given, allowed) from error


def new_figure(width: float, height: float, layout: Any = "none") -> Any:
    """A white figure, with its width and height in inches and the canvas of a file."""
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


def letters(text: str) -> str:
    """Text for matplotlib: no mathematics, and :data:`UNKNOWN` for letters that the fonts lack."""
    from matplotlib.font_manager import FontProperties, findfont, get_font

    families = FontProperties().get_family()
    known = {
        code
        for family in families
        for code in get_font(findfont(FontProperties(family=[family]))).get_charmap()
    }
    shown = "".join(letter if ord(letter) in known else UNKNOWN for letter in text)
    return shown.replace("$", r"\$")


def save(figure: Any, path: Path, crop: Any = None) -> None:
    """Write the figure to a file.

    ``crop`` is the box to write, in inches: None for the whole figure, ``"tight"`` for all ink.

    Raises :class:`~nrchain.errors.TrajectoryError` where the file cannot be written.
    """
    from matplotlib.transforms import Bbox

    settle(figure)
    box = Bbox.from_bounds(0, 0, *figure.get_size_inches()) if crop is None else crop
    ending = path.suffix[1:].lower()
    options = {"pil_kwargs": {"compress_level": COMPRESSION}} if ending == "png" else {}
    with file_errors(path, "cannot be drawn"):
        figure.savefig(
            path,
            format=ending,
            dpi=DOTS_PER_INCH,
            facecolor=PAPER,
            edgecolor=PAPER,
            transparent=False,
            bbox_inches=box,
            pad_inches=0.1,
            **options,
        )


def settle(figure: Any) -> None:
    """Switch off TeX, sketching and path effects in every part of a figure.

    Call it before measuring any part; :func:`save` calls it too.
    """
    from matplotlib.text import Text

    for axes in figure.axes:
        for name in axes._axis_names:
            # creates the first ticks, from which all others copy their look
            axis = getattr(axes, f"{name}axis")
            axis.get_major_ticks(1)
            axis.get_minor_ticks(1)
    for part in figure.findobj():
        part.set_sketch_params(None)
        part.set_path_effects([])
        if isinstance(part, Text):
            part.set_usetex(False)
            part.set_parse_math(True)
            part.set_math_fontfamily("cm")
