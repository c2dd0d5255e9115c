"""``nrchain figure``: draw the figures of the paper."""

from __future__ import annotations

import re
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from nrchain.cli.arguments import Json, Quiet, Style
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.summary import check_absent
from nrchain.errors import SceneError

FOLDER = Path("figures")

FIGURES, ALL = ("1", "3", "4", "5", "6", "7"), "all"
"""The figures, as the command line names them."""


class Columns(StrEnum):
    """The widths of print."""

    one = "one"
    two = "two"


class Format(StrEnum):
    """The formats of files."""

    pdf = "pdf"
    svg = "svg"
    png = "png"


@examples(
    "nrchain figure 4",
    "nrchain figure 1,3-5",
    "nrchain figure all -o paper --width one --format svg",
)
@one_line_errors()
def figure(
    numbers: Annotated[
        list[str],
        typer.Argument(
            metavar="NUMBER",
            help="Numbers of figures, such as 4, 1,4 or 3-5; or all.",
            show_default=False,
            autocompletion=lambda: [*FIGURES, ALL],
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder to write to.")] = FOLDER,
    width: Annotated[
        Columns, typer.Option(help="Columns of a journal: 3.375 or 7 inches.")
    ] = Columns.two,
    kind: Annotated[Format, typer.Option("--format", help="Format of the files.")] = Format.pdf,
    title: Annotated[bool, typer.Option("--title", help="Write a title.")] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace files that exist.")
    ] = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Draw figures of the paper from the package's own flows, moduli, waves and runs."""
    from nrchain.figures.catalogue import file_name, save_figure
    from nrchain.trajectory.file import file_errors
    from nrchain.view.drawing import require_matplotlib

    style = Style.of(as_json=as_json, quiet=quiet)
    chosen = chosen_figures(numbers)
    require_matplotlib()
    paths = [output / file_name(one, kind.value) for one in chosen]
    for path in paths:
        if not overwrite:
            check_absent(path)
    with file_errors(output, "cannot be drawn"):
        output.mkdir(parents=True, exist_ok=True)
    records = []
    for one, path in zip(chosen, paths, strict=True):
        sheet = save_figure(one, path, width=width.value, title=title)
        records.append({"number": one, "picture": path, "remarks": sheet.remarks})
        if style.is_text:
            show(str(path), soft_wrap=True)
            for remark in sheet.remarks:
                show(f"  {remark}", soft_wrap=True)
    if style is Style.JSON:
        show_json({"figures": records})


def chosen_figures(given: list[str]) -> list[str]:
    """The figures that numbers, ranges and lists of both name, each once and in order.

    Raises :class:`~nrchain.errors.SceneError` for other words.

    >>> chosen_figures(["1,4"]), chosen_figures(["7", "3-5"]), chosen_figures(["1,3,4...7"])
    (['1', '4'], ['3', '4', '5', '7'], ['1', '3', '4', '5', '6', '7'])
    """
    found: set[str] = set()
    for part in (part.strip() for word in given for part in word.split(",")):
        first, *last = re.split(r"-|\.{2,3}|…", part)
        ends = (first, *last) if last else (first, first)
        if part == ALL:
            found.update(FIGURES)
        elif len(ends) == 2 and all(end in FIGURES for end in ends) and ends[0] <= ends[1]:
            found.update(one for one in FIGURES if ends[0] <= one <= ends[1])
        else:
            allowed = f"must be {', '.join(FIGURES)}, a range such as 3-5, or {ALL}"
            raise SceneError("figure", part, allowed)
    return [one for one in FIGURES if one in found]
