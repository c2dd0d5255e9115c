"""The program ``nrchain``, which an interruption ends with one line from its very beginning."""

from __future__ import annotations

import os

from nrchain.interruption import INTERRUPTED, leave_on_signals


def main() -> None:
    """Run the command line, whose libraries are loaded with signals already in hand."""
    for descriptor in range(3):
        # a stream that is closed would lend its number to the next file that is opened
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    leave_on_signals()
    from nrchain.cli import main as command_line

    try:
        command_line()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            # on its way down the interpreter would hear signals again
            os._exit(INTERRUPTED)
        raise


if __name__ == "__main__":
    main()
