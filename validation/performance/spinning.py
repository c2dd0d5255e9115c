"""A chain of 4a that spins: bases that spin with it, and bases that do not."""

from __future__ import annotations

import math
from unittest import mock

import numpy as np

from nrchain import Trajectory, load_scene, simulate
from nrchain.motion.charts import ChartedChain
from validation.performance.scenes import PROJECT
from validation.report.recorder import Recorder

OMEGA = 363 / 5 * 1e4 / 10.0**5
"""Ω₀ = 363 a⁴V/5d⁵ of 4a at V = 10⁴, in radians per unit time."""


BY_CVODE = {"run.integrator": "cvode", "run.rtol": 2e-6, "run.atol": 2e-6}
"""Steps in charts whose bases stay for many steps; Radau makes a chart for every step."""


class _Still(ChartedChain):
    """Charts whose bases drift and do not spin."""

    def set_base(
        self,
        time: float,
        positions: np.ndarray,
        frames: np.ndarray,
        drift: np.ndarray,
        spin: float,
    ) -> None:
        super().set_base(time, positions, frames, drift, 0.0)


def compare(recorder: Recorder) -> None:
    """A 4a chain that spins through 1000 revolutions, against the buckling scene."""
    turns = 50 if recorder.quick else 1000
    bend = _counted("buckling", turns).counters
    isotropic = _counted("spiral-left", turns, "isotropic").counters
    spun = _counted("spiral-left", turns, "paper").counters
    with mock.patch("nrchain.run.preparation.ChartedChain", _Still):
        still = _counted("spiral-left", turns, "paper").counters
        apart = _counted("spiral-left", 10, "paper").positions[-1]
    apart = apart - _counted("spiral-left", 10, "paper").positions[-1]
    rows = [
        (name, int(found["evaluations"]), int(found["steps"]), found["wall_time"])
        for name, found in (
            ("buckling, for as long", bend),
            ("spiral, isotropic measures", isotropic),
            ("spiral, the paper's measures", spun),
            ("spiral, the paper's measures, bases that do not spin", still),
        )
    ]
    recorder.table(
        "Revolutions",
        ["Scene", "Right-hand sides", "Steps", "Seconds"],
        rows,
        f"Shipped scenes of 20 spheres by CVODE, {turns} revolutions. On a "
        "spinning chain the paper's measures of twist and bend oscillate; the isotropic ones do "
        "not.",
    )
    recorder.bound(
        f"right-hand sides over those of the buckling scene, {turns} revolutions, isotropic",
        isotropic["evaluations"] / bend["evaluations"],
        most=5.0,
        source=PROJECT,
    )
    recorder.benchmark(
        "bases that spin with the chain, the paper's measures",
        spun["wall_time"],
        still["wall_time"],
        what=f"{turns} revolutions: {spun['evaluations']:.0f} right-hand sides against "
        f"{still['evaluations']:.0f} with bases that do not spin",
    )
    if not recorder.quick:
        recorder.bound(
            "times faster than with bases that do not spin, the paper's measures",
            still["wall_time"] / spun["wall_time"],
            least=5.0,
            source=PROJECT,
        )
    recorder.bound(
        "largest distance between the two after 10 revolutions (a)",
        np.linalg.norm(apart, axis=1).max(),
        most=1e-4,
        source="the same physics",
    )


def _counted(scene: str, turns: int, measure: str = "paper") -> Trajectory:
    """Run a shipped scene for the time of ``turns`` revolutions of the spiral of 20 spheres."""
    span = 2 * math.pi * turns / (OMEGA * (1 - 1 / 20))
    changes = {"elasticity.measure": measure, "run.end": span, "run.snapshots": 2}
    return simulate(load_scene(scene, **changes, **BY_CVODE))
