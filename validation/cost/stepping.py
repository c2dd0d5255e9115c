"""Tolerances from 1e-3 to 1e-11 for each integrator: global error against processor time.

The reference of a scene is Radau IIA at 1e-12; at equal tolerance its error is hundreds of times
below that of backward differences. Its own error is below its distance from the same scheme at
1e-11. CVODE at 2e-11, another method in other charts, is an independent check.
"""

from __future__ import annotations

import numpy as np

from nrchain import Scene, Trajectory, load_scene, scene_names, simulate
from nrchain.accuracy.timing import distance, measure_all, run_timed
from validation.cost import figures
from validation.cost.results import TARGETS, Map, Setting, marks
from validation.report.recorder import Recorder

INTEGRATORS = ("cvode", "radau", "scipy-bdf")
TOLERANCES = tuple(10.0**-k for k in range(3, 12))
REFERENCE = "radau", 1e-12
BAR = 1e-4
"""Largest global error, in radii and radians, of a shipped scene at the default tolerances."""

SCENES: dict[str, dict[str, float]] = {
    "buckling": {},
    "helix-left": {},
    "wave": {},
    "spiral-left": {"run.end": 15.0},
}
STARTS = 10
SOURCE = "reference run far below it"


def stepped(scene: Scene, scheme: str, tolerance: float) -> Scene:
    """The scene with this integrator, rtol and atol."""
    keys = {"run.integrator": scheme, "run.rtol": tolerance, "run.atol": tolerance}
    return load_scene(scene, **keys)


def compare(recorder: Recorder) -> None:
    """Record the map of each scene, the accuracy of the defaults, and conserved quantities."""
    _defaults(recorder)
    names = ("buckling", "wave") if recorder.quick else tuple(SCENES)
    maps = []
    for name in names:
        recorder.step(f"stepping: {name}")
        maps.append(work_precision(recorder, name, load_scene(name, **SCENES[name])))
    _table(recorder, maps)
    recorder.figure(
        "Stepping",
        figures.stepping(maps, TARGETS),
        "Largest global error of a run (positions in radii or frames in radians, the larger) "
        "against its median processor time, for tolerances from 1e-3 (upper left) to 1e-11. Ring: "
        "the default. Squares: the cheapest setting within 1 %, 0.1 % and 1e-6 of a radius. Grey: "
        "error of the reference.",
    )
    _conserved(recorder)


def work_precision(recorder: Recorder, name: str, scene: Scene) -> Map:
    """Error and time of every scheme at every tolerance, and checks of the reference."""
    tolerances = TOLERANCES[::2] if recorder.quick else TOLERANCES
    scheme, tolerance = REFERENCE if not recorder.quick else ("radau", 1e-10)
    reference = simulate(stepped(scene, scheme, tolerance))
    keys = {
        f"{scheme} {tolerance:g}": (scheme, tolerance)
        for scheme in INTEGRATORS
        for tolerance in tolerances
        if not (recorder.quick and tolerance < 1e-9)
    }
    found = measure_all(
        {key: stepped(scene, *choice) for key, choice in keys.items()},
        reference,
        repeats=2 if recorder.quick else 5,
        budget=2.0 if recorder.quick else 30.0,
    )
    settings = [Setting(*keys[key], measured) for key, measured in found.items()]
    tightest = min(tolerances) if not recorder.quick else 1e-9
    second = simulate(stepped(scene, "cvode", 2e-11))
    apart = max(distance(second, reference))
    recorder.bound(
        f"{name}: two schemes at their tightest meet",
        apart,
        most=1e-8,
        source="CVODE's BDF and Radau IIA share the right-hand side, no more",
    )
    floor = found[f"radau {tightest:g}"].error
    for one in INTEGRATORS:
        errors = {s.tolerance: s.measured.error for s in settings if s.scheme == one}
        ratio = errors[1e-3] / errors[1e-9]
        recorder.bound(
            f"{name}, {one}: error falls from 1e-3 to 1e-9 by", ratio, least=1e4, source=SOURCE
        )
    return Map(name, settings, floor)


