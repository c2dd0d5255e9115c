"""The program ``nrchain``, which an interruption ends with one line from its very beginning."""

from __future__ import annotations

import os
import warnings
from typing import Any

from nrchain.run.interruption import INTERRUPTED, leave_on_signals


def main() -> None:
    """Run the command line, whose libraries are loaded with signals already in hand."""
    for descriptor in range(3):
        # a stream that is closed would lend its number to the next file that is opened
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    leave_on_signals()
    warnings.showwarning = _in_one_line
    # pictures go to files; a notebook names a backend here that need not be installed
    os.environ.pop("MPLBACKEND", None)
    from nrchain.cli.commands import main as command_line

    try:
        command_line()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            # on its way down the interpreter would hear signals again
            os._exit(INTERRUPTED)
        raise


def _in_one_line(message: Warning | str, *where: Any, **further: Any) -> None:
    """Show a warning as the program shows what it has to say, without the line of code."""
    from nrchain.cli.terminal import complain

    complain(f"warning: {message}")


if __name__ == "__main__":
    main()
