"""simulate and resume: from a scene, or from the file of a run, to a trajectory."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import numpy as np

from nrchain.errors import SceneError
from nrchain.exchange.start import StartingFrame, StartLike, starting_frame
from nrchain.notices import Report, warn
from nrchain.outcome import Settled, Stop
from nrchain.planning.choice import Choice
from nrchain.progress import updates
from nrchain.run.folders import new_folder
from nrchain.run.interruption import Interruption, deferred
from nrchain.run.later_end import extend
from nrchain.run.output import output_file
from nrchain.run.preparation import Start, check_start, prepare
from nrchain.run.recording import Progress, snapshot_times
from nrchain.run.resumption import start_from_checkpoint
from nrchain.run.verification import verified
from nrchain.scene.scene import Scene
from nrchain.trajectory.file import locate, lock_existing
from nrchain.trajectory.recorder import MemoryRecorder, Recorder
from nrchain.trajectory.trajectory import Trajectory
from nrchain.trajectory.writer import TrajectoryWriter


def simulate(
    scene: Scene,
    *,
    output: str | Path | None = None,
    overwrite: bool = False,
    progress: bool | Callable[[Progress], None] | None = None,
    positions: np.ndarray | None = None,
    frames: np.ndarray | None = None,
    choice: Choice | None = None,
    start: StartLike | None = None,
) -> Trajectory:
    """Integrate v = F/γ_T + Σu, ω = T/γ_R + Σw from the start of a scene to its end.

    Parameters
    ----------
    scene
        What to simulate; see :func:`nrchain.load_scene`.
    output
        File (``.h5``, ``.hdf5`` or ``.h5md``), or directory for a ``trajectory.h5``, which is made
        if need be, to write as the run goes; none: memory only.
    overwrite
        Whether an existing file may be replaced.
    progress
        True shows a bar in a terminal or a notebook, on standard error. A function is called with
        a :class:`Progress` at every snapshot.
    positions, frames
        (N, 3) and (N, 3, 3): poses to start from in place of the scene's. If one of the two is left
        out, that of the scene's own start is used. Positions of a periodic chain may be wrapped:
        each link takes the image nearest to its rest length along x, and the trajectory holds the
        unwrapped chain. Frames rounded to 32 bits are replaced by the nearest rotations.
    choice
        What the effects of the scene leave out, as :func:`nrchain.auto.choose` found it: kept
        beside the scene, and watched. A scene with ``effects = "auto"`` makes its own.
    start
        What to start from in place of the scene's start: a snapshot, a trajectory (its last
        snapshot), ``(positions, frames)``, or the path of a run or of an exported file, also with
        the number of a snapshot, ``"runs/mine:50"`` or ``"mine.gsd:-1"``. The time starts at 0
        again. The trajectory's ``provenance``, and its file, say what it started from. See
        :func:`nrchain.export`.

    Returns
    -------
    Trajectory
        With ``status`` "completed", or "stopped" with a ``cause`` and a ``reason`` when the run
        cannot go on or has spent its budget. With ``run.until = "settled"``, a completed run that
        ended before ``run.end`` has a ``reason`` too. A stopped run keeps what it reached; its last
        snapshot holds the poses at the stop.

    Warns
    -----
    SceneWarning
        For a start that is straight, or barely above ``run.atol``, on a chain whose waves grow, and
        for spheres held or pushed against a background flow with one-body friction. Whether the
        chain holds is not judged here: see :func:`nrchain.describe`.

    Raises
    ------
    SceneError
        Before any time is spent, for a start that cannot be simulated, such as wrapped positions
        of which the image is not clear.
    TrajectoryError
        When ``output`` exists and ``overwrite`` is not set, or cannot be made. If the file is
        removed or replaced during the run, what was reached is returned without a ``path``. A file
        that is cut short during the run is lost.
    KeyboardInterrupt
        On Ctrl-C and SIGTERM, once the step under way is done and the file is closed in order.

    >>> from nrchain import load_scene
    >>> run = simulate(load_scene("buckling", **{"chain.particles": 4, "run.end": 1.0}))
    >>> run.status, run.positions.shape
    ('completed', (101, 4, 3))
    """
    # a path that is taken is refused before any time is spent
    place = None if output is None else output_file(output, overwrite)
    if start is None:
        begin = check_start(scene, positions, frames, choice)
    elif positions is None and frames is None:
        begin = _start_from(starting_frame(start, scene), scene, choice)
    else:
        allowed = "takes the place of positions and frames; remove one or the other"
        raise SceneError("start", start, allowed)
    with updates(progress, Progress.shown) as update:
        if place is None:
            return simulate_in_memory(begin, update)
        folder, path = place
        with new_folder(folder) if folder else nullcontext():
            return simulate_to_file(begin, path, overwrite=overwrite, progress=update)


def simulate_in_memory(
    start: Start,
    progress: Callable[[Progress], None] | None = None,
    report: Report = warn,
    interruption: Interruption | None = None,
) -> Trajectory:
    """The trajectory from a checked start; ``report`` gets the text of every warning.

    The run stops at a signal or, if it is given, at the ``interruption`` instead.
    """
    _report(start, report)
    memory = MemoryRecorder(start.scene)
    with _stopped_by(interruption) as interruption:
        stop = _run(start, memory, progress, interruption, report)
    return memory.trajectory(start.scene, stop, start.choice, start.provenance)


def simulate_to_file(
    start: Start,
    path: Path,
    *,
    overwrite: bool = False,
    progress: Callable[[Progress], None] | None = None,
    report: Report = warn,
    interruption: Interruption | None = None,
) -> Trajectory:
    """As :func:`simulate_in_memory`, into the file at ``path``."""
    _report(start, report)
    times = snapshot_times(start.scene)
    with (
        _stopped_by(interruption) as interruption,
        TrajectoryWriter(
            path,
            start.scene,
            times,
            overwrite=overwrite,
            choice=start.choice,
            provenance=start.provenance,
        ) as writer,
    ):
        return _finish(writer, _run(start, writer, progress, interruption, report))


def resume(
    path: str | Path,
    *,
    unwatched: bool = False,
    until: float | None = None,
    progress: bool | Callable[[Progress], None] | None = None,
) -> Trajectory:
    """Continue a run that was killed, interrupted or stopped, from its last checkpoint to its end.

    The result is that of the uninterrupted run, bit for bit. A run that is complete is returned
    as it is. The budget of the scene holds for what is new.

    ``until`` gives the run a later end, also if it is complete: a whole number of the intervals
    between its snapshots. Its file then has that end in its scene, and the one before in its
    provenance. It repeats the steps since its last checkpoint, 2000 at most. With ``radau`` the
    result is that of a run with the later end, bit for bit at times that are the same numbers,
    unless the chain hardly moves where it restarts. The first step of ``cvode`` after a restart
    depends on the end: the results differ within the tolerance.

    ``progress`` is that of :func:`simulate`.

    A run keeps its effects to its end. One that stopped because of what ``effects = "auto"`` left
    out continues only with ``unwatched``: from there on no bound holds, and its ``choice`` says so.

    Raises :class:`~nrchain.errors.TrajectoryError` for a file that cannot be continued, and for a
    run that stopped because of what was left out, without ``unwatched``, and
    :class:`~nrchain.errors.SceneError` for an end that is not later.

    >>> import tempfile
    >>> from nrchain import load_scene
    >>> short = load_scene("buckling", **{"run.max_steps": 5, "run.end": 5.0})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     first, second = simulate(short, output=folder), resume(folder)
    >>> bool(second.time[-1] > first.time[-1])
    True
    """
    done = Trajectory.open(path)
    if done.status == "completed" and until is None:
        return done
    with lock_existing(locate(path)) as lock:
        # what it holds now that nobody else writes to it
        done = Trajectory.open(path)
        start = start_from_checkpoint(done, unwatched)
        if until is not None:
            start = start_from_checkpoint(extend(done, until, unwatched), unwatched)
        assert done.path is not None
        with (
            updates(progress, Progress.shown) as update,
            deferred() as interruption,
            TrajectoryWriter.reopen(done.path, lock, start.choice) as writer,
        ):
            return _finish(writer, _run(start, writer, update, interruption))


def _start_from(source: StartingFrame, scene: Scene, choice: Choice | None) -> Start:
    """The checked start of a scene at the poses of a source, which errors name."""
    try:
        return check_start(scene, source.positions, source.frames, choice, source.provenance)
    except SceneError as error:
        raise source.refusal(error) from error


def _stopped_by(interruption: Interruption | None) -> AbstractContextManager[Interruption]:
    return deferred() if interruption is None else nullcontext(interruption)


def _report(start: Start, report: Report) -> None:
    for text in start.warnings:
        report(text)


def _run(
    start: Start,
    recorder: Recorder,
    progress: Callable[[Progress], None] | None,
    interruption: Interruption,
    report: Report = warn,
) -> Stop | Settled | None:
    with (
        interruption.second_at_once(),
        verified(start, recorder, interruption, report) as records,
    ):
        return prepare(start, records, progress, interruption, report).run()


def _finish(writer: TrajectoryWriter, stop: Stop | Settled | None) -> Trajectory:
    """Write how the run ended and read the file back, even if it has lost its name meanwhile."""
    if stop is None:
        writer.mark("completed")
    elif isinstance(stop, Settled):
        writer.mark("completed", stop.reason)
    else:
        writer.mark("stopped", stop.reason, stop.cause)
    return writer.read()
