"""Ctrl-C and SIGTERM, put off to the end of the step under way.

A run that is interrupted between two steps can write where it stands and close its file in order.
A second signal is not put off.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_DEFAULTS = (signal.default_int_handler, signal.SIG_DFL)


class Interruption:
    """Whether a signal has come: ``name`` is that of the signal, or empty."""

    def __init__(self) -> None:
        self.name = ""


@contextmanager
def deferred() -> Iterator[Interruption]:
    """Note signals in place of acting on them; if one came, raise KeyboardInterrupt at the end.

    Handlers that somebody else has set are left alone, and so are all outside the main thread.
    """
    interruption = Interruption()
    replaced: dict[signal.Signals, Any] = {}

    def restore() -> None:
        for number, handler in replaced.items():
            signal.signal(number, handler)

    def note(number: int, frame: object) -> None:
        interruption.name = signal.Signals(number).name
        restore()

    if threading.current_thread() is threading.main_thread():
        for number in _SIGNALS:
            if signal.getsignal(number) in _DEFAULTS:
                replaced[number] = signal.signal(number, note)
    try:
        yield interruption
    finally:
        restore()
    if interruption.name:
        raise KeyboardInterrupt(interruption.name)
