"""How far a start is from straight, against what a step resolves: growth brings it to light.

What is smaller than ``run.atol`` is noise to the integrator: it neither follows nor solves for it,
and its steps then become as long as the run. On a chain that decays nothing is lost with it. Where
bending waves grow, the shape that they end in is that of their seed, and has to be above it.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain.errors import SceneError
from nrchain.scene.scene import Scene

RESOLVED = 1e3
"""A seed this many times ``run.atol`` grows at its rate to within a percent."""

BARELY = 1e2
"""Below this many times it, what has grown is off by more than several percent."""

LEAST_ATOL = 1e-14
"""The least that ``run.atol`` may be."""


def seed_of(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> float:
    """max (|offset|/a, |e₁ × axis|): how far poses are from straight, in radii and radians.

    The axis is x on a periodic chain, and goes through the ends of an open one. 0 where no more
    than rounding is left.
    """
    offsets, axis = positions - positions[0], np.array([1.0, 0.0, 0.0])
    rounding = 4.0 * float(np.finfo(float).eps)
    far, unsure = float(np.abs(positions).max()), rounding
    if scene.chain.ends != "periodic":
        length = float(np.linalg.norm(offsets[-1]))
        if not length:
            return math.inf
        # the axis turns with the rounding of the positions of its ends
        axis, unsure = offsets[-1] / length, rounding * max(far / length, 1.0)
    radius = scene.chain.radius
    tilt = float(np.linalg.norm(np.cross(frames[:, 0], axis), axis=1).max())
    across = float(np.linalg.norm(np.cross(offsets, axis), axis=1).max()) / radius
    return max(
        tilt if tilt > unsure else 0.0,
        across if across > rounding * max(far / radius, 1.0) else 0.0,
    )


def bending_folds(scene: Scene) -> float:
    """max Re λ · t_end of the modes across the chain: by e to what power they grow in the run.

    0 where they decay, and where the chain has no straight state to grow from.
    """
    from nrchain.theory.straight_growth import straight_growth
    from nrchain.theory.straight_state import straight_state

    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            state = straight_state(scene)
            growth = 0.0 if state.stopped else straight_growth(scene, state).across.rate
    except (SceneError, ArithmeticError, np.linalg.LinAlgError):
        return 0.0
    return growth * scene.run.end


def refuse_buried(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> None:
    """Refuse a start below ``run.atol`` that grows beyond it: noise would take its place."""
    seed, atol = seed_of(scene, positions, frames), scene.run.atol
    if LEAST_ATOL < seed < atol and _comes_to_light(scene, seed, atol):
        allowed = (
            f"must be at most {_finer(seed)}: the start is {seed:.2g} a off straight, which steps"
            f" of this tolerance do not see, and bends grow by up to e^{bending_folds(scene):.3g}"
            " over the run; or start from a larger amplitude, or from a straight chain"
        )
        raise SceneError("run.atol", atol, allowed)


def seed_warning(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> str:
    """What to know of a start that is straight, or hardly above ``run.atol``, on a chain that
    buckles; empty if there is nothing."""
    seed, atol = seed_of(scene, positions, frames), scene.run.atol
    if seed >= BARELY * atol:
        return ""
    folds = bending_folds(scene)
    if folds < math.log(10.0):
        return ""
    if seed <= LEAST_ATOL:
        return (
            "the start is straight to rounding, and a straight chain stays straight, although bends"
            f" grow by up to e^{folds:.3g} over the run: there is nothing for them to grow from;"
            " start.shape = 'random' gives it"
        )
    if seed < atol:
        return ""
    return (
        f"the start is {seed:.2g} a off straight, hardly above run.atol = {atol:g}, and bends grow"
        f" by up to e^{folds:.3g} over the run: what has grown may be off by a factor; run.atol = "
        f"{_finer(seed)} settles it"
    )


def tolerance_for(
    scene: Scene, positions: np.ndarray, frames: np.ndarray, tolerance: float
) -> float:
    """The tolerance, or a finer one that resolves a seed which grows beyond it."""
    seed = seed_of(scene, positions, frames)
    if LEAST_ATOL < seed < BARELY * tolerance and _comes_to_light(scene, seed, tolerance):
        return max(seed / BARELY, LEAST_ATOL)
    return tolerance


def _comes_to_light(scene: Scene, seed: float, atol: float) -> bool:
    folds = bending_folds(scene)
    return folds > 0.0 and folds + math.log(seed) > math.log(atol)


def _finer(seed: float) -> str:
    return f"{max(seed / RESOLVED, LEAST_ATOL):.1g}"
