"""u = −(5a³/2)(1 + a²∇²/6)(1 + a²∇²/10) x (x·E·x)/r⁵: a rigid sphere in a strain E.

A rigid sphere does not deform with the fluid. It disturbs the flow by its stresslet
S = (20/3)πηa³E and by a potential quadrupole. The exact flow about one sphere is (1 + a²∇²/10)
times that of the stresslet; a second sphere of the same size feels (1 + a²∇²/6) of it (Faxén). The
flow is biharmonic, so that the product of both is 1 + (4/15)a²∇². With f = x·E·x,

    stresslet     u = −(5a³/2) x f/r⁵,                      w = ½ ∇ × u = −(5a³/2)(E·x) × x/r⁵
    finite size   u = −(8a⁵/3) [E·x/r⁵ − (5/2) x f/r⁷],      w = 0
                    = −(4a⁵/3) ∇(f/r⁵)

x points from the acting to the feeling sphere. The relative velocity of two spheres is
E·r − [A n n + B (I − n n)]·E·r. With ρ = r/a the stresslet gives A = 5/ρ³ and B = 0, the finite
size A = −8/ρ⁵ and B = 16/3ρ⁵. Reflections, 25/ρ⁶ in A, are left out.

Sources: Batchelor & Green, J. Fluid Mech. 56, 375 (1972), for A and B; Kim & Karrila,
*Microhydrodynamics*, chapter 3, for the flow about one sphere and Faxén's laws.
"""

from __future__ import annotations

from functools import cache, partial
from typing import Any, Literal

import numpy as np
from numba import prange

from nrchain._compile import kernel
from nrchain.hydrodynamics import sharing
from nrchain.hydrodynamics.images import Layout
from nrchain.hydrodynamics.pairs import NEAR
from nrchain.hydrodynamics.sharing import PARALLEL_PAIRS, compile_sum

Part = Literal["stresslet", "finite size"]

_SIZES = {"stresslet": (5 / 2, 3), "finite size": (8 / 3, 5)}
"""The prefactor of each part: a number, and the power of a."""


@kernel
def _pull(strain, x):
    """E·x."""
    return (
        strain[0, 0] * x[0] + strain[0, 1] * x[1] + strain[0, 2] * x[2],
        strain[1, 0] * x[0] + strain[1, 1] * x[1] + strain[1, 2] * x[2],
        strain[2, 0] * x[0] + strain[2, 1] * x[1] + strain[2, 2] * x[2],
    )


@kernel
def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


@kernel
def _cross(p, q):
    return (
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    )


@kernel
def _between(points, i, j):
    """r_i − r_j."""
    return (
        points[i, 0] - points[j, 0],
        points[i, 1] - points[j, 1],
        points[i, 2] - points[j, 2],
    )


@kernel
def _add_stresslet(x, strain, factor, out):
    """out (6,) += factor (x f, (E·x) × x)/r⁵."""
    pulled, square = _pull(strain, x), 1.0 / _dot(x, x)
    factor *= square**2 * np.sqrt(square)
    along, turn = _dot(pulled, x), _cross(pulled, x)
    for k in range(3):
        out[k] += factor * along * x[k]
        out[3 + k] += factor * turn[k]


@kernel
def _add_stresslet_change(x, dx, strain, factor, out):
    """out (6,) += the change of :func:`_add_stresslet` when x changes by dx."""
    square = 1.0 / _dot(x, x)
    factor *= square**2 * np.sqrt(square)
    pulled, moved = _pull(strain, x), _pull(strain, dx)
    along, stretch = _dot(pulled, x), 5.0 * square * _dot(x, dx)
    change = 2.0 * _dot(pulled, dx) - along * stretch
    turn, first, second = _cross(pulled, x), _cross(moved, x), _cross(pulled, dx)
    for k in range(3):
        out[k] += factor * (change * x[k] + along * dx[k])
        out[3 + k] += factor * (first[k] + second[k] - stretch * turn[k])


@kernel
def _add_finite_size(x, strain, factor, out):
    """out (6,) += factor (E·x − (5/2) x f/r², 0)/r⁵."""
    pulled, square = _pull(strain, x), 1.0 / _dot(x, x)
    factor *= square**2 * np.sqrt(square)
    along = 2.5 * square * _dot(pulled, x)
    for k in range(3):
        out[k] += factor * (pulled[k] - along * x[k])


@kernel
def _add_finite_size_change(x, dx, strain, factor, out):
    """out (6,) += the change of :func:`_add_finite_size` when x changes by dx."""
    square = 1.0 / _dot(x, x)
    factor *= square**2 * np.sqrt(square)
    pulled, moved = _pull(strain, x), _pull(strain, dx)
    along, stretch = 2.5 * square * _dot(pulled, x), square * _dot(x, dx)
    change = 5.0 * square * _dot(pulled, dx) - 7.0 * along * stretch
    for k in range(3):
        out[k] += factor * (moved[k] - 5.0 * stretch * pulled[k] - along * dx[k] - change * x[k])


