"""The members of an ensemble that an executor runs, such as a pool of processes."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from concurrent.futures import Executor, Future
from contextlib import nullcontext
from pathlib import Path
from queue import Queue
from typing import Any, NamedTuple, Self

import numpy as np

from nrchain.hydrodynamics import sharing
from nrchain.run.members import AHEAD, Member, Warned, wait_for
from nrchain.run.preparation import check_start
from nrchain.run.simulation import simulate_in_memory, simulate_to_file
from nrchain.scene.scene import Scene
from nrchain.trajectory.trajectory import Trajectory


class Ran(NamedTuple):
    """What a run gives: its trajectory or its error, and the texts of its warnings."""

    trajectory: Trajectory | None
    error: BaseException | None
    warnings: tuple[str, ...]


class PoolMembers:
    """Hands scenes to an executor, each into its file if it has one; used in a ``with`` statement.

    At most :data:`~nrchain.run.members.AHEAD` runs for each of its ``workers`` are with it at a
    time. At the end of the statement, those that have not begun are cancelled; the others are left
    to the executor.
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
                    run_member, scene, file, self._overwrite, alone, arithmetic
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
    scene: Scene, file: Path | None, overwrite: bool, alone: bool, arithmetic: Any
) -> Ran:
    """Run one scene, in a process of the executor; it sums pairs on one core unless ``alone``."""
    warnings = list[str]()
    trajectory: Trajectory | None = None
    error: BaseException | None = None
    with np.errstate(**arithmetic), nullcontext() if alone else sharing.one_thread():
        try:
            start = check_start(scene)
            if file is None:
                trajectory = simulate_in_memory(start, report=warnings.append)
            else:
                trajectory = simulate_to_file(
                    start, file, overwrite=overwrite, report=warnings.append
                )
        except BaseException as found:
            error = found
    return Ran(trajectory, error, tuple(warnings))
