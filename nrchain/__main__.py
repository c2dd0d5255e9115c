"""The program ``nrchain``. It handles signals before it loads any library."""

from __future__ import annotations

import logging
import os
import warnings
from typing import Any

from nrchain.cli.garbage import no_collection, spare_present_objects
from nrchain.run.interruption import INTERRUPTED, leave_on_signals


def main() -> None:
    """Run the command line; an interruption at any time ends it with one line."""
    for descriptor in range(3):
        # the next file that opens would take the number of a closed standard stream
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    leave_on_signals()
    warnings.showwarning = _show_warning
    # pictures go to files; a notebook may name a backend here that is not installed
    os.environ.pop("MPLBACKEND", None)
    # where no folder can be written, matplotlib warns of its own caches; its errors remain
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    spare_present_objects()
    with no_collection():
        from nrchain.cli.app import main as command_line

    try:
        command_line()
    except SystemExit as end:
        spare_present_objects()
        if end.code == INTERRUPTED:
            # a normal exit would handle signals again on its way
            os._exit(INTERRUPTED)
        raise


def _show_warning(message: Warning | str, *where: Any, **further: Any) -> None:
    """Report a warning in one line, without the line of code that raised it."""
    from nrchain.cli.terminal import warn

    warn(str(message))


if __name__ == "__main__":
    main()