@cache
def _twist_kernel(leading: bool, parallel: bool) -> Any:
    """Compile the sum over pairs of one part: see :meth:`Disturbance.add_twists`."""

    def add_disturbance(points, weights, strain, size, first, reach, twists):
        for i in prange(twists.shape[0]):
            me = first + i
            for j in range(max(0, me - reach), min(points.shape[0], me + reach + 1)):
                if j == me:
                    continue
                x, factor = _between(points, me, j), -size * weights[j]
                if leading:
                    _add_stresslet(x, strain, factor, twists[i])
                else:
                    _add_finite_size(x, strain, factor, twists[i])

    return compile_sum(add_disturbance, parallel, str(leading))


@cache
def _product_kernel(leading: bool, parallel: bool) -> Any:
    """Compile the derivative of the sum: see :meth:`Disturbance.add_product`."""

    def add_disturbance_product(points, moves, weights, strain, size, first, reach, out):
        for i in prange(out.shape[0]):
            me = first + i
            for j in range(max(0, me - reach), min(points.shape[0], me + reach + 1)):
                if j == me:
                    continue
                x, dx = _between(points, me, j), _between(moves, me, j)
                factor = -size * weights[j]
                if leading:
                    _add_stresslet_change(x, dx, strain, factor, out[i])
                else:
                    _add_finite_size_change(x, dx, strain, factor, out[i])

    return compile_sum(add_disturbance_product, parallel, str(leading))


@kernel
def _add_blocks(points, weights, strain, size, leading, first, reach, blocks):
    centre = blocks.shape[1] // 2
    column = np.empty(6)
    for i in range(blocks.shape[0]):
        me = first + i
        for j in range(max(0, me - reach), min(points.shape[0], me + reach + 1)):
            if j == me:
                continue
            x, factor = _between(points, me, j), -size * weights[j]
            for k in range(3):
                dx = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
                column[:] = 0.0
                if leading:
                    _add_stresslet_change(x, dx, strain, factor, column)
                else:
                    _add_finite_size_change(x, dx, strain, factor, column)
                for row in range(6):
                    blocks[i, centre, row, k] += column[row]
                    blocks[i, centre + j - me, row, k] -= column[row]


class Disturbance:
    """(v, ω)_i = Σ_j (u, w)(r_i − r_j): how rigid spheres disturb a flow, and the derivative.

    Parameters
    ----------
    part
        The stresslet or the finite size.
    gradient
        G (3, 3) of the flow G·r; only its symmetric part E has an effect.
    count, radius
        N and a.
    reach
        Neighbours on either side whose flow counts; None: all pairs, with every image of a
        periodic chain. This sum converges: the p-th image contributes as 1/p².
    period
        Length along x after which the chain repeats; 0 for an open chain.
    """

    def __init__(
        self,
        part: Part,
        gradient: np.ndarray,
        *,
        count: int,
        radius: float,
        reach: int | None,
        period: float = 0.0,
    ) -> None:
        factor, power = _SIZES[part]
        self._leading = part == "stresslet"
        self._strain = 0.5 * (gradient + gradient.T)
        self._size = factor * float(radius) ** power
        self._layout = Layout.of(count, reach, period)
        self.reach = self._layout.reach
        self._parallel = 2 * self.reach * count > PARALLEL_PAIRS

    @property
    def near(self) -> int | None:
        """Neighbours with exact Jacobian blocks; None if only :meth:`add_product` is exact."""
        return self.reach if self.reach <= NEAR else None

    def _points(self, positions: np.ndarray) -> np.ndarray:
        points = positions[self._layout.spheres]
        points[:, 0] += self._layout.shifts
        return points

    def _law(self) -> tuple[Any, ...]:
        layout = self._layout
        return layout.weights, self._strain, self._size, layout.first, layout.reach

    def add_twists(self, positions: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += (Σ_j u, Σ_j w) at positions (N, 3)."""
        compiled, points = partial(_twist_kernel, self._leading), self._points(positions)
        sharing.add(compiled, self._parallel, points, *self._law(), twists)

    def linearise(self, positions: np.ndarray) -> None:
        """Take the derivative at positions (N, 3)."""
        self._there = self._points(positions)

    def add_blocks(self, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6)[i, w + m] += ∂(v, ω)_i / ∂(u, φ)_{i+m}.

        Adds nothing if the blocks cannot hold the whole derivative: the flow is smooth.
        """
        if self.near is not None and self.near <= blocks.shape[1] // 2:
            weights, strain, size, first, reach = self._law()
            _add_blocks(self._there, weights, strain, size, self._leading, first, reach, blocks)

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        """out (N, 6) += the change of the twists with a change ``poses`` (N, 6) of the poses."""
        moves = poses[self._layout.spheres, :3]
        compiled = partial(_product_kernel, self._leading)
        sharing.add(compiled, self._parallel, self._there, moves, *self._law(), out)
