"""Estimates of a plan before a run, against runs with and without each effect."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from nrchain import Scene, SceneError, Trajectory, estimate, load_scene, simulate
from nrchain.motion.model import Model
from nrchain.planning.effect_changes import Change
from nrchain.planning.shared_steps import largest_distance
from nrchain.watch.neglected import velocity_difference
from validation.effects.scenes import completed, random_scene
from validation.report.periodic_waves import PERIODIC, rate_of
from validation.report.recorder import Recorder

SCENES, QUICK_SCENES = 48, 3
TIGHT = 1e-9
NOISE = 10.0
"""Differences count if they exceed this multiple of the error of the run, and the resolution of a
plan."""

TIMED = 8
"""Number of scenes whose estimates and runs are timed."""

FINE = (estimate.SAMPLES - 1) * 2 ** (estimate.EARLY - 1) + 1
"""Snapshots of the run whose velocities are compared: all times at which a probe samples."""

FACTOR = 2.0

QUANTITIES = ("displacement", "turn", "velocity")


@dataclass(frozen=True)
class Case:
    """One effect of one scene: estimated and measured quantities, and their noise."""

    seed: int
    effect: estimate.Estimate
    measured: dict[str, float]
    estimated: dict[str, float]
    noise: dict[str, float]
    stop_foreseen: bool | None

    def ratio(self, quantity: str) -> float | None:
        """Estimated over measured; None if the measured value is below the noise."""
        measured = self.measured[quantity]
        if not measured > self.noise[quantity]:
            return None
        return self.estimated[quantity] / measured


def compare(recorder: Recorder) -> None:
    """Record the estimates of plans against the runs."""
    cases: list[Case] = []
    planned = ran = replaced = 0.0
    count = QUICK_SCENES if recorder.quick else SCENES
    for seed in range(count):
        recorder.step(f"estimates: scene {seed + 1} of {count}")
        scene = completed(random_scene(seed))
        began = clock.process_time()
        found = estimate.estimate_effects(scene)
        if seed < TIMED:
            planned += clock.process_time() - began
            ran += _seconds(scene)
            replaced += sum(_seconds(one.change.scene) for one in found.estimates)
        cases += _measure(seed, scene, found)
    _record(recorder, count, cases, (planned / ran, planned / (ran + replaced)))


def _measure(seed: int, scene: Scene, found: estimate.Estimates) -> list[Case]:
    """Run the scene with and without each effect, to the time of each estimate."""
    ends: dict[float, tuple[Trajectory, float, float]] = {}
    whole = _run(scene, found.probed, TIGHT, FINE)
    cases = []
    for one in found.estimates:
        if one.until == 0.0:
            continue
        if one.until not in ends:
            run = _run(scene, one.until, TIGHT)
            own = simulate(load_scene(scene, **{"run.end": one.until, "run.snapshots": 2}))
            ends[one.until] = (run, *_apart(run, own))
        run, blur, twist = ends[one.until]
        other = _run(one.change.scene, one.until, TIGHT)
        displacement, turn = _apart(run, other)
        velocity = _largest_velocity(scene, one.change, whole)
        cases.append(
            Case(
                seed,
                one,
                {"displacement": displacement, "turn": turn, "velocity": velocity},
                {
                    "displacement": one.displacement,
                    "turn": one.turn,
                    "velocity": one.velocity_along,
                },
                {
                    "displacement": max(NOISE * blur, estimate.RESOLUTION),
                    "turn": max(NOISE * twist, estimate.RESOLUTION),
                    "velocity": NOISE * TIGHT,
                },
                _foreseen(scene, one, other),
            )
        )
    return cases


def _run(scene: Scene, end: float, tolerance: float, snapshots: int = 2) -> Trajectory:
    keys = {"run.end": end, "run.rtol": tolerance, "run.atol": tolerance}
    keys["run.snapshots"] = snapshots
    return simulate(load_scene(scene, **keys))


def _seconds(scene: Scene) -> float:
    began = clock.process_time()
    simulate(scene)
    return clock.process_time() - began


def _apart(run: Trajectory, other: Trajectory) -> tuple[float, float]:
    """Distance in radii and angle in radians at the end; NaN if one stopped before."""
    if run.status != "completed" or other.status != "completed":
        return math.nan, math.nan
    end, other_end = ((one.positions[-1], one.frames[-1]) for one in (run, other))
    return largest_distance(end, other_end, run.scene.chain.radius)


def _largest_velocity(scene: Scene, change: Change, run: Trajectory) -> float:
    models = Model(scene), Model(change.scene)
    first = 2 ** (estimate.EARLY - 1)
    even = range(0, len(run.time), first)
    early = {2**k for k in range(estimate.EARLY)}
    looked_at = sorted({*even, *range(0, first, first // estimate.EARLY), *early})
    poses = ((run.positions[n], run.frames[n]) for n in looked_at)
    return max(velocity_difference(*models, pose, scene.chain.radius) for pose in poses)


def _foreseen(scene: Scene, one: estimate.Estimate, other: Trajectory) -> bool:
    """Whether a predicted stop happens, or a run without a predicted stop completes."""
    if one.stops:
        other = simulate(load_scene(one.change.scene, **{"run.end": scene.run.end}))
    return (other.status != "completed") == bool(one.stops)


def _record(recorder: Recorder, scenes: int, cases: list[Case], cost: tuple[float, float]) -> None:
    recorder.bound(
        "scenes whose effects are estimated",
        scenes,
        least=QUICK_SCENES if recorder.quick else 40,
        source="random modes, mixes, lengths, ends and starts with fixed seeds",
    )
    rows = []
    for quantity in QUANTITIES:
        ratios = _ratios(cases, quantity)
        hits = sum(1 / FACTOR <= r <= FACTOR for r in ratios)
        worst = max(map(_factor, ratios), default=math.nan)
        rows.append((quantity, len(ratios), hits, worst, float(np.median(np.abs(np.log(ratios))))))
        recorder.bound(
            f"{quantity}: largest factor between estimate and run",
            worst,
            most=FACTOR,
            source=f"{len(ratios)} effects above the noise",
        )
    foreseen = [case.stop_foreseen for case in cases if case.stop_foreseen is not None]
    recorder.bound(
        "fraction of effects for which the plan predicts whether the run stops",
        sum(foreseen) / len(foreseen),
        least=0.95,
        source=f"{len(foreseen)} effects",
    )
    recorder.table(
        "Estimates of effects",
        ["Contribution to", "Effects above noise", "Within a factor of 2", "Worst factor",
         "Median of |ln factor|"],
        rows,
        f"Estimates from probes at tolerance {estimate.PROBE_TOLERANCE:g} over whole runs, "
        f"against runs at {TIGHT:g}. All probes of a scene together take {cost[0]:.2g} times its "
        f"run at the default tolerance, and {cost[1]:.2g} of the runs with and without all effects "
        f"that they stand for (first {TIMED} scenes, whose runs take some hundredths of a second).",
    )  # fmt: skip
    recorder.figure(
        "estimates",
        _draw(cases),
        "Distance at the end, in radii, with and without an effect: as estimated before the run "
        "and as measured. Lines: a factor of two.",
    )


def compare_growth(recorder: Recorder) -> None:
    """Record contributions of effects to the growth rate of a wave, against simulated waves."""
    cases = [
        ({"slip.2s": 100.0}, "slip.2s", None),
        ({"slip.2s": 100.0}, "slip.neighbours", "all"),
        ({"slip.2s": 100.0}, "slip.finite_size", True),
        ({"slip.3a": -3000.0}, "slip.3a", None),
        ({"slip.3a": -3000.0}, "slip.neighbours", "all"),
        ({}, "friction.kind", "pairwise"),
    ]
    rows = []
    for keys, key, value in cases[:2] if recorder.quick else cases:
        for count in (12,) if recorder.quick else (12, 20):
            recorder.step(f"growth: {key}, N = {count}")
            (own, _), (other, _) = (
                rate_of(count, "transverse", changes) for changes in (keys, keys | {key: value})
            )
            drop = value is None
            scene = _periodic(count, keys)
            changed = load_scene(scene, **{key: value})
            wave = 2.0 * math.pi / scene.length
            predicted = estimate.growth_of(
                scene, Change(key, "drop" if drop else "add", changed), wave
            )
            measured = (own - other).real if drop else (other - own).real
            what = f"{key} {'dropped' if drop else value}, of {next(iter(keys), 'no slip')}"
            rows.append((what, count, predicted, measured, predicted and predicted / measured))
    ratios = [float(row[4]) for row in rows if row[4]]
    recorder.bound(
        "growth rate: largest factor between lattice and simulated wave",
        max(map(_factor, ratios)),
        most=FACTOR,
        source=f"{len(ratios)} effects of waves on periodic chains",
    )
    recorder.table(
        "Growth of waves",
        ["Effect", "N", "Lattice", "Simulated", "Ratio"],
        rows,
        "Contribution of an effect to the growth rate of the longest wave of a periodic chain.",
    )


def _periodic(count: int, keys: dict[str, float]) -> Scene:
    try:
        return load_scene(PERIODIC | {"chain.particles": count, "run.end": 1.0} | keys)
    except SceneError as error:
        raise ValueError(f"the periodic scene is refused: {error}") from error


def _ratios(cases: list[Case], quantity: str) -> list[float]:
    return [r for case in cases if (r := case.ratio(quantity)) is not None]


def _factor(ratio: float) -> float:
    """Factor by which the ratio differs from 1; infinite for the wrong sign."""
    return max(ratio, 1.0 / ratio) if ratio > 0.0 else math.inf


def _draw(cases: list[Case]) -> Figure:
    figure = Figure(figsize=(4.2, 4.0))
    axes = figure.subplots()
    pairs = np.array(
        [
            (case.measured["displacement"], case.estimated["displacement"])
            for case in cases
            if case.ratio("displacement") is not None
        ]
    )
    axes.loglog(*pairs.T, "o", ms=2.5, color="0.2")
    ends = np.array([pairs.min(), pairs.max()])
    for factor in (0.5, 1.0, 2.0):
        axes.loglog(ends, factor * ends, "-" if factor == 1.0 else ":", color="0.6", lw=0.8)
    axes.set(xlabel="measured [a]", ylabel="estimated [a]")
    return figure