def _defaults(recorder: Recorder) -> None:
    """Error of every shipped scene at the default tolerances."""
    rows, worst = [], 0.0
    tolerance = 1e-8 if recorder.quick else 1e-9
    for name in scene_names():
        recorder.step(f"default tolerances: {name}")
        scene = load_scene(name)
        run, cost = run_timed(scene)
        reference = simulate(stepped(scene, "radau", tolerance))
        position, frame = distance(run, reference)
        shifted = np.linalg.norm(run.positions - run.positions[0], axis=-1).max()
        recorder.bound(
            f"{name}: global error at the default tolerances, in a and rad",
            max(position, frame),
            most=BAR,
            source=f"Radau IIA at {tolerance:g}, whose error is below 1e-8",
        )
        worst = max(worst, position, frame)
        rows.append((name, position, frame, float(shifted), cost.seconds, *cost.work[:3]))
    if not recorder.quick:
        errors = [_of_start(seed, tolerance) for seed in range(STARTS)]
        recorder.bound(
            f"buckling from {STARTS} random starts: largest error at the default tolerances",
            max(errors),
            most=BAR,
            source="start.seed = 0 to 9",
        )
    recorder.table(
        "Accuracy of the default tolerances",
        ["Scene", "Positions [a]", "Frames [rad]", "Largest path [a]", "Seconds", "Steps",
         "Right-hand sides", "Jacobians"],
        rows,
        f"Largest global error over all spheres and snapshots of the shipped scenes with rtol = "
        f"atol = 1e-7, against Radau IIA at {tolerance:g}; the target is {BAR:g}. One run each; "
        "seconds of processor time.",
        first_page=True,
    )  # fmt: skip


def _of_start(seed: int, tolerance: float) -> float:
    scene = load_scene("buckling", **{"start.seed": seed})
    return max(distance(simulate(scene), simulate(stepped(scene, "radau", tolerance))))


def _table(recorder: Recorder, maps: list[Map]) -> None:
    rows = [
        (
            one.name, s.scheme, s.tolerance, s.measured.position, s.measured.frame,
            s.measured.median, *s.measured.work[:3], marks(one, s),
        )
        for one in maps
        for s in one.settings
    ]  # fmt: skip
    recorder.table(
        "Stepping",
        ["Scene", "Integrator", "Tolerance", "Positions [a]", "Frames [rad]", "Seconds", "Steps",
         "Right-hand sides", "Jacobians", "Marks"],
        rows,
        "Global error of positions and frames, median processor time of interleaved repetitions, "
        "and work, by integrator and tolerance (rtol = atol). spiral-left is run to t = 15.",
    )  # fmt: skip


def _conserved(recorder: Recorder) -> None:
    """Drift of the centre of mass of a free passive chain, Σ F = 0, and orthonormal frames."""
    recorder.step("conserved structure")
    scene = load_scene("passive", **{"chain.ends": "free", "elasticity.ratio": 1e7})
    rows, spin = [], load_scene("spiral-left", **{"run.end": 15.0})
    for scheme in INTEGRATORS:
        for tolerance in (1e-3, 1e-7) if recorder.quick else (1e-3, 1e-5, 1e-7, 1e-9, 1e-11):
            rest = simulate(stepped(scene, scheme, tolerance))
            turned = simulate(stepped(spin, scheme, tolerance))
            drift = _drift(rest)
            bent = max(_bent_frames(rest), _bent_frames(turned))
            rows.append((scheme, tolerance, drift, bent))
    recorder.bound(
        "frames stay orthonormal at every tolerance, max |FFᵀ − 1|",
        max(row[3] for row in rows),
        most=1e-12,
        source="every chart is one of SE(3)",
    )
    for scheme in INTEGRATORS:
        recorder.bound(
            f"{scheme}: drift of a free passive chain's centre of mass, over the tolerance",
            max(row[2] / row[1] for row in rows if row[0] == scheme),
            most=10.0,
            source="Σ F_i = 0",
        )
    recorder.table(
        "What the schemes conserve",
        ["Integrator", "Tolerance", "Centre of mass [a]", "Orthonormality"],
        rows,
        "Drift of the centre of mass of a free passive chain over its run, and max |FFᵀ − 1| on "
        "that chain and on spiral-left over 17 turns. Frames are orthonormal by construction; the "
        "centre is at rest to the tolerance, because a chart is not linear in it.",
    )


def _drift(run: Trajectory) -> float:
    centre = run.positions.mean(axis=1)
    return float(np.linalg.norm(centre - centre[0], axis=1).max())


def _bent_frames(run: Trajectory) -> float:
    gram = np.einsum("tnak,tnbk->tnab", run.frames, run.frames)
    return float(np.abs(gram - np.eye(3)).max())
