"""Run a sum on several threads where that is safe, and on one thread elsewhere.

Numba has several threading layers. OpenMP, the usual one on Linux, kills a process that was forked
from one in which it ran: the worker of a pool dies, and the pool waits for ever. The work queue,
the last resort, kills a process that enters it from two threads at once. One iteration writes each
row of a sum, so that one thread gives the same bits as many.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numba

from nrchain._compile import kernel, rename

PARALLEL_PAIRS = 20_000
"""Sums over more pairs than this run on several threads. Below, starting threads costs more."""

ANY_THREAD = ("omp", "tbb")
"""Layers that several threads may enter at once."""

_turn = threading.Lock()
_forked = False
_thread = threading.local()


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


@contextmanager
def one_thread() -> Iterator[None]:
    """Let the calling thread sum alone meanwhile: other threads fill the cores."""
    _thread.single = True
    try:
        yield
    finally:
        _thread.single = False


def is_alone() -> bool:
    """Whether the calling thread sums alone."""
    return getattr(_thread, "single", False)


def compile_sum(function: Callable[..., Any], parallel: bool, law: str = "") -> Any:
    """Compile the ``function`` of a law, on several threads or on one."""
    return kernel(rename(function, law, parallel), parallel=parallel)


def add(compiled: Callable[[bool], Any], parallel: bool, *arguments: Any) -> None:
    """Run the kernel ``compiled(True)``, or ``compiled(False)`` where threads may not be used."""
    if not parallel or _forked or is_alone():
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
