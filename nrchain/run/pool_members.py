"""The members of an ensemble that an executor runs, such as a pool of processes."""

from __future__ import annotations

import math
import pickle
import time as clock
from collections import deque
from collections.abc import Iterable
from concurrent.futures import Executor, Future
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from queue import Queue
from traceback import format_exception_only
from typing import Any, Self

import numpy as np

from nrchain.hydrodynamics import sharing
from nrchain.run.members import AHEAD, Member, Warned, wait_for
from nrchain.run.preparation import check_start
from nrchain.run.simulation import simulate_in_memory, simulate_to_file
from nrchain.scene.scene import Scene
from nrchain.trajectory.trajectory import Trajectory

_interrupted = -math.inf
"""When a signal last ended a run in this process, in seconds since the epoch."""


class Parcel:
    """A scene on its way to a process, which reads it only when its run begins.

    A pool breaks if one of its processes cannot read a task, such as a scene with an effect that
    is not defined there.
    """

    def __init__(self, content: Scene | bytes) -> None:
        self._content = content

    def __reduce__(self) -> tuple[Any, ...]:
        content = self._content
        return Parcel, (content if isinstance(content, bytes) else pickle.dumps(content),)

    def open(self) -> Scene:
        """The scene. Raises whatever its unpickling raises."""
        content = self._content
        return pickle.loads(content) if isinstance(content, bytes) else content


@dataclass(frozen=True)
class Ran:
    """What a run gives: its trajectory or its error, and the texts of its warnings.

    An error that does not survive pickle, which would break a pool, is pickled as a RuntimeError
    of its text.
    """

    trajectory: Trajectory | None
    error: BaseException | None
    warnings: tuple[str, ...] = ()

    def __reduce__(self) -> tuple[Any, ...]:
        error = self.error
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:
            error = RuntimeError("".join(format_exception_only(error)).strip())
        return Ran, (self.trajectory, error, self.warnings)


class PoolMembers:
    """Hands scenes to an executor, each into its file if it has one; used in a ``with`` statement.

    At most :data:`~nrchain.run.members.AHEAD` runs for each of its ``workers`` are with it at a
    time. At the end of the statement, those that the executor can still cancel are cancelled; the
    others are left to it.
    """

    def __init__(
        self,
        jobs: Iterable[tuple[Scene, Path | None]],
        executor: Executor,
        workers: int,
        overwrite: bool = False,
    ) -> None:
        self._jobs = deque(enumerate(jobs))
        self._executor, self._workers, self._overwrite = executor, workers, overwrite
        self._under_way: dict[Future[Ran], tuple[int, Scene]] = {}
        self._done = Queue[Future[Ran]]()
        self._ready = deque[Member | Warned]()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for future in self._under_way:
            future.cancel()

    def next(self) -> Member | Warned | None:
        """Wait for a warning, or for a member to end; None after the last member.

        Raises KeyboardInterrupt if a signal arrives meanwhile.
        """
        self._submit()
        if not self._ready:
            if not self._under_way:
                return None
            self._collect(wait_for(self._done))
        return self._ready.popleft()

    def _submit(self) -> None:
        arithmetic, alone = np.geterr(), self._workers == 1
        while self._jobs and len(self._under_way) < AHEAD * self._workers:
            index, (scene, file) = self._jobs.popleft()
            try:
                future = self._executor.submit(
                    run_member,
                    Parcel(scene),
                    file,
                    self._overwrite,
                    alone,
                    arithmetic,
                    clock.time(),
                )
            except RuntimeError as error:
                # the executor is broken or shut down
                self._ready.append(Member(index, scene, error=error))
                continue
            self._under_way[future] = index, scene
            future.add_done_callback(self._done.put)

    def _collect(self, future: Future[Ran]) -> None:
        index, scene = self._under_way.pop(future)
        try:
            ran = future.result()
        except BaseException as error:
            # a worker that died, or a result that cannot be pickled
            self._ready.append(Member(index, scene, error=error))
            return
        self._ready += [Warned(index, text) for text in ran.warnings]
        self._ready.append(Member(index, scene, ran.trajectory, ran.error))


def run_member(
    parcel: Parcel,
    file: Path | None,
    overwrite: bool,
    alone: bool,
    arithmetic: Any,
    handed_over: float,
) -> Ran:
    """Run one scene, in a process of the executor; it sums pairs on one core unless ``alone``.

    Ctrl-C reaches the processes of a pool too, and ends what they run. A scene that was handed over
    before that does not begin: the caller may have left, and the pool would wait for it.
    """
    global _interrupted
    if handed_over <= _interrupted:
        return Ran(None, KeyboardInterrupt("a signal came before the run began"))
    warnings = list[str]()
    trajectory: Trajectory | None = None
    error: BaseException | None = None
    with np.errstate(**arithmetic), nullcontext() if alone else sharing.one_thread():
        try:
            start = check_start(parcel.open())
            if file is None:
                trajectory = simulate_in_memory(start, report=warnings.append)
            else:
                trajectory = simulate_to_file(
                    start, file, overwrite=overwrite, report=warnings.append
                )
        except BaseException as found:
            error = found
            if isinstance(found, KeyboardInterrupt):
                _interrupted = clock.time()
    return Ran(trajectory, error, tuple(warnings))
