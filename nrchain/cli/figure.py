"""``nrchain figure``: draw the figures of the paper."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from nrchain.cli.arguments import Json, Quiet, Style
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.summary import check_absent

FOLDER = Path("figures")


class Figure(StrEnum):
    """The figures, as the command line names them."""

    one = "1"
    three = "3"
    four = "4"
    five = "5"
    six = "6"
    seven = "7"
    all = "all"


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
    "nrchain figure all -o paper --width one --format svg",
)
@one_line_errors()
def figure(
    number: Annotated[
        Figure, typer.Argument(help="Number of a figure, or all.", show_default=False)
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
    """Draw a figure of the paper from the package's own flows, moduli, waves and runs."""
    from nrchain.figures.catalogue import NUMBERS, file_name, save_figure
    from nrchain.trajectory.file import file_errors
    from nrchain.view.drawing import require_matplotlib

    style = Style.of(as_json=as_json, quiet=quiet)
    require_matplotlib()
    numbers = NUMBERS if number is Figure.all else (number.value,)
    paths = [output / file_name(one, kind.value) for one in numbers]
    for path in paths:
        if not overwrite:
            check_absent(path)
    with file_errors(output, "cannot be drawn"):
        output.mkdir(parents=True, exist_ok=True)
    records = []
    for one, path in zip(numbers, paths, strict=True):
        sheet = save_figure(one, path, width=width.value, title=title)
        records.append({"number": one, "picture": path, "remarks": sheet.remarks})
        if style.is_text:
            show(str(path), soft_wrap=True)
            for remark in sheet.remarks:
                show(f"  {remark}", soft_wrap=True)
    if style is Style.JSON:
        show_json({"figures": records})
