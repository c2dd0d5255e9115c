"""Ctrl-C and SIGTERM: a program ends with one line, a run between two steps.

A run that ends between two steps can write its last poses and close its file in order. A second
signal ends a step that takes long. Signals that arrive while the file is being closed are ignored.
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
"""Seconds after the first signal from which on a second one ends the step under way."""

GLANCE = 0.1
"""Seconds between two looks for an interruption while a thread waits for another."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_DEFAULTS = (signal.default_int_handler, signal.SIG_DFL)


SHOW_CURSOR = b"\r\x1b[K\x1b[?25h"
"""Erases the line of a progress bar and shows the cursor that it hid."""

_cleanups: list[Callable[[], object]] = []


def leave(number: int, frame: object) -> NoReturn:
    """End the program at once, with one line, outside a run, where nothing is lost.

    An exception would not do: libraries swallow it while they load or compile.
    """
    for clean_up in reversed(_cleanups):
        clean_up()
    if os.isatty(2):
        os.write(2, SHOW_CURSOR)
    with suppress(OSError):
        os.write(2, b"nrchain: interrupted\n")
    os._exit(INTERRUPTED)


def _ignore(number: int, frame: object) -> None:
    """Do nothing. With ``SIG_IGN``, Python would report a signal already on its way as an error."""


@contextmanager
def cleanup_on_exit(clean_up: Callable[[], object]) -> Iterator[None]:
    """Call ``clean_up`` if a signal ends the program meanwhile."""
    _cleanups.append(clean_up)
    try:
        yield
    finally:
        _cleanups.remove(clean_up)


def leave_on_signals() -> None:
    """From here on, let signals end this program with one line, except during a run."""
    for number in _SIGNALS:
        if signal.getsignal(number) in _DEFAULTS:
            signal.signal(number, leave)


class Interruption:
    """The first signal that has arrived, or what else interrupts a run."""

    def __init__(self) -> None:
        self._name = ""
        self._since = 0.0
        self._at_once = False

    @property
    def name(self) -> str:
        """What interrupts the run; empty if nothing does."""
        return self._name

    def interrupt(self, name: str) -> None:
        """Interrupt the run at its next step."""
        self._name = name

    def note(self, number: int, frame: object) -> None:
        """Handle a signal: keep its name, or end the step under way if it is a second one."""
        if not self.name:
            self._name, self._since = signal.Signals(number).name, clock.monotonic()
        elif self._at_once and clock.monotonic() - self._since >= PATIENCE:
            self._at_once = False
            raise KeyboardInterrupt(self.name)

    @contextmanager
    def second_at_once(self) -> Iterator[None]:
        """Let a second signal raise KeyboardInterrupt, also within a step."""
        self._at_once = True
        try:
            yield
        finally:
            self._at_once = False


class FromThread(Interruption):
    """Interrupts runs in other threads, also once the thread that they run for has ended.

    At the end of a program Python waits for all threads, and would wait for these runs.
    """

    def __init__(self, who: str) -> None:
        super().__init__()
        self._who = who
        self.attend()

    def attend(self) -> None:
        """Note the calling thread as that which the runs are for."""
        self._thread = threading.current_thread()

    def leave(self) -> None:
        """Interrupt the runs at their next steps."""
        self.interrupt(self._who)

    @property
    def name(self) -> str:
        if not (self._thread.is_alive() or threading.main_thread().is_alive()):
            self.leave()
        return super().name


@contextmanager
def deferred() -> Iterator[Interruption]:
    """Note signals instead of acting on them; if one arrived, raise KeyboardInterrupt at the end.

    Handlers that other code has set stay in place, and so do all outside the main thread. A program
    that is to end ignores further signals on its way out.
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
            signal.signal(number, _ignore if ending else before)
    if interruption.name:
        raise KeyboardInterrupt(interruption.name)
