"""What a command shows: tables and lines, to whatever standard output and error are."""

from __future__ import annotations

import codecs
import contextlib
import io
import os
import re
import sys
import unicodedata
from typing import Any

from rich.console import Console
from rich.measure import Measurement
from rich.text import Text

ASCII = {
    **{"−": "-", "–": "-", "—": "-", "·": ".", "×": "x", "…": "...", "∥": "par", "⊥": "perp"},
    **{"λ": "lambda", "√": "sqrt", "∂": "d", "∞": "inf", "→": "->", "≥": ">=", "≤": "<=", "≈": "~"},
}
"""What is written where a stream has no place for a symbol; of others the nearest letters, or ?."""

UNBOUNDED = 10_000
"""Columns of a terminal that nothing here is wider than."""

GREEK = re.compile("GREEK (SMALL|CAPITAL) LETTER ([A-Z]+)")


def _spell(symbol: str) -> str:
    if symbol in ASCII:
        return ASCII[symbol]
    if greek := GREEK.fullmatch(unicodedata.name(symbol, "")):
        return greek[2].lower() if greek[1] == "SMALL" else greek[2].capitalize()
    near = unicodedata.normalize("NFKD", symbol).encode("ascii", "ignore").decode()
    return near or "?"


def _spelt(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeEncodeError)
    return "".join(map(_spell, error.object[error.start : error.end])), error.end


SPELT = "nrchain.spelt"
codecs.register_error(SPELT, _spelt)


class _Plain(Console):
    """A console that shows what it is given: brackets in a title or a path are no markup."""

    def on_broken_pipe(self) -> None:
        """Have a reader who has gone away found as any stream that cannot be written."""
        raise

    def render_str(self, text: str, **how: Any) -> Text:
        """The text in what the stream can show, spelt before columns are measured."""
        shown = text.encode(self.encoding, SPELT).decode(self.encoding)
        return super().render_str(shown, **how)


def console(stderr: bool = False) -> Console:
    return _Plain(stderr=stderr, markup=False, emoji=False, highlight=False)


def spell_out() -> None:
    """Have what the encoding of a stream lacks spelt in what it has."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=SPELT)


READER_GONE = 141
"""Exit code of a program that a shell sees end with SIGPIPE, as under ``| head``: 128 + 13."""


def show(*things: Any, whole: bool = False, **how: Any) -> OSError | None:
    """Print to standard output; what prevents it, if anything. Then all output is let go.

    What is to be shown ``whole`` is let run over the edge of a narrow terminal.
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
        let_go()
        return error
    return None


def let_go() -> None:
    """Send standard output nowhere from here on."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def complain_of(error: OSError, note: str = "") -> None:
    """One line on why standard output cannot be written; none of a reader that has gone away."""
    if not isinstance(error, BrokenPipeError):
        complain(f"{note}standard output: {error.strerror}")


def complain(line: str) -> None:
    """One line on standard error, whatever is in it."""
    plain = "".join(one if one.isprintable() else repr(one)[1:-1] for one in line)
    with contextlib.suppress(OSError):
        console(stderr=True).print(f"nrchain: {plain}", soft_wrap=True)
