"""How the kernels are compiled: on disk, with IEEE division, and without assuming finite numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba

ARITHMETIC = frozenset({"contract", "reassoc", "nsz", "arcp"})
"""What the compiler may rearrange. ``nnan`` and ``ninf`` are left out: a NaN has to stay one."""


def kernel(function: Callable[..., Any] | None = None, *, parallel: bool = False, **options: Any):
    """``numba.njit`` with the options of the house; ``parallel`` loops must write only their row."""

    def compile_(f: Callable[..., Any]) -> Any:
        settings = {"cache": True, "error_model": "numpy", "fastmath": set(ARITHMETIC)}
        return numba.njit(f, parallel=parallel, **(settings | options))

    return compile_ if function is None else compile_(function)
