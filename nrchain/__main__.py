"""The program ``nrchain``, which an interruption ends with one line from its very beginning."""

from __future__ import annotations

import os

from nrchain.interruption import handling, leave


def main() -> None:
    """Run the command line, whose libraries are loaded with signals already in hand."""
    for descriptor in range(3):
        # a stream that is closed would lend its number to the next file that is opened
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    with handling(leave):
        from nrchain.cli import main as command_line

        command_line()


if __name__ == "__main__":
    main()
