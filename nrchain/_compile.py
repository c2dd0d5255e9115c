"""How kernels are compiled: kept on disk, with IEEE division, never assuming finite numbers."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import numba

ARITHMETIC = frozenset({"contract", "reassoc", "nsz", "arcp"})
"""What the compiler may rearrange. ``nnan`` and ``ninf`` are left out: a NaN has to stay one."""


def kernel(function: Callable[..., Any] | None = None, *, parallel: bool = False):
    """``numba.njit`` with the options of the house; ``parallel`` loops write only their own row."""

    def compile_(f: Callable[..., Any]) -> Any:
        return numba.njit(
            f,
            cache=True,
            parallel=parallel,
            error_model="numpy",
            fastmath=set(ARITHMETIC),
        )

    return compile_ if function is None else compile_(function)


def rename(function: Callable[..., Any], *distinctions: object) -> Callable[..., Any]:
    """The function under a name of its own, made from what tells it from others of the same text.

    Numba names machine code after its function, whatever options or closure it was compiled with.
    Two functions of one name, kept on disk by two processes and loaded by a third, are linked as
    one: whichever comes second runs the code of the first.
    """
    text = "\0".join(map(str, distinctions))
    suffix = hashlib.sha256(text.encode()).hexdigest()[:16]
    function.__name__ += f"_{suffix}"
    function.__qualname__ += f"_{suffix}"
    return function
