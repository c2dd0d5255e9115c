"""The cases of the gallery: a scene, optional poses, and the allowed ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nrchain import Cause, Scene, load_scene
from nrchain.planning.checked_start import starting_poses

COMPLETED, REFUSED = "completed", "refused"
STIFF = {"elasticity.ratio": None, "elasticity.stretch": 20.0, "elasticity.shear": 20.0}
FREE = {"chain.ends": "free"}
RUNAWAY = (Cause.TOUCH, Cause.TURN, Cause.STEP, Cause.NOT_FINITE)

Poses = dict[str, Any]
"""Keyword arguments ``positions`` and ``frames`` of a run, or none."""


@dataclass(frozen=True)
class Case:
    """A shipped scene with changes, optional poses, and the allowed ends of its run.

    ``second`` is the integrator for the comparison of a completed run, if it is not the other one
    of CVODE and Radau IIA.
    """

    name: str
    base: str
    changes: dict[str, Any]
    ends: tuple[str, ...] = (COMPLETED,)
    poses: Callable[[Scene], Poses] = field(default=lambda scene: {})
    second: str = ""
    quick: bool = True

    def scene(self, **more: Any) -> Scene:
        return load_scene(self.base, **{"run.snapshots": 11} | self.changes | more)

    def start(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """The poses at the start of a run of the case."""
        return starting_poses(scene, **self.poses(scene))


def _first_two(distance: float) -> Callable[[Scene], Poses]:
    return lambda scene: {"positions": np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0]])}


def _squeezed(scene: Scene) -> Poses:
    positions = starting_poses(scene)[0]
    positions[:, 0] *= 0.93
    return {"positions": positions}


def _twisted(scene: Scene) -> Poses:
    frames = starting_poses(scene)[1]
    cosine, sine = np.cos(3.0), np.sin(3.0)
    frames[len(frames) // 2 :, 1:] = [[0.0, cosine, sine], [0.0, -sine, cosine]]
    return {"frames": frames}


def _half_turned(scene: Scene) -> Poses:
    """The start rotated as a whole by π − 1e-9 about z: the largest rotation from the lab axes."""
    positions, frames = starting_poses(scene)
    angle = np.pi - 1e-9
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0, 0, 1.0]]
    )
    return {"positions": positions @ turn.T, "frames": frames @ turn.T}


def _not_finite(scene: Scene) -> Poses:
    return {"positions": np.full((scene.chain.particles, 3), np.nan)}


def _left_handed(scene: Scene) -> Poses:
    return {"frames": -starting_poses(scene)[1]}


def _pair(strength: float) -> dict[str, Any]:
    return {"chain.particles": 2, "slip.2s": strength, "run.end": 20.0, **FREE, **STIFF}


def _crowd(count: int, end: float) -> dict[str, Any]:
    return {"chain.particles": count, "run.end": end, "run.snapshots": 2, **STIFF}


_OPPOSED = [100.0] * 10 + [-100.0] * 10
_ALL = {"slip.2s": 50.0, "slip.3a": 1000.0, "slip.3t": 200.0, "slip.4a": 1000.0}
_TORN = {"chain.particles": 64, "run.end": 200.0, **FREE}
_SPUN = {"chain.particles": 5, "run.end": 2000.0}
_COLUMN = {
    "elasticity.ratio": 1e12,
    "field.force": [300.0, 0.0, 0.0],
    "start.shape": "sine",
    "run.end": 1.4,
}
_SOFT = {"steric.kind": "harmonic", "steric.strength": 1e4, "steric.range": 2.5}

GALLERY = (
    *(
        Case(f"stiffness ratio {r:g}", "buckling", {"elasticity.ratio": r, "run.end": 100.0})
        for r in (1e7, 1e12, 1e15)
    ),
    *(
        Case(f"N = {n}", "buckling", {"chain.particles": n, "run.end": 50.0, **FREE, **STIFF})
        for n in (2, 3, 4, 5)
    ),
    Case("N = 10⁴", "buckling", _crowd(10**4, 0.2), quick=False),
    Case("N = 10⁵", "buckling", _crowd(10**5, 0.01), quick=False),
    Case(
        "frames turn through 10⁴ rad",
        "spiral-left",
        {**_SPUN, "start.shape": "straight"},
    ),
    Case(
        "a bent chain turns through 10⁴ rad",
        "spiral-left",
        {**_SPUN, "start.shape": "random", "start.amplitude": 0.5},
    ),
    Case("turned as a whole by π − 1e-9", "buckling", {"run.end": 50.0}, poses=_half_turned),
    Case("amplitude 1e-12 a", "buckling", {"start.amplitude": 1e-12, "run.end": 100.0}),
    Case(
        "a loaded column, bent by 1e-5 a",
        "passive",
        {**_COLUMN, "start.amplitude": 1e-5},
        (Cause.GROWTH,),
    ),
    Case(
        "a loaded column, bent by 1e-5 a, at 1e-10",
        "passive",
        {**_COLUMN, "start.amplitude": 1e-5, "run.atol": 1e-10},
    ),
    Case(
        "amplitude 5 d",
        "buckling",
        {"start.shape": "sine", "start.amplitude": 50.0, "run.end": 100.0, **FREE},
    ),
    Case("random amplitude 5 d", "buckling", {"start.amplitude": 50.0}, (REFUSED,)),
    Case("two pushers at 2.0001 a", "buckling", _pair(50.0), poses=_first_two(2.0001)),
    Case("two pullers at 2.0001 a", "buckling", _pair(-5e3), (Cause.TOUCH,), _first_two(2.0001)),
    *(
        Case(f"two spheres at {r:g} a", "buckling", _pair(50.0), (REFUSED,), _first_two(r))
        for r in (2.0, 1.9, 0.0)
    ),
    Case("strength 0", "buckling", {"slip.2s": 0.0, "run.end": 100.0}),
    Case("strength 1e-12", "buckling", {"slip.2s": 1e-12, "run.end": 100.0}),
    Case("strength 1e8", "buckling", {"slip.2s": 1e8, **FREE}, RUNAWAY),
    Case("strength 1e300", "buckling", {"slip.2s": 1e300}, RUNAWAY),
    Case("opposed strengths", "buckling", {"slip.2s": _OPPOSED}, (Cause.TOUCH,)),
    Case(
        "opposed strengths on a stiff chain",
        "buckling",
        {"slip.2s": _OPPOSED, "elasticity.ratio": 1e9, "run.end": 200.0},
    ),
    Case("all four modes", "buckling", {**_ALL, **FREE, **STIFF, "run.end": 20.0}),
    Case("far past buckling", "buckling", {"run.end": 5000.0}),
    Case("a link twisted by 3 rad", "passive", {}, (REFUSED,), _twisted),
    Case("clamped and compressed", "passive", {"run.end": 100.0, **STIFF}, poses=_squeezed),
    Case("torn: N = 64, R = 1e7, V = 100", "buckling", _TORN, (Cause.TOUCH,)),
    Case(
        "torn, with a repulsion",
        "buckling",
        {**_TORN, **_SOFT, "run.end": 20.0},
        second="scipy-bdf",
    ),
    Case("NaN in the start", "passive", {}, (REFUSED,), _not_finite),
    Case("left-handed frames", "passive", {}, (REFUSED,), _left_handed),
    Case(
        "tolerances of 1e-13",
        "buckling",
        {"run.rtol": 1e-13, "run.atol": 1e-13, "run.end": 20.0, "chain.particles": 8},
    ),
    Case("a budget of 50 steps", "buckling", {"run.max_steps": 50}, (Cause.BUDGET,)),
)
