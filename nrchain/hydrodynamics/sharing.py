"""Sums shared between threads where that is safe, here and now, and done by one thread elsewhere.

Numba's threads are of one of several layers. OpenMP, the usual one on Linux, ends a process that
was forked from one in which it was used: a worker of a pool dies of it, and the pool waits for
ever. The work queue, the last resort, ends a process that enters it from two threads at once. Each
row of a sum is written by one iteration alone: one thread gives the same bits as many.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from typing import Any

import numba

ANY_THREAD = ("omp", "tbb")
"""Layers that may be entered from several threads at once."""

_turn = threading.Lock()
_forked = False


def layer() -> str:
    """The threading layer that numba has started in this process or its parent; empty if none."""
    try:
        return numba.threading_layer()
    except ValueError:
        return ""


def _note_fork() -> None:
    global _forked
    _forked = bool(layer())


os.register_at_fork(after_in_child=_note_fork)


def add(compiled: Callable[[bool], Any], parallel: bool, *arguments: Any) -> None:
    """Run the kernel ``compiled(True)``, or ``compiled(False)`` where threads may not be used."""
    if not parallel or _forked:
        compiled(False)(*arguments)
    elif layer() in ANY_THREAD:
        compiled(True)(*arguments)
    elif _turn.acquire(blocking=False):
        try:
            compiled(True)(*arguments)
        finally:
            _turn.release()
    else:
        compiled(False)(*arguments)
