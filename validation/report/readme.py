"""The part of the README that says what the studies found, made from a report.

What stands between two marks of the README is written anew: a row a study, what all pairs change,
what runs cost beside their rivals, the bars that are not met, and two figures, whose files are
copied beside the pictures of the README.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from validation.report.build import RESULTS, ReportError
from validation.report.page import number
from validation.report.studies import STUDIES

BEGIN, END = "<!-- made by python -m validation --readme -->", "<!-- end of what is made -->"
IMAGES = Path("validation") / "images"

FIGURES = (
    (
        "continuum",
        "dispersion",
        "Growth rates and phase velocities from simulation, the exact lattice and the continuum",
    ),
    ("cost", "Stepping", "Error against wall time of the integrators, scene by scene"),
)
"""Study and name of the figures shown, and what they show."""

TABLE = "What all pairs change"
REACH_COLUMNS = 4
"""Columns of that table that are shown: the wave, its limit, the sum and the lattice."""

REVEALING = (
    "all pairs, slip, four modes, one thread",
    "all pairs, slip, 2s alone, one thread",
    "all pairs, friction, one thread",
    "near run against the recipe",
    "near run against SciPy's BDF with our compiled right-hand side",
    "long-range run against the recipe",
    "long-range run against nearest neighbours",
    "nrchain run buckling, warm against cold",
)
"""Benchmarks that are shown."""


def update(readme: Path, report: Path) -> None:
    """Write the made part of ``readme`` from the report in the folder ``report``.

    Raises :class:`ReportError`, before anything is written, where there is no report of full runs
    of all studies, a figure is missing, or the README has not the two marks.
    """
    results = _results(report)
    text = readme.read_text(encoding="utf-8")
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ReportError(f"{readme}: has not the two lines {BEGIN} and {END}")
    files = {_file(results, study, name): caption for study, name, caption in FIGURES}
    for file in files:
        if not (report / file).exists():
            raise ReportError(f"{report / file}: no such figure")
    (readme.parent / IMAGES).mkdir(parents=True, exist_ok=True)
    for file in files:
        shutil.copyfile(report / file, readme.parent / IMAGES / Path(file).name)
    pictures = [f"![{caption}]({IMAGES / Path(file).name})" for file, caption in files.items()]
    made = "\n\n".join(filter(None, [summary(results), *pictures]))
    readme.write_text(f"{before}{BEGIN}\n\n{made}\n\n{END}{after}", encoding="utf-8")


def summary(results: dict[str, Any]) -> str:
    """The tables, in Markdown."""
    return "\n\n".join(
        filter(None, (_studies(results), _reach(results), _costs(results), _shortfalls(results)))
    )


def _results(report: Path) -> dict[str, Any]:
    try:
        results = json.loads((report / RESULTS).read_text(encoding="utf-8"))
        full = {study["study"] for study in results["studies"] if not study["quick"]}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ReportError(f"{report / RESULTS}: not a report of these studies ({error})") from None
    if missing := [name for name in STUDIES if name not in full]:
        raise ReportError(f"{report / RESULTS}: no full run of {', '.join(missing)}")
    return results


def _file(results: dict[str, Any], study: str, name: str) -> str:
    figures = next(s["figures"] for s in results["studies"] if s["study"] == study)
    found = [figure["file"] for figure in figures if figure["name"] == name]
    if not found:
        raise ReportError(f"study {study} has no figure {name!r}")
    return found[0]


def _studies(results: dict[str, Any]) -> str:
    rows = [
        (s["title"], f"{s['passed']} of {s['passed'] + s['failed']}", f"{s['seconds']:.0f} s")
        for s in results["studies"]
    ]
    return _grid(("Study", "Checks that hold", "Time"), rows)


def _reach(results: dict[str, Any]) -> str:
    tables = [table for table in results["tables"] if table["name"] == TABLE]
    if not tables:
        return ""
    columns = tables[0]["columns"][:REACH_COLUMNS]
    rows = [[number(cell) for cell in row[:REACH_COLUMNS]] for row in tables[0]["rows"]]
    text = "The active rate with all pairs over that with nearest neighbours, by kind of wave:"
    return f"{text}\n\n{_grid(columns, rows)}"


def _costs(results: dict[str, Any]) -> str:
    rows = [
        (b["name"], _seconds(b["ours"]), _seconds(b["theirs"]), f"{b['ratio']:.3g}")
        for name in REVEALING
        for b in results["benchmarks"]
        if b["name"] == name
    ]
    text = "What it costs, side by side in one run (medians):"
    return f"{text}\n\n{_grid(('Task', 'Ours', 'Theirs', 'Ratio'), rows)}" if rows else ""


def _shortfalls(results: dict[str, Any]) -> str:
    rows = [
        (check["name"], f"{check['measured']:.3g}", check["source"])
        for check in results["checks"]
        if check["kind"] == "shortfall"
    ]
    text = "Bars the project sets itself that are not met:"
    return f"{text}\n\n{_grid(('Bar', 'Measured', 'Why'), rows)}" if rows else ""


def _seconds(value: float) -> str:
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"


def _grid(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(
        "| " + " | ".join(str(c).replace("|", "\\|") for c in row) + " |" for row in lines
    )
