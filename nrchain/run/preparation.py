"""Scene → checked start → model → charts → integrator → watches → loop: a scene becomes a run.

This is the one place where a run reads its scene. Whatever steps, watches or records gets the
quantities that it needs by name.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nrchain.motion.charts import ChartedChain
from nrchain.motion.contact import PoseLimits
from nrchain.motion.definiteness import CutFriction, is_cut
from nrchain.motion.integrators import find_integrator, resolve_name
from nrchain.motion.integrators.base import Integrator
from nrchain.motion.model import Model
from nrchain.motion.pose_model import PoseModel
from nrchain.notices import Report
from nrchain.planning.checked_start import starting_poses, with_start
from nrchain.planning.choice import Choice, as_keys, full_scene
from nrchain.planning.missing_stokeslets import stokeslet_warning
from nrchain.run.budget import Budget
from nrchain.run.counters import Counters
from nrchain.run.interruption import Interruption
from nrchain.run.loop import Loop
from nrchain.run.recording import Progress, Recording, snapshot_times
from nrchain.run.watches import Watches
from nrchain.scene.chain_sections import LEAST_TOLERANCE
from nrchain.scene.scene import Scene
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.trajectory.provenance import FROM_SCENE, Provenance, array_step
from nrchain.trajectory.recorder import Recorder
from nrchain.types import Poses
from nrchain.watch.friction import FrictionWatch
from nrchain.watch.growth import GrowthWatch
from nrchain.watch.guard import Guard
from nrchain.watch.neglected import CHECKS, NeglectedWatch
from nrchain.watch.seed import seed_warning
from nrchain.watch.settled import SettledWatch


class Snapshots(NamedTuple):
    """Times (T,), positions (T, N, 3) and frames (T, N, 3, 3)."""

    time: np.ndarray
    positions: np.ndarray
    frames: np.ndarray


@dataclass(frozen=True)
class Start:
    """What a run starts from: a scene that names its effects, and checked poses or a checkpoint.

    Attributes
    ----------
    choice
        What the effects of the scene leave out, where they were chosen.
    warnings
        Texts to be reported before the run.
    warned_of_straight
        Whether one of them says that the chain is straight, or nearly so, although it buckles.
    repeated_steps
        Steps of an earlier run that this one repeats, at most.
    earlier
        The snapshots before the checkpoint.
    provenance
        Where the poses came from, if not from the scene.
    """

    scene: Scene
    begin: Poses | Checkpoint
    choice: Choice | None = None
    warnings: tuple[str, ...] = ()
    warned_of_straight: bool = False
    repeated_steps: float = 0
    earlier: Snapshots | None = None
    provenance: Provenance = FROM_SCENE


def check_start(
    scene: Scene,
    positions: np.ndarray | None = None,
    frames: np.ndarray | None = None,
    choice: Choice | None = None,
    provenance: Provenance | None = None,
) -> Start:
    """The start of a scene, at its own poses or at those given; effects are chosen if it says so.

    ``provenance`` says where given poses come from.

    Raises :class:`~nrchain.errors.SceneError` for a start that cannot be simulated.
    """
    poses = starting_poses(scene, positions, frames)
    if positions is not None or frames is not None:
        scene = with_start(scene, *poses)
        provenance = provenance or FROM_SCENE.then(array_step(*poses))
    if scene.effects == "auto":
        from nrchain.planning.auto import choose

        scene, choice = choose(scene, poses)
    straight = seed_warning(scene, *poses)
    # where effects were chosen, what they leave out is bounded
    held = stokeslet_warning(scene, *poses) if choice is None else ""
    warnings = tuple(filter(None, (straight, held)))
    known = provenance or FROM_SCENE
    return Start(scene, poses, choice, warnings, bool(straight), provenance=known)


def prepare(
    start: Start,
    recorder: Recorder,
    progress: Callable[[Progress], None] | None,
    interruption: Interruption,
    report: Report,
) -> Loop:
    """The loop of a run, ready to go: the poses of a fresh start are recorded, as a checkpoint too.

    ``report`` gets the text of what the run warns of on its way.
    """
    scene, begin = start.scene, start.begin
    earlier, snapshot = (
        (begin.counters, begin.snapshot) if isinstance(begin, Checkpoint) else ({}, 0)
    )
    chain = ChartedChain(Model(scene))
    integrator = make_integrator(scene, chain)
    counters = Counters(chain, integrator, earlier)
    recording = Recording(recorder, snapshot_times(scene), counters, progress, snapshot)
    budget = Budget(scene.run.max_steps, scene.run.max_seconds, interruption, start.repeated_steps)
    if isinstance(begin, Checkpoint):
        time, poses = begin.time, (begin.positions, begin.frames)
        chain.set_base(time, *poses, begin.drift, begin.spin)
    else:
        time, poses = 0.0, begin
        chain.rebase(time, *poses)
        recording.write(time, poses)
        recording.write_checkpoint(time, chain)
    watches = make_watches(start, poses, integrator, report)
    return Loop(chain, integrator, watches, recording, counters, budget, time, poses)


def make_integrator(scene: Scene, chain: ChartedChain) -> Integrator:
    """The integrator of a scene: ``atol`` in radii and radians, ``rtol`` of the coordinates y.

    The error of a step is held below the ``share`` of the integrator in the norm √mean((e/w)²) over
    all coordinates of all spheres, w = ``atol`` + ``rtol`` |y|: y is how far a sphere has moved and
    turned from a base that drifts and spins as the chain does, in the units of ``atol``.
    """
    run = scene.run
    scheme = find_integrator(resolve_name(run.integrator, chain.model.is_near))
    atol, rtol = (step_tolerance(scheme, tolerance) for tolerance in (run.atol, run.rtol))
    pose = np.repeat([atol * scene.chain.radius, atol], 3)
    return scheme(chain, run.end, rtol, np.tile(pose, chain.dimension // 6))


def step_tolerance(scheme: type[Integrator], tolerance: float) -> float:
    """What a step may err by, for a run of this tolerance: no less than rounding allows."""
    return max(scheme.share * tolerance, min(tolerance, LEAST_TOLERANCE))


def make_watches(start: Start, poses: Poses, integrator: Integrator, report: Report) -> Watches:
    """What watches the steps and snapshots of a run that is at these poses."""
    scene = start.scene
    growth = GrowthWatch(
        integrator,
        # a chain of its own: the model of the integrator keeps what it was last linearised about
        lambda: ChartedChain(Model(scene)),
        report,
        atol=step_tolerance(type(integrator), scene.run.atol),
        radius=scene.chain.radius,
        spacing=scene.chain.spacing,
        periodic=scene.chain.ends == "periodic",
        warned_of_straight=start.warned_of_straight,
    )
    friction = None
    if is_cut(scene):
        cut = CutFriction(scene)
        friction = FrictionWatch(cut.neighbours, cut.least_mobility)
    neglected = _neglected_watch(scene, start.choice, integrator.chain.model)
    guard = Guard(PoseLimits.of(scene), poses[0])
    return Watches(guard, growth, friction, neglected, _settled_watch(start, poses))


def _settled_watch(start: Start, poses: Poses) -> SettledWatch | None:
    """The watch for a chain that settles, which has seen all snapshots so far."""
    scene = start.scene
    nothing_moves = scene.chain.ends == "clamped" and scene.chain.particles == 2
    if scene.run.until != "settled" or nothing_moves:
        return None
    earlier = start.earlier
    if earlier is None:
        earlier = Snapshots(np.zeros(1), poses[0][None], poses[1][None])
    watch = SettledWatch(scene, (earlier.positions[0], earlier.frames[0]))
    for time, *seen in zip(*earlier, strict=True):
        watch.look(float(time), (seen[0], seen[1]))
    return watch


def _neglected_watch(
    scene: Scene, choice: Choice | None, model: PoseModel
) -> NeglectedWatch | None:
    """The watch on what a choice leaves out; None where that is nothing, or is not watched."""
    if choice is None or not choice.left_out or math.isfinite(choice.watched_until):
        return None
    full, end = full_scene(scene), scene.run.end
    return NeglectedWatch(
        (model, Model(full)),
        lambda time: choice.allowed(time, end),
        radius=scene.chain.radius,
        interval=end / CHECKS,
        remedy=as_keys(scene, full),
    )
