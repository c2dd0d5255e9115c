"""How kernels are compiled: kept on disk, with IEEE division, never assuming finite numbers."""

from __future__ import annotations

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
