"""How kernels are compiled: kept on disk, with IEEE division, never assuming finite numbers.

Numba keeps machine code with the file of its function and does not see that a function it calls,
in another file, has changed. The name of every kernel therefore carries a hash of all modules that
have kernels: code of an older version is never run.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba

ARITHMETIC = frozenset({"contract", "reassoc", "nsz", "arcp"})
"""What the compiler may rearrange. ``nnan`` and ``ninf`` are left out: a NaN has to stay one."""


def kernel(function: Callable[..., Any] | None = None, *, parallel: bool = False):
    """``numba.njit`` with the options of the house; ``parallel`` loops write only their own row."""

    def compile_(f: Callable[..., Any]) -> Any:
        return numba.njit(
            rename(f, sources()),
            cache=True,
            parallel=parallel,
            error_model="numpy",
            fastmath=set(ARITHMETIC),
        )

    return compile_ if function is None else compile_(function)


@cache
def sources() -> str:
    """A hash of the modules of this package that have kernels."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        text = path.read_bytes()
        if b"_compile" in text:
            digest.update(path.name.encode() + b"\0" + text)
    return digest.hexdigest()


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
