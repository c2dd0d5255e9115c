"""Draw branches of cycles: amplitude and period against the key along which they run.

Stable parts are solid, unstable ones dashed. Special points are marked.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nrchain.errors import SceneError
from nrchain.states.cycles.continuation import CycleDiagram
from nrchain.view.branch_plots import draw_line, save_panels
from nrchain.view.drawing import as_axes, check_picture
from nrchain.view.units import Kind, words

QUANTITIES: dict[str, tuple[str, Kind]] = {
    "amplitudes": ("largest excursion", "length"),
    "periods": ("period T", "time"),
}
"""What is drawn of cycles: its name on an axis, and its unit."""


def draw_cycles(
    found: CycleDiagram, axes: Any = None, *, quantity: str = "amplitudes", key: bool = True
) -> Any:
    """Draw a quantity of all branches on axes, and return the axes.

    Parameters
    ----------
    axes
        Of matplotlib; without, those of a new figure, one column wide.
    quantity
        ``"amplitudes"`` or ``"periods"``, in units of the scene.
    key
        Write the key of lines and marks into the axes.

    Raises :class:`~nrchain.errors.SceneError` for another quantity.
    """
    if quantity not in QUANTITIES:
        raise SceneError("quantity", quantity, f"must be one of {', '.join(QUANTITIES)}")
    axes = as_axes(axes)
    values = [getattr(branch, quantity) for branch in found.branches]
    return draw_line(axes, found.line, found.branches, values, _name(found, quantity), key)


def save_cycles(found: CycleDiagram, path: str | Path, *, title: bool = True) -> Path:
    """Draw all branches, and return the path, whose ending chooses PNG, PDF or SVG.

    An existing file is replaced. ``title`` writes that of the scene.

    Raises :class:`~nrchain.errors.SceneError` for another ending, and
    :class:`~nrchain.errors.TrajectoryError` for a file that cannot be written.
    """
    path = check_picture(path)
    values = [[getattr(branch, name) for branch in found.branches] for name in QUANTITIES]
    names = [_name(found, name) for name in QUANTITIES]
    return save_panels(found.line, found.branches, values, names, path, title)


def _name(found: CycleDiagram, quantity: str) -> str:
    text, kind = QUANTITIES[quantity]
    return words(text, found.line.scene, kind)
