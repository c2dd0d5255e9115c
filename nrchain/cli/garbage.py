"""Imports without garbage collection: what they create stays, and searching it takes time.

A search for garbage visits every object of the process. In the some thousand modules that a run
loads it takes a fifth of the start-up, and finds nothing.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


def spare_present_objects() -> None:
    """Exempt all objects of this process from garbage collection, also at its end.

    For the program only: in a process of others, garbage of theirs would stay.
    """
    gc.freeze()


@contextmanager
def no_collection() -> Iterator[None]:
    """Collect no garbage meanwhile; in the program, what was created is exempt from then on."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if gc.get_freeze_count():
            spare_present_objects()
        if was_on:
            gc.enable()
