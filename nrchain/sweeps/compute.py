"""sweep: one scene at many points of its keys, by any executor, each point once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from nrchain.errors import SceneError
from nrchain.inputs.rules import whole
from nrchain.jobs.ledger import RESULTS, Ledger, opened
from nrchain.notices import warn
from nrchain.progress import updates
from nrchain.run.interruption import deferred
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.scene.toml import flat_keys
from nrchain.sweeps.adaptive_points import BATCH, AdaptivePoints, Target
from nrchain.sweeps.executors import Workers, check_functions, check_workers
from nrchain.sweeps.observables import DEFAULT, Observable, read_observables
from nrchain.sweeps.points import Site, Values, all_changes, portable, sites
from nrchain.sweeps.progress import Counter, Report, SweepProgress
from nrchain.sweeps.result import WHAT, Sweep
from nrchain.sweeps.tables import write_tables
from nrchain.sweeps.task import Shard, Task
from nrchain.sweeps.without_value import without_value


def sweep(
    scene: Any,
    grid: Mapping[str, Any] | None = None,
    *,
    points: Iterable[Values] | None = None,
    random: Mapping[str, Any] | None = None,
    adaptive: Mapping[str, Any] | None = None,
    samples: int | None = None,
    seed: int = 0,
    target: str | None = None,
    batch: int = BATCH,
    observe: str | Iterable[str] | Mapping[str, Observable | str] | None = DEFAULT,
    output: str | Path | None = None,
    keep: bool = False,
    shard: str | None = None,
    executor: Any = None,
    workers: int | None = None,
    processes: int | None = None,
    retry: bool = False,
    overwrite: bool = False,
    progress: Report | bool | None = None,
) -> Sweep:
    """Run a scene at many points, and return what is observed at each.

    Every point is checked before any is run. The same point gives the same bits, whatever the
    executor, the order and the number of workers. With an ``output``, each result is on disk as
    soon as it is there; points that are finished are not run again, and later calls add points.

    Parameters
    ----------
    scene
        What is varied: a scene, or what :func:`nrchain.load_scene` takes.
    grid
        Values of keys, all combinations of them: ``{"slip.2s": [0, 50, 100]}``. A text gives them
        as the command line does: ``"0:100:3"``, ``"1:100:3:log"`` or ``"16,32"``.
    points
        A list of changes: ``[{"slip.2s": 50.0, "slip.3t": 10.0}, …]``.
    random
        Ends of keys, between which ``samples`` points are drawn with ``seed``:
        ``{"slip.2s": (-100, 100)}`` or ``(1, 100, "log")``. Each is combined with each point of
        ``grid`` and ``points``. More samples begin with the same ones.
    adaptive
        Ends of one or two keys, between which ``samples`` points are placed where the ``target``
        changes most. Needs the package adaptive.
    target
        An observable; by default the first. For words, such as ``"measure.attractor"``, points
        gather at the boundaries.
    batch
        Points that are placed at a time.
    observe
        Names of :data:`~nrchain.sweeps.observables.NAMED`, or a table of names and own functions:
        ``{"end.size": "end.size", "tip": lambda run: run.positions[-1, -1, 1]}``. A function takes
        the trajectory and gives one number or word.
    output
        Folder that keeps the results, and gets the tables ``table.csv``, ``table.parquet`` and, for
        a grid, ``grid.nc``.
    keep
        Whether to keep the trajectories too, in the folder ``trajectories``.
    shard
        ``"2/8"`` runs the second eighth of the points, for one job of an array of eight. The call
        without it merges them.
    executor
        Any executor of :mod:`concurrent.futures`, or a client of Dask. By default threads.
    workers, processes
        Number of threads, by default that of the cores; or of processes in their place.
    retry
        Whether points that failed are run again.
    overwrite
        Whether another sweep in this folder may be replaced.
    progress
        True for a bar, or a function that gets a :class:`~nrchain.sweeps.progress.SweepProgress` at
        each result.

    Returns
    -------
    Sweep
        With an ``output``, all points of the folder. A run that fails is a point with the outcome
        ``"failed"`` and its reason, and the others go on. ``Sweep.without_value`` says which
        observables have no value at some points; a warning does so for own functions that raise.

    Raises
    ------
    SceneError
        Before any run, for points whose scenes are refused, with their values, for an observable
        that is not known, and for arguments that do not go together.
    TrajectoryError
        For a folder with a sweep of another scene, or to which another program writes.
    KeyboardInterrupt
        On Ctrl-C and SIGTERM. What is finished is in the folder.

    >>> found = sweep({"chain": {"particles": 2}, "run": {"end": 1.0}}, {"run.end": [1.0, 2.0]})
    >>> found.column("end.time")
    [1.0, 2.0]
    """
    base, observables = load_scene(scene), read_observables(observe)
    check_workers(executor, workers, processes)
    check_functions(observables, executor, processes)
    part = None if shard is None else Shard.read(shard)
    _check_output(output, keep, part, overwrite)
    if adaptive is None:
        found = sites(base, all_changes(base, grid, points, random, samples, seed))
        found = found if part is None else part.of(found)
        total, rounds = len(found), _single(found)
    else:
        _refuse_with_adaptive({"grid": grid, "points": points, "random": random, "shard": shard})
        total = whole(least=1)("samples", samples)
        rounds = partial(
            AdaptivePoints(base, adaptive).rounds, total, whole(least=1)("batch", batch)
        )
    aim = _target(target, observables)
    folder = None if output is None else Path(output)
    with (
        updates(progress, SweepProgress.shown) as report,
        _ledger(base, folder, part, overwrite) as ledger,
        deferred() as interruption,
        Workers(executor, workers, processes) as crew,
    ):
        task = Task(observables, folder if keep else None, ledger, Counter(total, report))
        for some in rounds(lambda done: task.observed(done, aim)):
            task.do(some, crew, interruption, retry)
        result = Sweep.of(base, ledger.results, folder)
    if folder is not None and part is None:
        for text in write_tables(result, folder)[1]:
            warn(text)
    own = [name for name, function in observables.items() if function is not None]
    for one in without_value(result.points, own):
        if one.cause:
            warn(f"no value of {one}")
    return result


Measured = Callable[[Sequence[Site]], Sequence[Target]]


def _single(found: Sequence[Site]) -> Callable[[Measured], Iterator[Sequence[Site]]]:
    """All points in one round."""
    return lambda measured: iter([found])


def _check_output(
    output: str | Path | None, keep: bool, part: Shard | None, overwrite: bool
) -> None:
    if output is None and keep:
        raise SceneError("keep", keep, "needs a folder: give output (-o)")
    if output is None and part:
        raise SceneError("shard", str(part), "needs a folder: give output (-o)")
    if overwrite and part:
        raise SceneError("overwrite", True, "goes without shard; remove the folder before the jobs")


def _refuse_with_adaptive(given: Mapping[str, Any]) -> None:
    for name, value in given.items():
        if value is not None:
            allowed = "goes without adaptive, which places all points one round after the other"
            raise SceneError(name, value, allowed)


def _target(target: str | None, observables: Mapping[str, Observable | None]) -> str:
    """The observable whose changes place points."""
    if target is None:
        return next(iter(observables))
    if target not in observables:
        raise SceneError("target", target, f"must be observed: {', '.join(observables)}")
    return target


@contextmanager
def _ledger(
    base: Scene, folder: Path | None, part: Shard | None, overwrite: bool
) -> Iterator[Ledger]:
    """The ledger of a folder, or one in memory."""
    if folder is None:
        yield Ledger({})
        return
    request = portable(flat_keys(base.to_mapping()))
    file = RESULTS if part is None else part.file
    with opened(folder, request, what=WHAT, overwrite=overwrite, file=file) as ledger:
        yield ledger
