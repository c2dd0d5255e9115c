"""One thread for everything: kernels of numba, loops of PyStokes (OpenMP), OpenBLAS.

Two threads that wait for each other are as slow as the slower one. On a busy machine of two cores,
OpenBLAS factorises a matrix of 384 columns a hundred times slower with two threads than with one,
and PyStokes sums two spheres ten times slower.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit each of these libraries to one thread, if it is loaded."""
    import numba

    with ExitStack() as stack:
        pools = [(numba.get_num_threads, numba.set_num_threads), *_openmp(), *_openblas()]
        for get, put in pools:
            stack.callback(put, get())
            put(1)
        yield


Pool = tuple[Callable[[], int], Callable[[int], object]]


def _openmp() -> Iterator[Pool]:
    """GNU OpenMP, which runs the parallel loops of PyStokes and numba."""
    try:
        library = ctypes.CDLL("libgomp.so.1")
    except OSError:
        return
    yield library.omp_get_max_threads, library.omp_set_num_threads


def _openblas() -> Iterator[Pool]:
    """Every OpenBLAS of this process: NumPy and SciPy each ship one, with names of its own."""
    maps = Path("/proc/self/maps")
    lines = maps.read_text().splitlines() if maps.exists() else []
    for path in sorted({line.split()[-1] for line in lines if "openblas" in line}):
        library = ctypes.CDLL(path)
        for prefix in ("scipy_openblas", "openblas"):
            for suffix in ("", "64_"):
                get = getattr(library, f"{prefix}_get_num_threads{suffix}", None)
                if get:
                    yield get, getattr(library, f"{prefix}_set_num_threads{suffix}")
