"""Jobs and the crew that does them: side by side, each result kept as soon as it is there.

A job is a function of this package and its arguments, all of which can be pickled. What a job
raises is its result: the others go on, and the result says why it failed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from nrchain.errors import NrchainError
from nrchain.hydrodynamics import sharing
from nrchain.jobs.ledger import Ledger, Result
from nrchain.progress import Shown
from nrchain.run.interruption import GLANCE, FromThread, Interruption

FAILED = "failed"
"""The key of a result that holds what a job raised."""

AHEAD = 64
"""Most jobs that are handed to an executor and not yet done, unless another number is given."""


class WorkersLost(NrchainError, RuntimeError):
    """An executor whose workers died: it takes no more jobs."""


@dataclass(frozen=True)
class Job:
    """One piece of work.

    Attributes
    ----------
    name
        Names its result.
    function
        Takes ``arguments``, and the ``interruption`` of a thread or None; gives the result.
    about
        What is kept with the result, also where the job fails.
    """

    name: str
    function: Callable[..., Result]
    arguments: tuple[Any, ...]
    about: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Progress:
    """How many results there are, and the name of the latest.

    After an interruption, ``waits_for`` is the number of jobs under way that end at their next
    step, before KeyboardInterrupt is raised.
    """

    done: int
    name: str
    waits_for: int = 0

    def shown(self) -> Shown:
        """What the bar of a diagram shows; how many results there will be is not known."""
        return Shown(self.done, None, f"{self.done} results", self.name)


class Crew:
    """Does jobs by an executor and keeps their results in a ledger.

    ``interruption`` is asked between results: what is finished is kept, and KeyboardInterrupt is
    raised. At most ``ahead`` jobs are with the executor at a time. ``waits`` is called with the
    number of jobs under way, if there are any, when an interruption has to wait for them.
    """

    def __init__(
        self,
        ledger: Ledger,
        executor: Executor,
        interruption: Interruption,
        progress: Callable[[Progress], None] | None = None,
        ahead: int = AHEAD,
        waits: Callable[[int], None] | None = None,
    ) -> None:
        self._waits = waits
        self._ledger, self._executor, self._progress = ledger, executor, progress
        self._interruption, self._ahead = interruption, ahead
        # runs in threads of this process are told to stop; other processes get the signal too
        in_threads = isinstance(executor, ThreadPoolExecutor)
        self._stopper = FromThread("the caller") if in_threads else None

    def do(self, jobs: Sequence[Job]) -> list[Result | None]:
        """The results of jobs, in their order; those of the ledger are not computed again.

        Raises :class:`WorkersLost` where the executor gives up.
        """
        known = self._ledger.results
        waiting = deque(job for job in jobs if job.name not in known)
        under_way: dict[Future[Result], Job] = {}
        try:
            while waiting or under_way:
                while waiting and len(under_way) < self._ahead:
                    job = waiting.popleft()
                    under_way[self._submit(job)] = job
                self._collect(under_way)
        except BaseException:
            if self._stopper is not None:
                self._stopper.leave()
            left = sum(not future.cancel() for future in under_way)
            if left and self._waits and self._interruption.name:
                self._waits(left)
            raise
        return [known[job.name] for job in jobs]

    def _submit(self, job: Job) -> Future[Result]:
        work = partial(attempt, job.function, job.arguments, self._stopper)
        try:
            return self._executor.submit(work)
        except BrokenExecutor as error:
            raise self._lost(error) from error

    def _collect(self, under_way: dict[Future[Result], Job]) -> None:
        """Keep what is done meanwhile."""
        self._attend()
        done, _ = wait(under_way, timeout=GLANCE, return_when=FIRST_COMPLETED)
        for future in [one for one in under_way if one in done]:
            job = under_way.pop(future)
            self._ledger.add(job.name, {**job.about, **self._result(future)})
            if self._progress:
                self._progress(Progress(len(self._ledger.results), job.name))

    def _result(self, future: Future[Result]) -> Result:
        """The result of a job, or why its worker has none."""
        try:
            return future.result()
        except (BrokenExecutor, CancelledError) as error:
            self._attend()
            raise self._lost(error) from error
        except Exception as error:
            # such as that of Dask for a job at which one worker after another died
            return failure(error)

    def _attend(self) -> None:
        if self._interruption.name:
            raise KeyboardInterrupt(self._interruption.name)

    def _lost(self, error: BaseException) -> WorkersLost:
        why = str(error) or type(error).__name__
        return WorkersLost(f"the workers are lost: {why}; what is finished is kept")


def attempt(
    function: Callable[..., Result], arguments: tuple[Any, ...], interruption: Interruption | None
) -> Result:
    """The result of a job, or what it raised, in words."""
    try:
        with sharing.one_thread():
            return function(*arguments, interruption=interruption)
    except Exception as error:
        return failure(error)


def failure(error: Exception) -> Result:
    """The result of a job that raised this."""
    is_own = isinstance(error, NrchainError)
    return {FAILED: str(error) if is_own else f"{type(error).__name__}: {error}"}
