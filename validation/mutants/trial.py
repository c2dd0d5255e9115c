"""The tests of one mutant, in a process forked from one that has the libraries loaded."""

from __future__ import annotations

import os
import signal
from collections.abc import Sequence
from multiprocessing import get_context
from pathlib import Path

from validation.mutants.loading import VARIABLE, load_as_mutant
from validation.mutants.sites import Mutant

ROOT = Path(__file__).parents[2]
STARTUP = Path(__file__).parent / "startup"

PASSED = 0
NOTICED = (1, 2, 4)
"""What pytest exits with where a test fails, or a module can no longer be imported."""

LIBRARIES = ("numpy", "scipy.linalg", "scipy.sparse.linalg", "scipy.integrate", "scipy.optimize")
FURTHER = ("numba", "h5py", "pytest", "rich", "typer", "sksundae.cvode")


def is_noticed(mutant: Mutant, tests: Sequence[str], patience: float) -> bool:
    """Whether a test fails, crashes or takes more than ``patience`` seconds with the mutant."""
    code = _exit_code(f"{ROOT / mutant.path}:{mutant.number}", ["-x", *tests], patience)
    if code is not None and code > 0 and code not in NOTICED:
        raise RuntimeError(f"pytest ended with {code} on {mutant}")
    return code != PASSED


def can_collect(tests: Sequence[str]) -> bool:
    """Whether pytest knows all these tests of the package as it is."""
    return _exit_code("", ["--collect-only", *tests], 300.0) == PASSED


def _exit_code(mutant: str, options: list[str], patience: float) -> int | None:
    process = _CONTEXT.Process(target=_run, args=(mutant, options))
    process.start()
    process.join(patience)
    if process.is_alive():
        assert process.pid is not None
        os.killpg(process.pid, signal.SIGKILL)
        process.join()
        return None
    return process.exitcode


def _run(mutant: str, options: list[str]) -> None:
    os.setpgid(0, 0)
    os.chdir(ROOT)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nowhere, stream)
    if mutant:
        os.environ[VARIABLE] = mutant
        paths = [str(STARTUP), str(ROOT), os.environ.get("PYTHONPATH", "")]
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
        load_as_mutant(mutant)
    import pytest

    os._exit(int(pytest.main(["-q", "-n0", "-p", "no:cacheprovider", "-m", "", *options])))


_CONTEXT = get_context("forkserver")
_CONTEXT.set_forkserver_preload([*LIBRARIES, *FURTHER])
