"""Jobs and the crew that does them: side by side, each result kept as soon as it is there.

A job is a function of this package and its arguments, all of which can be pickled. What a job
raises is its result: the diagram goes on, and says where it failed and why.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import partial
from typing import Any

from nrchain.diagrams.ledger import Ledger, Result
from nrchain.errors import NrchainError
from nrchain.hydrodynamics import sharing
from nrchain.progress import Shown
from nrchain.run.interruption import GLANCE, FromThread, Interruption

FAILED = "failed"
"""The key of a result that holds what a job raised."""

AHEAD = 64
"""Most jobs that are handed to an executor and not yet done."""


@dataclass(frozen=True)
class Job:
    """One piece of work.

    Attributes
    ----------
    name
        Names its result.
    function
        Takes ``arguments``, and the ``interruption`` of a thread or None; gives the result.
    """

    name: str
    function: Callable[..., Result]
    arguments: tuple[Any, ...]


@dataclass(frozen=True)
class Progress:
    """How many results there are, and the name of the latest."""

    done: int
    name: str

    def shown(self) -> Shown:
        """What the bar of a diagram shows; how many results there will be is not known."""
        return Shown(self.done, None, f"{self.done} results", self.name)


class Crew:
    """Does jobs by an executor and keeps their results in a ledger.

    ``interruption`` is asked between results: what is finished is kept, and KeyboardInterrupt is
    raised.
    """

    def __init__(
        self,
        ledger: Ledger,
        executor: Executor,
        interruption: Interruption,
        progress: Callable[[Progress], None] | None = None,
    ) -> None:
        self._ledger, self._executor, self._progress = ledger, executor, progress
        self._interruption = interruption
        # runs in threads of this process are told to stop; other processes get the signal too
        in_threads = isinstance(executor, ThreadPoolExecutor)
        self._stopper = FromThread("the diagram") if in_threads else None

    def do(self, jobs: Sequence[Job]) -> list[Result | None]:
        """The results of jobs, in their order; those of the ledger are not computed again."""
        known = self._ledger.results
        waiting = [job for job in jobs if job.name not in known]
        under_way: dict[Future[Result], str] = {}
        try:
            while waiting or under_way:
                while waiting and len(under_way) < AHEAD:
                    job = waiting.pop(0)
                    work = partial(attempt, job.function, job.arguments, self._stopper)
                    under_way[self._executor.submit(work)] = job.name
                self._collect(under_way)
        except BaseException:
            if self._stopper is not None:
                self._stopper.leave()
            for future in under_way:
                future.cancel()
            raise
        return [known[job.name] for job in jobs]

    def _collect(self, under_way: dict[Future[Result], str]) -> None:
        """Keep what is done meanwhile."""
        if self._interruption.name:
            raise KeyboardInterrupt(self._interruption.name)
        done, _ = wait(under_way, timeout=GLANCE, return_when=FIRST_COMPLETED)
        for future in [one for one in under_way if one in done]:
            name = under_way.pop(future)
            self._ledger.add(name, future.result())
            if self._progress:
                self._progress(Progress(len(self._ledger.results), name))


def attempt(
    function: Callable[..., Result], arguments: tuple[Any, ...], interruption: Interruption | None
) -> Result:
    """The result of a job, or what it raised, in words."""
    try:
        with sharing.one_thread():
            return function(*arguments, interruption=interruption)
    except NrchainError as error:
        return {FAILED: str(error)}
    except Exception as error:
        return {FAILED: f"{type(error).__name__}: {error}"}
