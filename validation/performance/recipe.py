"""ẏ = f(t, y) as it is solved today: SciPy's BDF, PyStokes and NumPy.

The rival of the benchmarks, as a competent user writes it. Everything is vectorised over spheres
and links, routines and stencils are prepared once, and effects that a scene does not name are not
computed. Only the loop over pairs of a limited reach is in Python: PyStokes sums over all pairs of
its input, so it gets two spheres at a time.

The state y (6N,) holds the positions and, for every sphere, the Cayley vector θ of the rotation
from its starting frame, R = (I − θ^/2)⁻¹ (I + θ^/2): three numbers without a constraint, no
trigonometry, and good for turns of less than one half. The Jacobian is a dense difference quotient.
Scenes have free ends, slip along e₁ and the paper's measures of twist and bend.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nrchain import Scene
from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model
from validation.performance.recipe_forces import Array, Elasticity, PairFriction, PairSlip, cross

Rates = Callable[[float, Array], Array]
Poses = tuple[Array, Array]

STEP = 1e-7
"""Step of the difference quotients, in the paper's units (a = 1)."""


@dataclass(frozen=True)
class Solution:
    """Positions (T, N, 3) and frames (T, N, 3, 3) at the given times, and their cost."""

    positions: Array
    frames: Array
    seconds: float
    evaluations: int
    jacobians: int
    factorisations: int


class Recipe:
    """Twists and rates of a scene's chain, from given poses.

    Raises ValueError unless the scene has free ends, slip along e₁, the paper's elastic measure,
    and one-body friction or friction of all pairs.
    """

    def __init__(self, scene: Scene, positions: Array, frames: Array) -> None:
        plain = (
            scene.chain.ends == "free"
            and scene.elasticity.measure == "paper"
            and all(slip.axis == (1.0, 0.0, 0.0) for slip in scene.slip.modes.values())
            and (scene.friction.kind == "one-body" or scene.friction.neighbours == "all")
        )
        if not plain:
            raise ValueError("the recipe has free ends, slip along e1 and friction of all pairs")
        self.count = scene.chain.particles
        self.drag = scene.drag
        self.elasticity = Elasticity(scene)
        self.slip = PairSlip(scene)
        self.friction = PairFriction(scene) if scene.friction.kind == "pairwise" else None
        self.frames0 = np.ascontiguousarray(np.transpose(frames, (2, 1, 0)))
        self.start = np.concatenate([np.ravel(positions.T), np.zeros(3 * self.count)])

    def poses(self, y: Array) -> Poses:
        """Positions (3, N) and frames (component, vector, N) of a state."""
        centres, theta = y.reshape(2, 3, self.count)
        axis = theta[:, None]
        once = cross(axis, self.frames0)
        twice = cross(axis, once)
        scale = 1.0 / (1.0 + 0.25 * (theta**2).sum(axis=0))
        return centres, self.frames0 + scale * (once + 0.5 * twice)

    def twists(self, centres: Array, frames: Array) -> Array:
        """(v, ω), (2, 3, N)."""
        forces, torques = self.elasticity.wrenches(centres, frames)
        out = np.zeros((2, 3, self.count))
        if self.friction:
            self.friction.add(centres, forces, torques, out)
        else:
            out[0], out[1] = forces / self.drag.translation, torques / self.drag.rotation
        self.slip.add(centres, self.slip.tensors(frames[:, 0]), out)
        return out

    def rates(self, t: float, y: Array) -> Array:
        """(ṙ, θ̇) with θ̇ = ω − θ × ω/2 + θ (θ·ω)/4."""
        rates = self.twists(*self.poses(y))
        theta, omega = y[3 * self.count :].reshape(3, self.count), rates[1]
        along = 0.25 * (theta * omega).sum(axis=0)
        rates[1] = omega - 0.5 * cross(theta, omega) + along * theta
        return rates.ravel()

    def snapshots(self, states: Array) -> Poses:
        """Positions (T, N, 3) and frames (T, N, 3, 3) of states (6N, T), in nrchain's layout."""
        poses = [self.poses(np.ascontiguousarray(y)) for y in states.T]
        positions = np.array([centres.T for centres, _ in poses])
        return positions, np.array([frames.transpose(2, 1, 0) for _, frames in poses])


def solve_recipe(
    scene: Scene,
    positions: Array,
    frames: Array,
    times: Array,
    rtol: float,
    atol: float,
    careful: bool = False,
) -> Solution:
    """Today's practice: the recipe's right-hand side in ``solve_ivp(method="BDF")``.

    ``careful``: with :func:`difference_quotients` in place of SciPy's own.
    """
    begin = time.perf_counter()
    recipe = Recipe(scene, positions, frames)
    return _solve(recipe.rates, recipe.start, recipe.snapshots, times, rtol, atol, begin, careful)


def solve_compiled(
    scene: Scene,
    positions: Array,
    frames: Array,
    times: Array,
    rtol: float,
    atol: float,
    careful: bool = False,
) -> Solution:
    """``solve_ivp(method="BDF")`` given nrchain's compiled right-hand side, in one chart."""
    begin = time.perf_counter()
    chain = ChartedChain(Model(scene))
    chain.rebase(0.0, positions, frames)

    def rates(t: float, y: Array) -> Array:
        out = np.empty_like(y)
        chain.rates(t, y, out)
        return out

    def snapshots(states: Array) -> Poses:
        reached, turned = [], []
        for t, y in zip(times, states.T, strict=True):
            at, along = chain.poses(t, np.ascontiguousarray(y))
            reached.append(at.copy())
            turned.append(along.copy())
        return np.array(reached), np.array(turned)

    start = np.zeros(chain.dimension)
    return _solve(rates, start, snapshots, times, rtol, atol, begin, careful)


def _solve(
    rates: Rates,
    start: Array,
    snapshots: Callable[[Array], Poses],
    times: Array,
    rtol: float,
    atol: float,
    begin: float,
    careful: bool,
) -> Solution:
    from scipy.integrate import solve_ivp

    evaluations = 0

    def counted(t: float, y: Array) -> Array:
        nonlocal evaluations
        evaluations += 1
        return rates(t, y)

    with np.errstate(all="ignore"):
        result = solve_ivp(
            counted,
            (times[0], times[-1]),
            start,
            method="BDF",
            t_eval=times,
            rtol=rtol,
            atol=atol,
            jac=(lambda t, y: difference_quotients(counted, t, y)) if careful else None,
        )
    if not result.success:
        raise ArithmeticError(f"solve_ivp stopped: {result.message}")
    seconds = time.perf_counter() - begin
    positions, frames = snapshots(result.y)
    return Solution(positions, frames, seconds, evaluations, result.njev, result.nlu)


def difference_quotients(rates: Rates, t: float, y: Array) -> Array:
    """∂f/∂y (n, n) column by column, n + 1 evaluations.

    The step is the same for all coordinates. SciPy's own step scales with |y| or the tolerance, and
    is lost in rounding where a coordinate is zero: at tight tolerances the error of that Jacobian
    makes the time steps collapse.
    """
    before = rates(t, y)
    matrix, moved = np.empty((len(y), len(y))), y.copy()
    for k in range(len(y)):
        moved[k] = y[k] + STEP
        matrix[:, k] = (rates(t, moved) - before) / (moved[k] - y[k])
        moved[k] = y[k]
    return matrix
