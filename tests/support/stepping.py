"""Scenes, a bare stepping loop and distances between poses, for the tests of integrators."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import nrchain
from nrchain.effects.base import OneBodyEffect
from nrchain.motion.chart_poses import TURN_LIMIT
from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators import find_integrator
from nrchain.motion.integrators.base import Integrator
from nrchain.motion.model import Model
from nrchain.scene.poses import initial_poses


def small(name: str, count: int, end: float, **changes):
    """A shipped scene with few spheres."""
    return nrchain.load_scene(name, **{"chain.particles": count, "run.end": end, **changes})


def tumbling(end: float = 12.0):
    """Four spheres on a soft free chain: its slip turns them in all directions, several times."""
    return nrchain.load_scene(
        {
            "chain": {"particles": 4, "spacing": 4.0},
            "elasticity": {"stretch": 2.0, "shear": 2.0, "twist": 20.0, "bend": 20.0},
            "slip": {
                "2s": 1.0,
                "3a": 2.0,
                "3t": 2.0,
                "4a": {"strength": 60.0, "axis": [1.0, 0.2, 0.0]},
            },
            "start": {"shape": "helix-left", "amplitude": 0.5},
            "run": {"end": end},
        }
    )


def periodic():
    """A periodic chain with slip that reaches two neighbours, carrying a wave."""
    return nrchain.load_scene(
        {
            "chain": {"particles": 8, "ends": "periodic"},
            "elasticity": {"ratio": 1e7},
            "slip": {"neighbours": 2, "3t": 1000.0, "3a": 500.0},
            "start": {"shape": "helix-left", "amplitude": 1.0, "wavenumber": 1},
            "run": {"end": 20.0},
        }
    )


def folded(end: float = 10.0, ends: str = "free"):
    """A hairpin of twelve spheres, with legs that repel each other along their length."""
    turns = np.radians([0, 0, 0, 0, 0, 60, 120, 180, 180, 180, 180, 180])
    axes = np.array([np.cos(turns), np.sin(turns), 0.0 * turns]).T
    positions = np.zeros((12, 3))
    positions[:5, 0], positions[7:, 0] = 3.0 * np.arange(5), 3.0 * np.arange(4, -1, -1) + 0.3
    positions[5], positions[6] = [14.9, 0.1, 0.2], [14.9, 2.3, -0.1]
    positions[7:, 1], positions[:5, 2] = 2.4, 0.1 * np.arange(5)
    across = np.cross([0.0, 0.0, 1.0], axes)
    frames = np.stack([axes, across, np.cross(axes, across)], axis=1)
    return nrchain.load_scene(
        {
            "chain": {"particles": 12, "spacing": 3.0, "ends": ends},
            "elasticity": {"ratio": 1e3},
            "slip": {"2s": 30.0},
            "steric": {"kind": "harmonic", "strength": 500.0, "range": 2.8},
            "start": {"shape": "given", "positions": positions.tolist(), "frames": frames.tolist()},
            "run": {"end": end},
        }
    )


class Probe(OneBodyEffect):
    """A twist in Python that counts how often it is asked for; ``twist(positions)`` is added.

    ``slope`` (6, 6) is what it gives as its derivative.
    """

    gives = "twist"
    placed = False

    def __init__(self, scene, twist=lambda positions: 0.0, slope=0.0):
        super().__init__(scene)
        self.twist, self.slope, self.calls, self.derivatives = twist, slope, 0, 0

    def add_twists(self, positions, frames, twists):
        self.calls += 1
        twists += self.twist(positions)

    def derivative(self, positions, frames):
        self.derivatives += 1
        return np.zeros((len(positions), 6, 6)) + self.slope


def prepare(
    scene, name: str, tolerance: float, probe: Probe | None = None, **options
) -> tuple[ChartedChain, Integrator]:
    """A chain at the start of its scene and an integrator ready to step; ``probe`` acts too."""
    model = Model(scene)
    if probe:
        model.further_effects += (probe,)
        model._twist_effects.append(probe)
        model.needs_places |= probe.placed
    chain = ChartedChain(model)
    chain.rebase(0.0, *initial_poses(scene))
    atol = np.full(chain.dimension, tolerance)
    integrator = find_integrator(name)(chain, scene.run.end, tolerance, atol, **options)
    integrator.start(0.0, np.zeros(chain.dimension))
    return chain, integrator


def poses_at(chain: ChartedChain, integrator: Integrator, time: float):
    """Copies of positions and frames at a time within the last step."""
    return tuple(array.copy() for array in chain.poses(time, integrator.at(time)))


@dataclass
class Path:
    """Poses at given times, and what it took to get there."""

    positions: np.ndarray
    frames: np.ndarray
    chain: ChartedChain
    integrator: Integrator
    turned: np.ndarray
    """Angle (N,) that each sphere turned through, added up over the steps."""


def integrate(scene, name: str, tolerance: float, times, **options) -> Path:
    """Step past the last of ``times``, leaving a chart as a run does."""
    chain, integrator = prepare(scene, name, tolerance, **options)
    poses, pending = [], list(times)
    frames = chain.base_frames
    turned = np.zeros(chain.model.count)
    while pending:
        reached = integrator.step()
        while pending and pending[0] <= reached:
            poses.append(poses_at(chain, integrator, pending.pop(0)))
        y = integrator.at(reached)
        now = poses_at(chain, integrator, reached)
        turned += angles(frames, now[1])
        frames = now[1]
        if chain.largest_turn(y) > TURN_LIMIT:
            chain.rebase(reached, *now)
            integrator.start(reached, np.zeros(chain.dimension))
    return Path(*map(np.array, zip(*poses, strict=True)), chain, integrator, turned)


def angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The geodesic angle of each rotation from a to b, exact for small ones."""
    half_chord = np.linalg.norm(a - b, axis=(-2, -1)) / np.sqrt(8.0)
    return 2.0 * np.arcsin(np.minimum(half_chord, 1.0))


def distances(a: Path, b: Path) -> tuple[float, float]:
    """The largest distance between positions, and angle between frames, at equal times."""
    apart = np.linalg.norm(a.positions - b.positions, axis=-1).max()
    return float(apart), float(angles(a.frames, b.frames).max())
