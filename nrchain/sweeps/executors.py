"""What runs the points: threads, processes, any executor, or a cluster of Dask."""

from __future__ import annotations

import multiprocessing
import pickle
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Self

from nrchain.errors import NrchainError, SceneError
from nrchain.inputs.optional import optional
from nrchain.inputs.rules import whole
from nrchain.run.ensemble import available_cores
from nrchain.sweeps.observables import Observable

RESTARTS = 3
"""How often a pool of processes is made anew after one of them died."""

PATIENCE = 30
"""Seconds in which a scheduler must answer."""


class Workers:
    """The executor given, or one of threads or processes that ends with the ``with`` statement.

    A client of Dask stands for its executor.
    """

    def __init__(self, given: Any, threads: int | None, processes: int | None) -> None:
        self._given, self._threads, self._processes = given, threads, processes
        self._restarts = RESTARTS
        self._open = ExitStack()

    def __enter__(self) -> Self:
        self._start()
        return self

    def __exit__(self, *error: Any) -> None:
        self._open.__exit__(*error)

    def restart(self) -> bool:
        """Make the processes anew after one of them died; False where that is not possible."""
        if self._processes is None or self._restarts == 0:
            return False
        self._restarts -= 1
        self._open.close()
        self._start()
        return True

    def _start(self) -> None:
        if self._given is not None:
            is_client = hasattr(self._given, "get_executor")
            self.executor: Executor = self._given.get_executor() if is_client else self._given
        elif self._processes is not None:
            self.executor = self._open.enter_context(_pool(self._processes))
        else:
            threads = available_cores() if self._threads is None else self._threads
            self.executor = self._open.enter_context(ThreadPoolExecutor(threads))


def check_workers(executor: Any, workers: int | None, processes: int | None) -> None:
    """Raise :class:`~nrchain.errors.SceneError` for what cannot run points."""
    given = {"executor": executor, "workers": workers, "processes": processes}
    several = [name for name, value in given.items() if value is not None]
    if len(several) > 1:
        name = several[1]
        raise SceneError(name, given[name], f"goes without {several[0]}; give one of them")
    for name in ("workers", "processes"):
        if given[name] is not None:
            whole(least=1)(name, given[name])
    is_executor = hasattr(executor, "submit") or hasattr(executor, "get_executor")
    if executor is not None and not is_executor:
        allowed = "must be an executor of concurrent.futures, or a client of Dask"
        raise SceneError("executor", executor, allowed)


def check_functions(
    observables: Mapping[str, Observable | None], executor: Any, processes: int | None
) -> None:
    """Raise :class:`~nrchain.errors.SceneError` for a function that no other process can get."""
    if processes is None and not isinstance(executor, ProcessPoolExecutor):
        return
    for name, function in observables.items():
        try:
            pickle.dumps(function)
        except Exception as error:
            allowed = f"must be a function at the top of a module, for processes: {error}"
            raise SceneError(f"observe {name}", function, allowed) from None


@contextmanager
def cluster(address: str) -> Iterator[Any]:
    """A client of the Dask scheduler at an address, or of that whose file (``.json``) this is.

    Raises :class:`~nrchain.errors.NrchainError` where no scheduler answers.
    """
    distributed = optional("distributed", "cluster", "a cluster of Dask")
    if address.endswith(".json") and not Path(address).is_file():
        # Dask would wait for the file
        raise NrchainError(f"cluster {address}: there is no such file; dask scheduler writes it")
    place = {"scheduler_file": address} if address.endswith(".json") else {"address": address}
    try:
        client = distributed.Client(**place, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise NrchainError(f"cluster {address}: no scheduler answers: {error}") from error
    with client:
        yield client


@contextmanager
def _pool(count: int) -> Iterator[Executor]:
    """A pool of processes, whose runs are ended if an error leaves this statement."""
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))
    try:
        yield pool
    except BaseException:
        for child in set(multiprocessing.active_children()) - before:
            child.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
