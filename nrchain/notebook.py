"""HTML of results, as notebooks show them: a table of plain cells, without styles of its own.

All texts are escaped. A class shows its fields by ``_repr_html_ = record_html``, or rows of its own
by :func:`table_html`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields
from html import escape
from typing import Any

from nrchain.wording import brief_value

MOST_ROWS = 60
"""Most rows of a table; the rest is counted in a last row."""


def table_html(title: str, rows: Iterable[Sequence[object]], heads: Sequence[str] = ()) -> str:
    """A table with a title; floating-point numbers have six digits.

    >>> table_html("a < b", [("q", 0.1 + 0.2)])
    '<table><caption>a &lt; b</caption><tbody><tr><td>q</td><td>0.3</td></tr></tbody></table>'
    """
    found = list(rows)
    shown = [_row("td", row) for row in found[:MOST_ROWS]]
    if len(found) > MOST_ROWS:
        shown.append(_row("td", [f"and {len(found) - MOST_ROWS} more"]))
    head = f"<thead>{_row('th', heads)}</thead>" if heads else ""
    caption = f"<caption>{escape(title)}</caption>"
    return f"<table>{caption}{head}<tbody>{''.join(shown)}</tbody></table>"


def record_html(record: Any) -> str:
    """The fields of a dataclass as a table: arrays by their shape, long lists by their length."""
    named = [(field.name, getattr(record, field.name)) for field in fields(record) if field.repr]
    return table_html(type(record).__name__, named)


def _row(tag: str, cells: Iterable[object]) -> str:
    texts = (cell if isinstance(cell, str) else brief_value(cell) for cell in cells)
    return "<tr>" + "".join(f"<{tag}>{escape(text)}</{tag}>" for text in texts) + "</tr>"
