"""The report as one self-contained HTML page, with its figures and style."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt

from validation.report.recorder import DOTS_PER_INCH

TITLE = "nrchain: validation"
STYLE = """
body { font: 15px/1.5 system-ui, "Segoe UI", sans-serif; color: #1c1c1c; background: #fff;
       max-width: 66rem; margin: 2.5rem auto; padding: 0 1.5rem; }
h1 { font-size: 1.7rem; margin: 0 0 .2rem; } h2 { font-size: 1.3rem; margin: 3rem 0 .4rem;
     border-top: 1px solid #ddd; padding-top: 1.6rem; }
h3 { font-size: 1rem; margin: 1.8rem 0 .4rem; }
p, li { max-width: 48rem; } a { color: #124f8c; } code { font-size: .92em; }
.scroll { overflow-x: auto; } .note, figcaption, .caption { color: #555; font-size: .9rem; }
table { border-collapse: collapse; font-size: .87rem; font-variant-numeric: tabular-nums;
        margin: .4rem 0 .3rem; }
th { text-align: left; border-bottom: 1.5px solid #555; padding: .25rem .7rem .25rem 0;
     vertical-align: bottom; } td { border-bottom: 1px solid #eee; padding: .22rem .7rem .22rem 0;
     vertical-align: top; } .number { text-align: right; white-space: nowrap; }
.pass { color: #1d6b37; } .fail { color: #b00020; font-weight: 600; }
tr.failed td { background: #fdecee; } td.source { color: #555; max-width: 20rem; }
figure { margin: 1.2rem 0 1.8rem; } figure img { max-width: 100%; height: auto; }
figcaption { max-width: 48rem; } sup { line-height: 0; }
summary { cursor: pointer; font-weight: 600; margin: 1.8rem 0 .6rem; }
.verdict { font-size: 1.05rem; margin: .6rem 0 1.2rem; }
"""
KINDS = {
    "check": "",
    "difference": "known difference",
    "bound": "bound",
    "shortfall": "target not met",
}

_markdown = MarkdownIt("commonmark", {"html": False}).enable("table")


def page(results: dict[str, Any], folder: Path) -> str:
    """The page for the contents of results.json; paths of figures are relative to ``folder``."""
    body = [
        f"<h1>{TITLE}</h1>",
        _verdict(results),
        _summary(results),
        _known_differences(results),
        _shortfalls(results),
        *(_table(table, linked=True) for table in results["tables"] if table["first_page"]),
        *(_study(study, results, folder) for study in results["studies"]),
        _environment(results["environment"]),
    ]
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{TITLE}</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{STYLE}</style></head>\n<body>\n"
        + "\n".join(filter(None, body))
        + "\n</body></html>\n"
    )


def number(value: Any) -> str:
    """Text of a number: six digits; a + b i for complex numbers; strings unchanged."""
    if isinstance(value, list):
        re, im = (number(part) for part in value)
        return f"{re} {'−' if im.startswith('−') else '+'} {im.lstrip('−')} i"
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: ""}[value]
    if isinstance(value, int | float):
        return f"{value:.6g}".replace("-", "−")
    return str(value)


def _verdict(results: dict[str, Any]) -> str:
    failed = [check for check in results["checks"] if not check["passed"]]
    total = len(results["checks"])
    if not failed:
        return f'<p class="verdict pass">✓ All {total} checks pass.</p>'
    items = "".join(
        f"<li><a href='#{check['study']}'>{check['study']}</a>: {escape(check['name'])}</li>"
        for check in failed
    )
    return f'<p class="verdict fail">✗ {len(failed)} of {total} checks fail:</p><ul>{items}</ul>'


def _summary(results: dict[str, Any]) -> str:
    rows = []
    for study in results["studies"]:
        state = "fail" if study["failed"] else "pass"
        rows.append(
            f"<tr><td><a href='#{study['study']}'>{escape(study['title'])}</a></td>"
            f"<td class='number {state}'>{study['passed']} of {study['passed'] + study['failed']}"
            f"</td><td class='number'>{study['seconds']:.1f} s</td>"
            f"<td>{'quick' if study['quick'] else 'full'}</td>"
            f"<td>{study['finished'].replace('T', ' ').replace('+00:00', ' UTC')}</td></tr>"
        )
    head = _head(["Study", "Checks passed", "Time", "Run", "Finished"], numeric={1, 2})
    return f"<div class='scroll'><table>{head}{''.join(rows)}</table></div>"


def _known_differences(results: dict[str, Any]) -> str:
    count = sum(check["kind"] == "difference" for check in results["checks"])
    if not count:
        return ""
    return (
        f"<p class='note'>{count} of the checks are known differences: a misprint or a defect "
        "elsewhere, of stated size. Such a check fails if the difference changes or disappears.</p>"
    )


def _shortfalls(results: dict[str, Any]) -> str:
    rows = [
        [check["name"], check["measured"], check["source"]]
        for check in results["checks"]
        if check["kind"] == "shortfall"
    ]
    return (
        f"<h3>Targets not met</h3>{_grid(['Target', 'Measured', 'Reason'], rows)}" if rows else ""
    )


def _study(study: dict[str, Any], results: dict[str, Any], folder: Path) -> str:
    own = {
        key: [r for r in results[key] if r["study"] == study["study"]]
        for key in results
        if key in ("checks", "benchmarks", "tables")
    }
    parts = [f"<section id='{study['study']}'><h2>{escape(study['title'])}</h2>"]
    if study["error"]:
        parts.append(f"<p class='fail'>Stopped early. {escape(study['error'])}</p>")
    parts += [_markdown.render(text) for text in study["text"]]
    parts += [_figure(figure, folder) for figure in study["figures"]]
    parts += [_table(table) for table in own["tables"]]
    parts += [_benchmarks(own["benchmarks"]), _checks(own["checks"]), "</section>"]
    return "\n".join(filter(None, parts))


def _checks(checks: Sequence[dict[str, Any]]) -> str:
    rows = []
    for check in checks:
        state = "" if check["passed"] else " class='failed'"
        mark = "<span class='pass'>✓</span>" if check["passed"] else "<span class='fail'>✗</span>"
        kind = KINDS[check["kind"]]
        tag = f"<br><span class='note'>{kind}</span>" if kind else ""
        cells = "".join(
            f"<td class='number'>{_short(check[key])}</td>"
            for key in ("predicted", "measured", "error", "tolerance")
        )
        rows.append(
            f"<tr{state}><td>{mark}</td><td>{escape(check['name'])}{tag}</td>{cells}"
            f"<td class='source'>{escape(check['source'])}</td></tr>"
        )
    failed = sum(not check["passed"] for check in checks)
    state = f"{failed} of {len(checks)} fail" if failed else f"all {len(checks)} pass"
    titles = ["", "Check", "Predicted", "Measured", "Error", "Tolerance", "Source"]
    table = f"<table>{_head(titles, numeric={2, 3, 4, 5})}{''.join(rows)}</table>"
    if not checks:
        return ""
    return (
        f"<details{' open' if failed else ''}><summary>Checks: {state}</summary>"
        f"<div class='scroll'>{table}</div></details>"
    )


def _short(value: Any) -> str:
    """Two digits for numbers below 1e-3, up to six for others."""
    if isinstance(value, float) and 0 < abs(value) < 1e-3:
        mantissa, exponent = f"{value:.1e}".replace("-", "−").split("e−")
        return f"{mantissa}·10<sup>−{int(exponent)}</sup>"
    return escape(number(value))


def _benchmarks(benchmarks: Sequence[dict[str, Any]]) -> str:
    if not benchmarks:
        return ""
    rows = [
        [
            b["name"],
            f"{number(b['ours'])} {b['unit']}",
            f"{number(b['theirs'])} {b['unit']}",
            f"{b['ratio']:.3g}" if isinstance(b["ratio"], float) else b["ratio"],
            b["what"],
        ]
        for b in benchmarks
    ]
    columns = ["Task", "Ours", "Theirs", "Theirs / ours", "What"]
    return f"<h3>Benchmarks</h3>{_grid(columns, rows)}"


def _table(table: dict[str, Any], linked: bool = False) -> str:
    name = escape(table["name"])
    if linked:
        name = f"<a href='#{table['study']}'>{name}</a>"
    caption = _markdown.renderInline(table["caption"])
    return (
        f"<h3>{name}</h3>{_grid(table['columns'], table['rows'])}<p class='caption'>{caption}</p>"
    )


def _grid(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    numeric = {
        k
        for k in range(len(columns))
        if any(isinstance(row[k], int | float) and not isinstance(row[k], bool) for row in rows)
    }
    lines = (
        "<tr>"
        + "".join(
            f"<td class='number'>{_short(entry)}</td>"
            if k in numeric
            else f"<td>{_markdown.renderInline(number(entry))}</td>"
            for k, entry in enumerate(row)
        )
        + "</tr>"
        for row in rows
    )
    return f"<div class='scroll'><table>{_head(columns, numeric)}{''.join(lines)}</table></div>"


def _head(columns: Sequence[str], numeric: Iterable[int] = ()) -> str:
    right = set(numeric)
    cells = (
        f"<th{' class=number' if k in right else ''}>{_markdown.renderInline(title)}</th>"
        for k, title in enumerate(columns)
    )
    return f"<tr>{''.join(cells)}</tr>"


def _figure(figure: dict[str, Any], folder: Path) -> str:
    data = (folder / figure["file"]).read_bytes()
    png = base64.b64encode(data).decode()
    # The header of a PNG has its width in pixels: figures keep their sizes in inches.
    width = round(96 * int.from_bytes(data[16:20], "big") / DOTS_PER_INCH)
    caption = _markdown.renderInline(figure["caption"])
    return (
        f"<figure><img width='{width}' alt='{escape(figure['name'], quote=True)}' "
        f"src='data:image/png;base64,{png}'><figcaption>{caption}</figcaption></figure>"
    )


def _environment(environment: dict[str, Any]) -> str:
    libraries = ", ".join(f"{k} {v}" for k, v in environment["libraries"].items() if v)
    return (
        f"<h2>Made with</h2><p class='note'>nrchain {environment['nrchain']}, Python "
        f"{environment['python']}, {escape(libraries)}; {escape(environment['platform'])}, "
        f"{environment['processors']} processors. The same records are in results.json.</p>"
    )
