"""How kernels are compiled: kept on disk, with IEEE division, never assuming finite numbers.

Numba keeps machine code with the file of its function and does not see that a function it calls,
in another file, has changed. The name of every kernel therefore carries a hash of all modules that
have kernels: code of an older version is never run.

Numba keeps machine code in ``NUMBA_CACHE_DIR``, beside the source or in the user's cache, whichever
can be written first. Where none can, kernels go to a folder of this user under the system's
temporary one, and a :class:`RuntimeWarning` names the setting that keeps them.
"""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Any

import numba

ARITHMETIC = frozenset({"contract", "reassoc", "nsz", "arcp"})
"""What the compiler may rearrange. ``nnan`` and ``ninf`` are left out: a NaN has to stay one."""


def kernel(function: Callable[..., Any] | None = None, *, parallel: bool = False):
    """``numba.njit`` with the options of the house; ``parallel`` loops write only their own row."""

    def compile_(f: Callable[..., Any]) -> Any:
        named = rename(f, sources())
        options: dict[str, Any] = {"parallel": parallel, "error_model": "numpy"}
        options["fastmath"] = set(ARITHMETIC)
        try:
            return numba.njit(named, cache=True, **options)
        except RuntimeError:
            # Numba finds no folder that can be written, and refuses to compile for that alone
            return _kept_for_now(named, options)

    return compile_ if function is None else compile_(function)


_placing = Lock()


def _kept_for_now(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Compile a kernel that is kept in a temporary folder, or not at all if there is none."""
    folder = temporary_folder()
    if folder is None:
        return numba.njit(function, **options)
    # Numba reads the folder where a function is declared, from its configuration alone.
    settings: Any = numba.config
    with _placing:
        given, settings.CACHE_DIR = settings.CACHE_DIR, str(folder)
        try:
            return numba.njit(function, cache=True, **options)
        except RuntimeError:
            return numba.njit(function, **options)
        finally:
            settings.CACHE_DIR = given


@cache
def temporary_folder() -> Path | None:
    """A folder of this user alone under the system's temporary one; none if that is not to be had.

    Kernels are loaded as code: a folder that others can write to, or that another user made under
    its name, is left alone.
    """
    try:
        folder = Path(tempfile.gettempdir(), f"nrchain-kernels-{os.getuid()}")
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        own = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
        if not own or found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            folder = Path(tempfile.mkdtemp(prefix="nrchain-kernels-"))
    except OSError:
        place, folder = "nowhere, and are compiled again by every process", None
    else:
        place = f"in {folder}, a temporary folder"
    text = f"compiled kernels are kept {place}: set NUMBA_CACHE_DIR to a folder that keeps them"
    warnings.warn(text, RuntimeWarning, stacklevel=2)
    return folder


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
