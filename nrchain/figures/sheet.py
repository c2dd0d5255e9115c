"""What a figure is made from: its width, how much it computes, and what it says of itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from nrchain.view.drawing import new_figure
from nrchain.view.style import INK, TITLE, WIDTHS

Width = Literal["one", "two"]


@dataclass(frozen=True)
class Detail:
    """How much a figure computes; smaller numbers give a coarser picture sooner.

    Attributes
    ----------
    points
        Along each side of a flow field.
    lengths
        N of the periodic chains whose waves are measured.
    strengths
        How many strengths of slip, from the largest.
    changes
        Keys of the scenes whose runs are shown.
    """

    points: int = 141
    lengths: tuple[int, ...] = (16, 20, 28, 40, 64)
    strengths: int = 4
    changes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Sheet:
    """A drawn figure, and lines that say what it was checked against."""

    figure: Any
    remarks: tuple[str, ...] = ()


def new_sheet(width: Width, height: float, title: str = "") -> Any:
    """A figure of one or two columns, ``height`` inches high, with a title above it if given."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    room = ConstrainedLayoutEngine(h_pad=0.04, w_pad=0.04, hspace=0.03, wspace=0.03)
    figure = new_figure(WIDTHS[width], height, room)
    if title:
        figure.suptitle(title, fontsize=TITLE, fontweight="bold", color=INK)
    return figure


LABELS = 0.34
"""Inches below axes that their labels take."""


def below(axes: Any) -> dict[str, Any]:
    """The place of a key below axes and their labels."""
    from matplotlib.transforms import ScaledTranslation

    down = ScaledTranslation(0.0, -LABELS, axes.figure.dpi_scale_trans)
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0), "borderaxespad": 0.0}
    return place | {"bbox_transform": axes.transAxes + down}


def key_place(axes: Any) -> tuple[Any, dict[str, Any]]:
    """What a key belongs to, and its place: below axes, or below a part of a figure."""
    from matplotlib.figure import SubFigure

    if isinstance(axes.figure, SubFigure):
        return axes.figure, {"loc": "outside lower center"}
    return axes, below(axes)


def is_above(axes: Any, other: Any) -> bool:
    """Whether axes stand above others of their grid, and not beside them."""
    columns = [each.get_subplotspec().colspan for each in (axes, other)]
    return bool(columns[0] == columns[1])


FULL = Detail()
"""What ``nrchain figure`` draws."""
