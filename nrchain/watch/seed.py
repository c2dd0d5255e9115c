"""max (|offset|/a, |e₁ × axis|) over run.atol: whether steps resolve the seed of a buckling chain.

An integrator treats what is smaller than ``run.atol`` as noise: it neither resolves nor solves for
it, and its steps then become as long as the run. On a chain that decays this does no harm. Where
bending waves grow, their seed, the first bend, determines their final shape and must be above
``run.atol``.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain.errors import SceneError
from nrchain.motion.bend import bend_of
from nrchain.scene.scene import Scene

RESOLVED = 1e3
"""A seed of this many ``run.atol`` grows at its rate to within a percent."""

BARELY = 1e2
"""A seed below this many ``run.atol`` grows with an error of more than several percent."""

ROUNDING = 4.0 * float(np.finfo(float).eps)
"""Of the directions of axes, and of positions relative to their distance from the origin."""

LEAST_ATOL = 1e-14
"""The least that ``run.atol`` may be."""


def seed_amplitude(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> float:
    """max (|offset|/a, |e₁ × axis|): the bend of these poses, in radii and radians.

    The axis is x for a periodic chain and joins the ends of an open one. A bend within rounding
    counts as 0.
    """
    periodic, radius = scene.chain.ends == "periodic", scene.chain.radius
    across, tilt = bend_of(positions, frames, radius, periodic, math.inf)
    if math.isinf(across):
        return across
    far, unsure = float(np.abs(positions).max()), ROUNDING
    if not periodic:
        # the axis turns with the rounding of the positions of its ends
        length = math.dist(positions[-1], positions[0])
        unsure = ROUNDING * max(far / length, 1.0)
    return max(
        tilt if tilt > unsure else 0.0,
        across if across > ROUNDING * max(far / radius, 1.0) else 0.0,
    )


def bend_growth_exponent(scene: Scene) -> float:
    """max Re λ · t_end of the bending modes: they grow by e to this power in the run.

    0 where they decay, and where the chain has no straight state.
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


def refuse_unresolved_seed(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> None:
    """Refuse a seed below ``run.atol`` that grows beyond it: noise would take its place."""
    seed, atol = seed_amplitude(scene, positions, frames), scene.run.atol
    if LEAST_ATOL < seed < atol and _outgrows(scene, seed, atol):
        allowed = (
            f"must be at most {_finer(seed)}: steps of this tolerance do not resolve the bend of"
            f" {seed:.2g} a at the start, and bends grow by up to"
            f" e^{bend_growth_exponent(scene):.3g} over the run; or start from a larger amplitude,"
            " or from a straight chain"
        )
        raise SceneError("run.atol", atol, allowed)


def seed_warning(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> str:
    """The warning of a straight start, or of a seed near ``run.atol``, on a chain that buckles.

    Empty where there is nothing to warn of.
    """
    seed, atol = seed_amplitude(scene, positions, frames), scene.run.atol
    if seed >= BARELY * atol:
        return ""
    folds = bend_growth_exponent(scene)
    if folds < math.log(10.0):
        return ""
    if seed <= LEAST_ATOL:
        return (
            "the start is straight to rounding and has no bend to grow from: the chain stays"
            f" straight, although bends grow by up to e^{folds:.3g} over the run;"
            " start.shape = 'random' provides a bend"
        )
    if seed < atol:
        return ""
    return (
        f"the bend of {seed:.2g} a at the start is barely above run.atol = {atol:g}, and bends grow"
        f" by up to e^{folds:.3g} over the run: the amplitude reached may be wrong by a factor; "
        f"run.atol = {_finer(seed)} resolves it"
    )


def resolving_tolerance(
    scene: Scene, positions: np.ndarray, frames: np.ndarray, tolerance: float
) -> float:
    """``tolerance``, or a finer one where a seed below it grows beyond it."""
    seed = seed_amplitude(scene, positions, frames)
    if LEAST_ATOL < seed < BARELY * tolerance and _outgrows(scene, seed, tolerance):
        return max(seed / BARELY, LEAST_ATOL)
    return tolerance


def _outgrows(scene: Scene, seed: float, atol: float) -> bool:
    folds = bend_growth_exponent(scene)
    return folds > 0.0 and folds + math.log(seed) > math.log(atol)


def _finer(seed: float) -> str:
    return f"{max(seed / RESOLVED, LEAST_ATOL):.1g}"
