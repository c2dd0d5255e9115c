"""Print tables and lines to standard output and standard error, whatever they are connected to."""

from __future__ import annotations

import codecs
import contextlib
import io
import os
import re
import sys
import textwrap
import unicodedata
from typing import Any

from rich.console import Console
from rich.measure import Measurement
from rich.text import Text

ASCII = {
    **{"−": "-", "–": "-", "—": "-", "·": ".", "×": "x", "…": "...", "∥": "par", "⊥": "perp"},
    **{"λ": "lambda", "√": "sqrt", "∂": "d", "∞": "inf", "→": "->", "≥": ">=", "≤": "<=", "≈": "~"},
}
"""Replacements of symbols that a stream cannot encode. Other symbols become the nearest letters."""

UNBOUNDED = 10_000
"""Width of a terminal, in columns, that no table exceeds."""

GREEK = re.compile("GREEK (SMALL|CAPITAL) LETTER ([A-Z]+)")


def _ascii(symbol: str) -> str:
    """The ASCII replacement of one symbol; ``?`` where there is none."""
    if symbol in ASCII:
        return ASCII[symbol]
    if greek := GREEK.fullmatch(unicodedata.name(symbol, "")):
        return greek[2].lower() if greek[1] == "SMALL" else greek[2].capitalize()
    near = unicodedata.normalize("NFKD", symbol).encode("ascii", "ignore").decode()
    return near or "?"


def _transliterate(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeEncodeError)
    return "".join(map(_ascii, error.object[error.start : error.end])), error.end


TRANSLITERATE = "nrchain.transliterate"
"""Name of the error handler that replaces what an encoding lacks."""
codecs.register_error(TRANSLITERATE, _transliterate)


class _PlainConsole(Console):
    """A console that prints text literally: brackets in a title or a path are not markup."""

    def on_broken_pipe(self) -> None:
        """Raise the error of a closed pipe, like any other failure to write."""
        raise

    def render_str(self, text: str, **how: Any) -> Text:
        """The text in the encoding of the stream, transliterated before columns are measured."""
        shown = text.encode(self.encoding, TRANSLITERATE).decode(self.encoding)
        return super().render_str(shown, **how)


def console(stderr: bool = False) -> Console:
    """A console without markup, emoji codes or highlighting."""
    return _PlainConsole(stderr=stderr, markup=False, emoji=False, highlight=False)


LABEL = 12
"""Columns of the label of a line."""


def paragraph(text: str, first: str = "", others: str = "") -> str:
    """A text broken at blanks to the width of the terminal; ``first`` and ``others`` indent it."""
    return textwrap.fill(
        text,
        console().width,
        initial_indent=first,
        subsequent_indent=others,
        break_long_words=False,
        break_on_hyphens=False,
    )


def list_item(text: str) -> str:
    """A text as an item of a list."""
    return paragraph(text, "  - ", "    ")


def labelled(label: str, text: str) -> str:
    """A text behind its label."""
    return paragraph(text, f"{label:<{LABEL}}", " " * LABEL)


def transliterate_output() -> None:
    """Make both output streams replace symbols that their encoding lacks."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=TRANSLITERATE)


def print_output(*things: Any, whole: bool = False, **how: Any) -> OSError | None:
    """Print to standard output. Return the error if that fails, and discard all later output.

    With ``whole``, a table wider than the terminal runs over its edge instead of being cut.
    """
    try:
        screen = console()
        for thing in things:
            if whole:
                free = screen.options.update(width=UNBOUNDED, max_width=UNBOUNDED)
                needed = Measurement.get(screen, free, thing).maximum
                screen.width = max(needed, screen.width)
            screen.print(thing, **how)
    except OSError as error:
        discard_output()
        return error
    return None


def discard_output() -> None:
    """Connect standard output to the null device."""
    with contextlib.suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, sys.stdout.fileno())
        os.close(null)


def report(line: str) -> None:
    """Print one line to standard error; control characters are escaped."""
    plain = "".join(one if one.isprintable() else repr(one)[1:-1] for one in line)
    with contextlib.suppress(OSError):
        console(stderr=True).print(f"nrchain: {plain}", soft_wrap=True)


def note(text: str) -> None:
    """Report what a user should know, on standard error."""
    report(f"note: {text}")


def warn(text: str) -> None:
    """Report what may spoil a result, on standard error."""
    report(f"warning: {text}")
