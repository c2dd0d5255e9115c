"""The members of an ensemble: threads that run them, and the queue that hands over results."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterable
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import Empty, Queue
from typing import Any, Self, TypeVar

import numpy as np

from nrchain.hydrodynamics import sharing
from nrchain.run.interruption import GLANCE, FromThread, deferred
from nrchain.run.preparation import check_start
from nrchain.run.simulation import simulate_in_memory, simulate_to_file
from nrchain.scene.scene import Scene
from nrchain.trajectory.trajectory import Trajectory

AHEAD = 2
"""Members under way, or finished and not yet taken, for each thread."""


@dataclass(frozen=True, eq=False)
class Member:
    """One run of an ensemble: its trajectory, or the error that ended it.

    Attributes
    ----------
    index
        Its place among the scenes, from 0.
    scene
        What was run.
    trajectory
        The trajectory, also of a run that stopped early; None if the run failed.
    error
        What :func:`nrchain.simulate` raised; None if it raised nothing.

    >>> from nrchain import simulate_many
    >>> scenes = [{"chain": {"particles": 2}, "run": {"end": 1.0}}]
    >>> for member in simulate_many(scenes):
    ...     print(member.index, member.trajectory.status)
    0 completed
    """

    index: int
    scene: Scene
    trajectory: Trajectory | None = None
    error: BaseException | None = None

    def result(self) -> Trajectory:
        """The trajectory. Raises the error of a run that failed."""
        if self.trajectory is None:
            assert self.error is not None
            raise self.error
        return self.trajectory


@dataclass(frozen=True)
class Warned:
    """A warning of a member, on its way to the thread that takes the results."""

    index: int
    text: str


Found = TypeVar("Found")


def wait_for(queue: Queue[Found]) -> Found:
    """What comes next in a queue; KeyboardInterrupt if a signal arrives first."""
    with deferred() as interruption:
        while not interruption.name:
            try:
                return queue.get(timeout=GLANCE)
            except Empty:
                continue
    raise AssertionError("deferred() raises KeyboardInterrupt")


class Members:
    """Runs scenes in threads, each into its file if it has one; used in a ``with`` statement.

    No thread waits: one that finds nothing to do ends, and :meth:`next` starts another when there
    is room again. At the end of the statement the runs under way stop at their next step.
    """

    def __init__(
        self, jobs: Iterable[tuple[Scene, Path | None]], threads: int, overwrite: bool = False
    ) -> None:
        self._jobs = deque(enumerate(jobs))
        self._most, self._overwrite = threads, overwrite
        # a SimpleQueue waits without end if a signal is handled as its timeout runs out
        self._lock, self._found = threading.Lock(), Queue[Member | Warned]()
        self._open = self._working = 0
        self._threads: list[threading.Thread] = []
        self._taker = FromThread("the caller of simulate_many")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._taker.leave()
        for thread in self._threads:
            thread.join()

    def next(self) -> Member | Warned | None:
        """Wait for a warning, or for a member to end; None after the last member.

        Raises KeyboardInterrupt if a signal arrives meanwhile.
        """
        self._taker.attend()
        self._start_threads()
        with self._lock:
            if not self._jobs and not self._open:
                return None
        found = wait_for(self._found)
        if isinstance(found, Member):
            with self._lock:
                self._open -= 1
        return found

    def _start_threads(self) -> None:
        self._threads = [thread for thread in self._threads if thread.is_alive()]
        # NumPy treats floating-point errors thread by thread
        work = partial(self._work, np.geterr())
        with self._lock:
            room = AHEAD * self._most - self._open
            new = max(0, min(len(self._jobs), room, self._most - self._working))
            self._working += new
        for _ in range(new):
            thread = threading.Thread(target=work)
            thread.start()
            self._threads.append(thread)

    def _work(self, arithmetic: Any) -> None:
        alone = self._most == 1
        with np.errstate(**arithmetic), nullcontext() if alone else sharing.one_thread():
            while (job := self._take()) is not None:
                index, (scene, file) = job
                self._found.put(self._run(index, scene, file))

    def _take(self) -> tuple[int, tuple[Scene, Path | None]] | None:
        """The next job, or None if there is none, too many results wait, or nobody wants them."""
        with self._lock:
            if not self._jobs or self._open >= AHEAD * self._most or self._taker.name:
                self._working -= 1
                return None
            self._open += 1
            return self._jobs.popleft()

    def _run(self, index: int, scene: Scene, file: Path | None) -> Member:
        def report(text: str) -> None:
            self._found.put(Warned(index, text))

        try:
            start = check_start(scene)
            if file is None:
                done = simulate_in_memory(start, report=report, interruption=self._taker)
            else:
                done = simulate_to_file(
                    start,
                    file,
                    overwrite=self._overwrite,
                    report=report,
                    interruption=self._taker,
                )
        except BaseException as error:
            return Member(index, scene, error=error)
        return Member(index, scene, done)
