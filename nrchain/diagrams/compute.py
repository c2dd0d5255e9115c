"""phases: the phase diagram of a scene over two of its keys."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

from nrchain.diagrams.build import WHAT, Request
from nrchain.diagrams.diagram import PhaseDiagram
from nrchain.diagrams.plane import Axis, Plane
from nrchain.diagrams.starts import STARTS, read_starts
from nrchain.errors import SceneError
from nrchain.inputs.rules import is_number, whole
from nrchain.jobs.crew import Crew, Progress
from nrchain.jobs.ledger import Ledger, opened
from nrchain.progress import updates
from nrchain.run.ensemble import available_cores
from nrchain.run.interruption import deferred
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene

LEVELS = 2
"""How often the distance of points is halved, unless another number is given."""

MOST = 1000
"""Points with runs, unless another number is given."""


def phases(
    scene: Scene,
    x: Any,
    y: Any,
    starts: str | Iterable[str] = STARTS,
    *,
    levels: int = LEVELS,
    most: int = MOST,
    longest: float | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    output: str | Path | None = None,
    overwrite: bool = False,
    progress: bool | Callable[[Progress], None] | None = None,
) -> PhaseDiagram:
    """Which attractor a chain reaches at each (x, y), and where the straight chain turns unstable.

    The first grid is refined where neighbours end in different kinds of motion. How long a run
    goes on follows from the rates of the straight chain. The result is the same for every executor
    and number of workers.

    Parameters
    ----------
    scene
        Any ends and effects that move and rotate with the chain, without ``effects = "auto"``.
    x, y
        ``(key, low, high)`` or ``(key, low, high, points)``: a number of the scene, such as
        ``slip.2s``, its range, and the points of the first grid, by default 9. The mode of a slip
        key may be absent from the scene.
    starts
        Starts of the runs at each point: ``"random"`` and ``"planar"``, with a seed as in
        ``"random:3"``; ``"helix-left"``, ``"helix-right"``; ``"scene"`` for that of the scene.
        Their size is ``start.amplitude``. Several show whether more than one attractor is stable.
    levels
        How often the distance of points may be halved where kinds differ.
    most
        Most points with runs; boundaries are refined level by level until there are so many.
    longest
        Largest end of a run.
    executor
        What runs the jobs: threads or processes of ``concurrent.futures``. By default threads.
    workers
        Number of these threads, by default that of the cores.
    output
        Folder that keeps each result as soon as it is there. A diagram that was interrupted goes
        on from there.
    overwrite
        Whether the diagram of another request in this folder may be replaced.
    progress
        True shows a bar in a terminal or a notebook, on standard error. A function is called with
        a :class:`~nrchain.diagrams.jobs.Progress` at each result, and when an interruption
        waits for runs to end at their next step.
        Called with a :class:`~nrchain.jobs.crew.Progress` at each result.

    Raises
    ------
    SceneError
        For a key that is no number of the scene, an empty range, an unknown start, and an effect
        that does not move and rotate with the chain.
    TrajectoryError
        For a folder that holds another request, with what differs.
    KeyboardInterrupt
        On Ctrl-C and SIGTERM. What is finished is in the folder, and
        :meth:`PhaseDiagram.open` reads it.

    >>> from nrchain import load_scene
    >>> scene = load_scene("buckling", **{"chain.particles": 5})
    >>> x, y = ("slip.2s", -10.0, 10.0, 2), ("slip.3t", 0.0, 10.0, 2)
    >>> phases(scene, x, y, "random", levels=0).kinds
    ('straight',)
    """
    plane = Plane(require_scene(scene), Axis.read("x", x), Axis.read("y", y), levels)
    plane.check()
    if longest is not None and not (is_number(longest) and longest > 0.0):
        raise SceneError("longest", longest, "must be a time above 0")
    first = plane.x.count * plane.y.count
    request = Request(plane, read_starts(starts), whole(least=first)("most", most), longest)
    with (
        updates(progress, Progress.shown) as update,
        _ledger(request, output, overwrite) as ledger,
        deferred() as interruption,
        _executor(executor, workers) as chosen,
    ):

        def waits(count: int) -> None:
            if update is not None:
                update(Progress(len(ledger.results), "", count))

        crew = Crew(ledger, chosen, interruption, update, waits=waits)
        return PhaseDiagram.made(request, crew.do)


@contextmanager
def _ledger(request: Request, output: str | Path | None, overwrite: bool) -> Iterator[Ledger]:
    if output is None:
        yield Ledger({})
        return
    with opened(Path(output), request.to_mapping(), what=WHAT, overwrite=overwrite) as ledger:
        yield ledger


@contextmanager
def _executor(executor: Executor | None, workers: int | None) -> Iterator[Executor]:
    if executor is not None:
        with nullcontext(executor):
            yield executor
        return
    threads = available_cores() if workers is None else whole(least=1)("workers", workers)
    with ThreadPoolExecutor(threads) as own:
        yield own
