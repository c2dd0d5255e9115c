"""simulate_many: several scenes side by side, each result as soon as its run ends."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterable, Mapping
from concurrent.futures import Executor
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from nrchain.errors import SceneError, TrajectoryError
from nrchain.inputs.rules import whole
from nrchain.notices import warn
from nrchain.progress import Shown, bar
from nrchain.run.folders import new_folder
from nrchain.run.members import Member, Members, Warned
from nrchain.run.output import output_file
from nrchain.run.pool_members import PoolMembers
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.trajectory.file import refuse_existing

DIGITS = 4
"""Least number of digits in the name of a member's file, so that names sort by index."""

Source = str | os.PathLike[str] | Mapping[str, Any] | Scene
"""What :func:`nrchain.load_scene` takes."""


def simulate_many(
    scenes: Iterable[Source],
    output: str | Path | None = None,
    workers: int | None = None,
    *,
    executor: Executor | None = None,
    overwrite: bool = False,
    progress: bool = False,
) -> Generator[Member, None, None]:
    """Run several scenes side by side, and yield each as a :class:`Member` as soon as it ends.

    Each run gives the same bits as :func:`simulate`, whatever the number of workers. Runs start
    with the first result that is asked for. At most ``2 * workers`` of them are under way or wait
    to be taken, so that memory does not grow with the number of scenes. Leaving the loop early, by
    ``break``, an error or Ctrl-C, stops the runs that are under way at their next step, and closes
    their files with what they have, unless an ``executor`` runs them. If you keep the iterator, its
    ``close()`` does that.

    Parameters
    ----------
    scenes
        Scenes, or names, paths and tables that :func:`nrchain.load_scene` takes.
    output
        Folder for one trajectory file a scene, ``0000.h5``, ``0001.h5``, …, which is made if need
        be; none: memory only.
    workers
        Threads that run scenes, by default as many as this process has cores. If there are
        several, each sums pairs on one core. With an ``executor``, how many workers it has.
    executor
        Runs the scenes in place of threads: any of :mod:`concurrent.futures`, such as a pool of
        processes. Threads take turns in what a run does in Python, some milliseconds; many cores
        and short runs need processes. The pool stays open. If you leave the loop early, it goes on
        with the runs that it has taken, up to ``2 * workers``; Ctrl-C ends those in processes too.
    overwrite
        Whether existing files may be replaced.
    progress
        Whether a bar in a terminal or a notebook shows, on standard error, how many runs have
        ended.

    Yields
    ------
    Member
        In the order in which the runs end. A run that fails has its error in ``error``, and the
        others go on. A run that stops early is no failure: its trajectory says why.

    Warns
    -----
    SceneWarning
        As :func:`simulate` does, with the index of the scene.

    Raises
    ------
    SceneError
        Before any run, for a scene that cannot be read, which is named by its index, for
        ``workers`` below 1, and for an ``executor`` that is none.
    TrajectoryError
        Before any run, for a file that exists, if ``overwrite`` is not set, and for an output that
        is no folder.
    KeyboardInterrupt
        On Ctrl-C and SIGTERM while it waits for a result.

    >>> scenes = [{"chain": {"particles": 2}, "run": {"end": end}} for end in (1.0, 2.0)]
    >>> sorted(float(member.result().time[-1]) for member in simulate_many(scenes))
    [1.0, 2.0]
    """
    threads = available_cores() if workers is None else whole(least=1)("workers", workers)
    is_class = isinstance(executor, type)
    if executor is not None and (is_class or not hasattr(executor, "submit")):
        raise SceneError("executor", executor, "must be an executor of concurrent.futures")
    loaded = _load(scenes)
    folder = None if output is None else _folder(output)
    width = max(DIGITS, len(str(len(loaded) - 1)))
    files = [None if folder is None else folder / f"{i:0{width}}.h5" for i in range(len(loaded))]
    for file in filter(None, files):
        refuse_existing(file, overwrite)
    jobs = zip(loaded, files, strict=True)
    if executor is None:
        return _results(Members(jobs, threads, overwrite), folder, progress, len(loaded))
    members = PoolMembers(jobs, executor, threads, overwrite)
    return _results(members, folder, progress, len(loaded))


def available_cores() -> int:
    """The number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _results(
    members: Members | PoolMembers, folder: Path | None, progress: bool, total: int
) -> Generator[Member, None, None]:
    done = 0
    with (
        new_folder(folder) if folder else nullcontext(),
        bar() if progress else nullcontext() as draw,
        members,
    ):
        while (found := members.next()) is not None:
            if isinstance(found, Warned):
                warn(f"scenes[{found.index}]: {found.text}")
                continue
            done += 1
            if draw:
                draw(Shown(done, total, f"{done} of {total} runs"))
            yield found


def _load(scenes: Iterable[Source]) -> list[Scene]:
    """The scenes; a SceneError names the index of one that cannot be read."""
    if isinstance(scenes, (str, os.PathLike, Mapping, Scene)) or not isinstance(scenes, Iterable):
        raise SceneError("scenes", scenes, "must be several scenes, such as a list of them")
    loaded = []
    for index, source in enumerate(scenes):
        try:
            loaded.append(load_scene(source))
        except SceneError as error:
            where = f"scenes[{index}]"
            key = where if error.key == "scene" else f"{where}.{error.key}"
            raise SceneError(key, error.value, error.allowed) from error
    return loaded


def _folder(output: str | Path) -> Path:
    """The folder for the files; raise :class:`TrajectoryError` for the name of a file."""
    folder, file = output_file(output, overwrite=True)
    if folder is None:
        raise TrajectoryError(f"{file}: must be a folder, which gets one file for each scene")
    # processes of a pool may be in another folder, and this one may be left before a run begins
    return folder.absolute()
