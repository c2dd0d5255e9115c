"""Ctrl-C and SIGTERM: an end in one line, and in a run one between two steps.

A run that is interrupted between two steps can write where it stands and close its file in order.
A second signal ends the step under way too; while a file is being closed none is heard.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

INTERRUPTED = 130
"""The exit code of a program that was interrupted, by either signal."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def leave(number: int, frame: object) -> NoReturn:
    """End the process at once, with one line: there is nothing yet that could be lost."""
    os.write(2, b"nrchain: interrupted\n")
    os._exit(INTERRUPTED)


def _raise(number: int, frame: object) -> NoReturn:
    """Raise KeyboardInterrupt, and hear no further signal on the way out."""
    for other in _SIGNALS:
        signal.signal(other, signal.SIG_IGN)
    raise KeyboardInterrupt(signal.Signals(number).name)


_OURS = (signal.default_int_handler, signal.SIG_DFL, leave, _raise)


@contextmanager
def handling(handler: Callable[[int, object], object]) -> Iterator[None]:
    """Have both signals handled so.

    Handlers that somebody else has set are left alone, and so are all outside the main thread.
    """
    replaced: dict[signal.Signals, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for number in _SIGNALS:
            if signal.getsignal(number) in _OURS:
                replaced[number] = signal.signal(number, handler)
    try:
        yield
    finally:
        for number, before in replaced.items():
            signal.signal(number, before)


@contextmanager
def raising() -> Iterator[None]:
    """Have either signal raise KeyboardInterrupt, once."""
    with handling(_raise):
        yield


class Interruption:
    """Whether a signal has come: ``name`` is that of the first, or empty."""

    def __init__(self) -> None:
        self.name = ""
        self._at_once = False

    def note(self, number: int, frame: object) -> None:
        if self.name and self._at_once:
            self._at_once = False
            raise KeyboardInterrupt(self.name)
        self.name = self.name or signal.Signals(number).name

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
    """Note signals in place of acting on them; if one came, raise KeyboardInterrupt at the end."""
    interruption = Interruption()
    with handling(interruption.note):
        yield interruption
    if interruption.name:
        raise KeyboardInterrupt(interruption.name)
