"""Which figures there are, and how they are drawn and saved."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Literal, get_args

from nrchain.errors import SceneError
from nrchain.figures.sheet import FULL, Detail, Sheet, Width
from nrchain.view.drawing import check_picture, save

Number = Literal["1", "3", "4", "5", "6", "7"]
NUMBERS: tuple[Number, ...] = get_args(Number)
"""The figures of the paper that are drawn; the second sketches what a Cosserat rod is."""

Format = Literal["pdf", "svg", "png"]


def draw_figure(
    number: str | int, *, width: Width = "two", title: bool = False, detail: Detail = FULL
) -> Sheet:
    """Draw a figure of the paper: its matplotlib figure, and what it was checked against.

    Parameters
    ----------
    number
        1, 3, 4, 5, 6 or 7.
    width
        ``"one"`` or ``"two"`` columns.
    title
        Write a title.
    detail
        How much is computed.

    Raises :class:`~nrchain.errors.SceneError` for another number or width.

    >>> import nrchain
    >>> sheet = nrchain.draw_figure(3, width="one")
    >>> sheet.remarks[0]
    '2s: entries are in units of 0.0467 γ_T V'
    """
    name = str(number)
    if name not in NUMBERS:
        raise SceneError("figure", number, f"must be one of {', '.join(NUMBERS)}")
    if width not in get_args(Width):
        raise SceneError("width", width, f"must be one of {', '.join(get_args(Width))}")
    module = importlib.import_module(f"nrchain.figures.figure_{name}")
    sheet: Sheet = module.draw(width, detail, title)
    return sheet


def file_name(number: str, kind: str) -> str:
    """The name of the file of a figure."""
    return f"figure-{number}.{kind}"


def save_figure(
    number: str | int,
    path: str | Path,
    *,
    width: Width = "two",
    title: bool = False,
    detail: Detail = FULL,
) -> Sheet:
    """Draw a figure of the paper and write it; the ending of ``path`` chooses PNG, PDF or SVG.

    An existing file is replaced. Raises errors as :func:`draw_figure`, and
    :class:`~nrchain.errors.TrajectoryError` for a file that cannot be written.

    >>> import nrchain
    >>> sheet = nrchain.save_figure(3, "figure-3.pdf", width="one")
    >>> float(sheet.figure.get_figwidth())
    3.375
    """
    path = check_picture(path)
    sheet = draw_figure(number, width=width, title=title, detail=detail)
    save(sheet.figure, path)
    return sheet
