"""φ(t) = (1 − 1/N) Ω₀ t, and charts near their half turn: large rotations.

A straight chain of N spheres turns about itself: every sphere but those at the ends is turned by
two neighbours, and the torques of the links sum to nothing over the chain, so that the mean angle
is exact at all times. A chart is singular at a half turn from its base. Every chart starts at its
base, so only a large step reaches the half turn; the integrator here takes such a step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numpy as np

from nrchain import Cause, Scene, load_scene, simulate
from nrchain.geometry import lie
from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators import INTEGRATORS
from nrchain.motion.integrators.base import Integrator
from nrchain.motion.model import Model
from nrchain.planning.checked_start import starting_poses

FAR = 1e4
"""Radians to turn through."""

SHY = 1e-9
"""Distance from a half turn, in radians."""

FIRST_LEAP = 3
"""Number of steps before the integrator leaps."""


@dataclass(frozen=True)
class Spin:
    """The mean angle by which the spheres turned about e₁, the exact one, and their difference.

    ``counted`` is summed from snapshot to snapshot; ``tolerance`` is that of a step.
    """

    counted: float
    exact: float
    tolerance: float


def spin(integrator: str) -> Spin:
    """Rotation of a straight chain of five through more than 10⁴ rad, from its snapshots."""
    changes: dict[str, Any] = {"chain.particles": 5, "start.shape": "straight", "run.end": 2000.0}
    changes |= {"run.integrator": integrator, "run.snapshots": 6001}
    scene = load_scene("spiral-left", **changes)
    run = simulate(scene)
    e2, e3 = run.frames[:-1, :, 1], run.frames[:-1, :, 2]
    ahead = run.frames[1:, :, 1]
    angles = np.arctan2((ahead * e3).sum(axis=-1), (ahead * e2).sum(axis=-1))
    a, d, count = scene.chain.radius, scene.chain.spacing, scene.chain.particles
    strength = scene.slip.modes["4a"].strength
    assert isinstance(strength, float)
    rate = -363.0 * a**4 * strength / (5.0 * d**5) * (1.0 - 1.0 / count)
    exact = float(rate * run.time[-1])
    tolerance = scene.run.atol + scene.run.rtol * abs(exact)
    return Spin(float(angles.sum(axis=0).mean()), exact, tolerance)


def chart_near_its_half_turn() -> tuple[float, float]:
    """(error of the frames, error of the rates) of a chain whose base is π − 1e-9 behind.

    Rates are mapped back to twists and compared with those in a chart about the poses themselves.
    """
    scene = load_scene("buckling", **{"chain.ends": "free", "start.amplitude": 1.0})
    positions, frames = starting_poses(scene)
    here, there = ChartedChain(Model(scene)), ChartedChain(Model(scene))
    here.rebase(0.0, positions, frames)
    theta = np.array([0.0, 0.0, 2.0 * np.tan(0.5 * (np.pi - SHY))])
    cosine, sine = -np.cos(SHY), np.sin(SHY)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    # R = cay(θ) takes the base frames, whose rows are turned back, to those of the chain
    there.set_base(0.0, positions, frames @ turn, here.drift, here.spin)
    y = np.tile([0.0, 0.0, 0.0, *theta], scene.chain.particles)
    reached = there.poses(0.0, y)[1].copy()
    rates, still = np.empty_like(y), np.empty_like(y)
    there.rates(0.0, y, rates)
    here.rates(0.0, np.zeros_like(y), still)
    tangent = np.empty((3, 3))
    lie.tangent(theta, tangent)
    twists = rates.reshape(-1, 6).copy()
    twists[:, 3:] = twists[:, 3:] @ tangent.T
    return float(np.abs(reached - frames).max()), float(np.abs(twists.ravel() - still).max())


class Leap(Integrator):
    """Stands still for a few steps, then turns the chain by π − 1e-9 about z in one."""

    name, order = "leap", 1
    growth_limit = 1.0

    def start(self, time: float, y: np.ndarray) -> None:
        self.begin = self.reached = time

    def step(self) -> float:
        self.steps += 1
        self.begin, self.reached = self.reached, self.reached + 0.01 * self.end
        return self.reached

    def at(self, time: float) -> np.ndarray:
        y = np.zeros(self.chain.dimension)
        if self.steps > FIRST_LEAP:
            part = (time - self.begin) / (self.reached - self.begin)
            y[5::6] = 2.0 * np.tan(0.5 * part * (np.pi - SHY))
        return y


def leap(scene: Scene) -> Cause | None:
    """How a run of the scene ends if its integrator leaps to the half turn."""
    with patch.dict(INTEGRATORS, {"cvode": f"{__name__}:Leap"}):
        return simulate(load_scene(scene, **{"run.integrator": "cvode"})).cause
