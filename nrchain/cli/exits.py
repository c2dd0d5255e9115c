"""Exit codes, and how a command ends: one line on standard error and one of these codes.

==== ==========================================================================
0    The command is done. A picture or a table that cannot be written does not
     change the code of a run: its data are in its file.
2    The command is refused.
3    The run stopped early and keeps what it reached.
130  The command was interrupted.
141  The reader of standard output is gone, as under ``| head``. No line appears.
==== ==========================================================================
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer

from nrchain.cli.terminal import note, print_output, report
from nrchain.errors import NrchainError
from nrchain.run.interruption import INTERRUPTED

REFUSED, STOPPED = 2, 3

BROKEN_PIPE = 141
"""128 + 13, the number of SIGPIPE: what a shell expects of a program whose reader is gone."""


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Turn an error that a user can cause into one line on standard error and an exit code."""
    try:
        yield
    except NrchainError as error:
        report(str(error))
        raise typer.Exit(REFUSED) from error
    except OSError as error:
        report(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        raise typer.Exit(REFUSED) from error
    except KeyboardInterrupt:
        report("interrupted")
        raise typer.Exit(INTERRUPTED) from None


def show(*things: Any, **how: Any) -> None:
    """Print to standard output; exit where that fails."""
    if error := print_output(*things, **how):
        raise typer.Exit(report_unwritable_output(error))


def show_if_possible(*things: Any, **how: Any) -> None:
    """Print to standard output beside a run; note a failure and go on."""
    error = print_output(*things, **how)
    if error and not isinstance(error, BrokenPipeError):
        note(_describe(error))


def report_unwritable_output(error: OSError) -> int:
    """Report why standard output cannot be written, and return the exit code."""
    if isinstance(error, BrokenPipeError):
        return BROKEN_PIPE
    report(_describe(error))
    return REFUSED


def _describe(error: OSError) -> str:
    return f"standard output: {error.strerror}"
