"""The results of the studies in the README and in docs/validation.md, from a report.

Each of the two pages has a part between two marks, which is written anew. The README gets one row a
study and two figures, whose files are copied to ``validation/images``. The page on validation gets
the effect of all pairs, the speed beside that of other codes, and the targets that are not met.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from validation.report.build import RESULTS, ReportError
from validation.report.page import number
from validation.report.studies import STUDIES

BEGIN, END = "<!-- made by python -m validation --readme -->", "<!-- end of what is made -->"
README, DETAILS = Path("README.md"), Path("docs") / "validation.md"
IMAGES = Path("validation") / "images"

FIGURES = (
    (
        "continuum",
        "dispersion",
        "Growth rates and phase velocities from simulation, the exact lattice and the continuum",
    ),
    (
        "states",
        "state-branches",
        "Pushers buckle, and with 3t they straighten and then go round: branches of states",
    ),
    (
        "states",
        "phases-2s-3t",
        "What a clamped chain of pushers with 3t ends in, over both strengths",
    ),
    ("cost", "Stepping", "Error against run time of the integrators, scene by scene"),
)
"""Study, name and caption of each figure in the README."""

REACH_TABLE = "What all pairs change"
REACH_COLUMNS = 4
"""Columns of that table to show: the wave, its limit, the sum and the lattice."""

BENCHMARKS = (
    "all pairs, slip, four modes, one thread",
    "all pairs, slip, 2s alone, one thread",
    "all pairs, friction, one thread",
    "near run against the recipe",
    "near run against SciPy's BDF with our compiled right-hand side",
    "long-range run against the recipe",
    "long-range run against nearest neighbours",
    "nrchain run buckling, warm against cold",
)
"""Benchmarks to show."""

Results = dict[str, Any]


def update(root: Path, report: Path) -> None:
    """Write the results of ``report`` into the two pages below the folder ``root``.

    Raises :class:`ReportError`, before anything is written, if the report lacks a full run of a
    study or a figure, or a page lacks its two marks.
    """
    results = _read(report)
    files = {_file(results, study, name): caption for study, name, caption in FIGURES}
    for file in files:
        if not (report / file).exists():
            raise ReportError(f"{report / file}: no such figure")
    pictures = [f"![{caption}]({IMAGES / Path(file).name})" for file, caption in files.items()]
    summary = "\n\n".join([_studies(results), *pictures])
    texts = {
        path: _replace(path, made)
        for path, made in ((root / README, summary), (root / DETAILS, _details(results)))
    }
    (root / IMAGES).mkdir(parents=True, exist_ok=True)
    for file in files:
        shutil.copyfile(report / file, root / IMAGES / Path(file).name)
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")


def _replace(page: Path, made: str) -> str:
    """The text of a page with ``made`` between its marks."""
    before, begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ReportError(f"{page}: must have the two lines {BEGIN} and {END}")
    return f"{before}{BEGIN}\n\n{made}\n\n{END}{after}"


def _details(results: Results) -> str:
    parts: tuple[Callable[[Results], str], ...] = (_reach, _benchmarks, _shortfalls)
    return "\n\n".join(filter(None, (part(results) for part in parts)))


def _read(report: Path) -> Results:
    try:
        results = json.loads((report / RESULTS).read_text(encoding="utf-8"))
        full = {study["study"] for study in results["studies"] if not study["quick"]}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ReportError(f"{report / RESULTS}: not a report of these studies ({error})") from None
    if missing := [name for name in STUDIES if name not in full]:
        raise ReportError(f"{report / RESULTS}: no full run of {', '.join(missing)}")
    return results


def _file(results: Results, study: str, name: str) -> str:
    figures = next(s["figures"] for s in results["studies"] if s["study"] == study)
    found = [figure["file"] for figure in figures if figure["name"] == name]
    if not found:
        raise ReportError(f"study {study} has no figure {name!r}")
    return found[0]


def _studies(results: Results) -> str:
    rows = [
        (s["title"], f"{s['passed']} of {s['passed'] + s['failed']}", f"{s['seconds']:.0f} s")
        for s in results["studies"]
    ]
    return _grid(("Study", "Checks that hold", "Time"), rows)


def _reach(results: Results) -> str:
    tables = [table for table in results["tables"] if table["name"] == REACH_TABLE]
    if not tables:
        return ""
    columns = tables[0]["columns"][:REACH_COLUMNS]
    rows = [[number(cell) for cell in row[:REACH_COLUMNS]] for row in tables[0]["rows"]]
    text = "The active rate with all pairs over that with nearest neighbours, by kind of wave:"
    return f"{text}\n\n{_grid(columns, rows)}"


def _benchmarks(results: Results) -> str:
    rows = [
        (b["name"], _seconds(b["ours"]), _seconds(b["theirs"]), f"{b['ratio']:.3g}")
        for name in BENCHMARKS
        for b in results["benchmarks"]
        if b["name"] == name
    ]
    text = "Speed, measured side by side in one run (medians):"
    return f"{text}\n\n{_grid(('Task', 'Ours', 'Theirs', 'Ratio'), rows)}" if rows else ""


def _shortfalls(results: Results) -> str:
    rows = [
        (check["name"], f"{check['measured']:.3g}", check["source"])
        for check in results["checks"]
        if check["kind"] == "shortfall"
    ]
    text = "Targets that the project sets itself and does not meet:"
    return f"{text}\n\n{_grid(('Target', 'Measured', 'Why'), rows)}" if rows else ""


def _seconds(value: float) -> str:
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"


def _grid(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(
        "| " + " | ".join(str(c).replace("|", "\\|") for c in row) + " |" for row in lines
    )
