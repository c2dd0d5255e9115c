"""Compile kernels: cached on disk, with IEEE division, without the assumption of finite numbers.

Numba caches machine code with the file of its function and does not notice a change of a function
that it calls in another file. The name of every kernel therefore contains a hash of all modules
with kernels: code of an older version never runs.

The cache is in ``NUMBA_CACHE_DIR``, beside the source or in the user's cache, the first of these
that is writable. If none is, kernels go to a folder of this user in the system's temporary folder,
and a :class:`RuntimeWarning` names the setting that keeps them.
"""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
import warnings
from collections.abc import Callable, Iterable
from functools import cache, partial
from pathlib import Path
from threading import Lock
from typing import Any

import numba
import numpy as np
from numba.core.registry import CPUDispatcher

LINKING = (0, 64), (0, 69)
"""Releases of Numba, from the first and before the second, in which :mod:`nrchain._linking` was
tried. It knows their inner parts; others compile in their own way, which takes half as long again.
"""


def links_parts(release: str) -> bool:
    """Whether kernels are linked from parts with this release of Numba."""
    first, second = (int(number) for number in release.split(".")[:2])
    return LINKING[0] <= (first, second) < LINKING[1]


LINKS = links_parts(numba.__version__)

if LINKS:
    from nrchain._linking import KernelCompiler, PartCompiler, with_part

ARITHMETIC = frozenset({"contract", "reassoc", "nsz", "arcp"})
"""What the compiler may rearrange. ``nnan`` and ``ninf`` are absent: a NaN stays a NaN."""


def kernel(
    function: Callable[..., Any] | None = None,
    *,
    parallel: bool = False,
    nogil: bool = False,
    alone: bool = False,
):
    """``numba.njit`` with the options of nrchain; ``parallel`` loops write one row each.

    ``nogil`` kernels release the global lock of the interpreter while they run. A kernel that
    others call before Python does is compiled as their part. With ``alone`` it is compiled for
    Python at once: this saves a second compilation of what both call, and its instructions are the
    same in all callers, as sums on one thread and on several need.
    """

    def compile_(f: Callable[..., Any]) -> Any:
        # no kernel is handed to another as a value: this saves a tenth of its compilation
        found = _cached(f, numba.njit, parallel=parallel, nogil=nogil, no_cfunc_wrapper=True)
        if LINKS and isinstance(found, CPUDispatcher) and not (parallel or alone):
            return with_part(found, _part(found.py_func))
        return found

    return compile_ if function is None else compile_(function)


def part(function: Callable[..., Any]) -> Any:
    """A kernel that only kernels call: without the code that takes arguments from Python."""
    return _part(rename(function, sources()))


def _part(function: Callable[..., Any]) -> Any:
    options: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, **_OPTIONS}
    if LINKS:
        options["pipeline_class"] = PartCompiler
    return numba.njit(**options)(function)


def inlined(function: Callable[..., Any]) -> Any:
    """A few lines of kernels, compiled into each that calls them."""
    return numba.njit(function, inline="always", **_OPTIONS)


def constants(values: Iterable[int]) -> tuple[int, ...]:
    """Integers for kernels to pass to parts: Numba compiles a part anew for each of Python's."""
    return tuple(np.int64(value) for value in values)  # type: ignore[misc]


def entry(function: Callable[..., Any], signature: Any) -> Any:
    """A kernel that is called by its address: ``numba.cfunc``."""
    return _cached(function, partial(numba.cfunc, signature))


_OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": set(ARITHMETIC)}


def _cached(function: Callable[..., Any], decorator: Callable[..., Any], **options: Any) -> Any:
    named, options = rename(function, sources()), {**_OPTIONS, **options}
    if LINKS:
        options["pipeline_class"] = KernelCompiler
    try:
        return decorator(cache=True, **options)(named)
    except RuntimeError:
        # Numba finds no writable folder and refuses to compile
        return _kept_for_now(named, options, decorator)


_placing = Lock()


def _kept_for_now(
    function: Callable[..., Any],
    options: dict[str, Any],
    decorator: Callable[..., Any] = numba.njit,
) -> Any:
    """Compile a kernel with its cache in a temporary folder, or without cache if there is none."""
    folder = temporary_folder()
    if folder is None:
        return decorator(**options)(function)
    # Numba reads the folder from its configuration when a function is declared.
    settings: Any = numba.config
    with _placing:
        given, settings.CACHE_DIR = settings.CACHE_DIR, str(folder)
        try:
            return decorator(cache=True, **options)(function)
        except RuntimeError:
            return decorator(**options)(function)
        finally:
            settings.CACHE_DIR = given


@cache
def temporary_folder() -> Path | None:
    """A folder of this user in the system's temporary folder; None if it cannot be created.

    Kernels are loaded as code: a folder that belongs to another user, or that others can write to,
    is not used.
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
    """A hash of all modules that stand in a folder with kernels.

    Kernels compile in the constants of modules beside them, which need not have kernels.
    """
    digest = hashlib.sha256()
    texts = {path: path.read_bytes() for path in sorted(Path(__file__).parent.rglob("*.py"))}
    folders = {path.parent for path, text in texts.items() if b"_compile" in text}
    for path, text in texts.items():
        if path.parent in folders:
            digest.update(path.name.encode() + b"\0" + text)
    return digest.hexdigest()


def rename(function: Callable[..., Any], *distinctions: object) -> Callable[..., Any]:
    """Give a function a unique name, from the ``distinctions`` between functions of equal text.

    Numba names machine code after its function, regardless of options and closure. If two processes
    cache two functions of one name and a third process loads both, it links them as one: the second
    runs the code of the first.
    """
    text = "\0".join(map(str, distinctions))
    suffix = hashlib.sha256(text.encode()).hexdigest()[:16]
    function.__name__ += f"_{suffix}"
    function.__qualname__ += f"_{suffix}"
    return function
