"""Ctrl-C and SIGTERM: an end in one line, and in a run one between two steps.

A run that is interrupted between two steps can write where it stands and close its file in order.
A second signal ends a step that takes long; while a file is being closed none is heard.
"""

from __future__ import annotations

import os
import signal
import threading
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

INTERRUPTED = 130
"""The exit code of a program that was interrupted, by either signal."""

PATIENCE = 1.0
"""Seconds that a step is given to end by itself before a second signal ends it."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_DEFAULTS = (signal.default_int_handler, signal.SIG_DFL)


SHOW_CURSOR = b"\r\x1b[K\x1b[?25h"
"""What a terminal is left with: the line of a progress bar wiped, and the cursor it hid shown."""

_undoing: list[Callable[[], object]] = []


def leave(number: int, frame: object) -> NoReturn:
    """End the program at once, with one line; nothing of worth is lost outside a run.

    An exception would not do: libraries that are being loaded, or compile, swallow it.
    """
    for undo in reversed(_undoing):
        undo()
    if os.isatty(2):
        os.write(2, SHOW_CURSOR)
    with suppress(OSError):
        os.write(2, b"nrchain: interrupted\n")
    os._exit(INTERRUPTED)


def _nothing(number: int, frame: object) -> None:
    """Hear a signal and do nothing: ignored by the system, one on its way would be an error."""


@contextmanager
def undone(undo: Callable[[], object]) -> Iterator[None]:
    """Have something done before a program is left at once."""
    _undoing.append(undo)
    try:
        yield
    finally:
        _undoing.remove(undo)


def leave_on_signals() -> None:
    """Have signals end this program with one line from here on, a run aside."""
    for number in _SIGNALS:
        if signal.getsignal(number) in _DEFAULTS:
            signal.signal(number, leave)


class Interruption:
    """Whether a signal has come: ``name`` is that of the first, or empty."""

    def __init__(self) -> None:
        self.name = ""
        self._since = 0.0
        self._at_once = False

    def note(self, number: int, frame: object) -> None:
        if not self.name:
            self.name, self._since = signal.Signals(number).name, clock.monotonic()
        elif self._at_once and clock.monotonic() - self._since >= PATIENCE:
            self._at_once = False
            raise KeyboardInterrupt(self.name)

    @contextmanager
    def second_at_once(self) -> Iterator[None]:
        """Have a second signal raise KeyboardInterrupt, within a step too."""
        self._at_once = True
        try:
            yield
        finally:
            self._at_once = False


@contextmanager
def deferred() -> Iterator[Interruption]:
    """Note signals in place of acting on them; if one came, raise KeyboardInterrupt at the end.

    Handlers that somebody else has set are left alone, and so are all outside the main thread. A
    program that has been told to end hears no more signals on its way out.
    """
    interruption = Interruption()
    replaced: dict[signal.Signals, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for number in _SIGNALS:
            if signal.getsignal(number) in (*_DEFAULTS, leave):
                replaced[number] = signal.signal(number, interruption.note)
    try:
        yield interruption
    finally:
        for number, before in replaced.items():
            ending = interruption.name and before is leave
            signal.signal(number, _nothing if ending else before)
    if interruption.name:
        raise KeyboardInterrupt(interruption.name)
