"""u = v_i + ω_i × ρ + v_slip on every sphere: the exterior Stokes problem, solved to convergence.

Pair laws, finite-size corrections and pairwise friction are truncations of this problem. Here it is
solved in full for a few spheres, to measure the errors of the truncations. Every sphere carries
Lamb's exterior solutions u_k up to degree L about its centre (:mod:`nrchain.hydrodynamics.lamb`).
Their sum obeys Stokes' equations and decays. A least-squares fit over quadrature points on all
surfaces meets the boundary condition (multipole collocation),

    Σ_i ∮_i |Σ_jk c_jk u_k(x − r_j) − v_i − ω_i × (x − r_i) − v_slip|² dS  →  min.

Six flows of each sphere carry its force and torque. In the resistance problem the velocities are
given, and the coefficients of these flows are unknown. In the mobility problem the wrenches give
the coefficients, and the velocities are unknown.

The error falls as e^{−2αL} with cosh α = r/2a, r the distance of the closest pair. Convergence is
slow for thin films between spheres. Relative error of the velocities of two spheres with slip in
all modes:

    r/a     2.01    2.02    2.05    2.1     2.2     2.5     3       4       6
    L = 6   0.3     0.2     0.2     0.1     4e-2    3e-3    8e-5    1e-6    8e-9
    L = 10  0.1     0.1     6e-2    2e-2    3e-3    2e-5    6e-8    5e-11   1e-14
    L = 20  4e-2    2e-2    3e-3    2e-4    2e-6    4e-11   1e-15

The error for spheres pressed together below r = 2.05a is of order one at L = 10: lubrication is not
resolved. :meth:`ResolvedFlow.residual` and :func:`order_change` measure the error of a given case.

Sources: P. Ganatos, R. Pfeffer and S. Weinbaum, J. Fluid Mech. 84, 79 (1978), for multipole
collocation; Å. Björck, Linear Algebra Appl. 88/89, 31 (1987), for the least squares.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.distance import pdist

from nrchain.errors import SceneError
from nrchain.hydrodynamics import lamb
from nrchain.hydrodynamics.surface_slip import SlipLike, SurfaceSlip, surface_slip
from nrchain.inputs.arguments import finite_array
from nrchain.inputs.rules import number, whole

Pair: TypeAlias = tuple[np.ndarray, np.ndarray]
"""Velocities and angular velocities, or forces and torques: (N, 3) each, lab frame."""


class ResolvedSpheres:
    """The Stokes problem of spheres at fixed positions, for any slip, wrenches or velocities.

    Each of the two problems factorises its normal equations at first use, for any number of
    right-hand sides. Time grows as N³L⁶ and memory as N²L⁴: at L = 12, 0.1 s for 2 spheres, 3 s and
    0.6 GB for 8.

    Parameters
    ----------
    positions
        (N, 3), all pairs more than 2a apart.
    radius, viscosity
        a and η.
    order
        Highest degree L of the exterior solutions: 3L(L + 2) for each sphere.

    Raises
    ------
    SceneError
        For input of the wrong shape, spheres that touch or overlap, and an order below 1.
    """

    def __init__(
        self,
        positions: np.ndarray,
        *,
        radius: float = 1.0,
        viscosity: float = 1.0,
        order: int = 10,
    ) -> None:
        self.radius = number(above=0)("radius", radius)
        self.viscosity = number(above=0)("viscosity", viscosity)
        self.order = whole(least=1)("order", order)
        self.positions = finite_array("positions", positions, (None, 3))
        nearest = pdist(self.positions).min(initial=math.inf)
        if nearest <= 2 * radius:
            raise SceneError(
                "positions", f"centres {nearest:.6g} apart", f"must be more than {2 * radius:g}"
            )
        self._normals, weights = lamb.sphere_grid(order + 1)
        self._roots = np.sqrt(weights)[:, None]
        self._twist_units = np.repeat([1.0, 1 / radius], 3)
        self._wrench_units = viscosity * radius * np.repeat([1.0, radius], 3)

    def mobility_problem(
        self, frames: np.ndarray | None, slip: SlipLike, *, wrenches: Pair | None = None
    ) -> ResolvedFlow:
        """Velocities and flow for given forces and torques on the spheres; zero by default.

        ``frames`` (N, 3, 3), with e_{k+1} in row k, orient the slip modes. A slip given as a
        function of the normal needs no frames.
        """
        surface = surface_slip(slip, frames, len(self.positions))
        wrench = self._rows("wrenches", wrenches) / self._wrench_units
        target = self._on_surfaces(surface) - wrench.ravel() @ self._columns[-wrench.size :]
        solution = self._mobility_fit.solve(target)
        twist = -solution[: wrench.size].reshape(wrench.shape)
        return self._flow(surface, twist, wrench, solution[wrench.size :])

    def resistance_problem(
        self, twists: Pair, frames: np.ndarray | None = None, slip: SlipLike | None = None
    ) -> ResolvedFlow:
        """Forces and torques on the spheres for given velocities, and the flow."""
        surface = surface_slip({} if slip is None else slip, frames, len(self.positions))
        twist = self._rows("twists", twists) / self._twist_units
        target = self._on_surfaces(surface) + twist.ravel() @ self._columns[: twist.size]
        solution = self._resistance_fit.solve(target)
        wrench = solution[-twist.size :].reshape(twist.shape)
        return self._flow(surface, twist, wrench, solution[: -twist.size])

    def resistance(self) -> np.ndarray:
        """R in (F, T)_i = Σ_j R_ij (v, ω)_j, rigid spheres: (N, 6, N, 6).

        Forces and torques are those that drive the spheres. R is symmetric by the reciprocal
        theorem and positive definite, up to the error of the solution.
        """
        count = len(self.positions)
        solution = self._resistance_fit.solve(self._columns[: 6 * count].T)
        matrix = solution[-6 * count :].reshape(count, 6, count, 6)
        return matrix * self._wrench_units[:, None, None] / self._twist_units

    @cached_property
    def _columns(self) -> np.ndarray:
        """Rows: rigid motions, flows without wrench, flows of unit wrench, on all surfaces.

        (6N + 3L(L + 2)N, 3PN), weighted so that a sum of squares is an integral. The mobility
        problem has all rows but the last 6N as unknowns, the resistance problem all but the first
        6N.
        """
        centres = self.positions / self.radius
        count, points = len(centres), len(self._normals)
        flows, ends = lamb.flow_count(self.order), 6 * count
        table = np.zeros((ends + count * flows, 3 * points * count))
        rigid = table[:ends].reshape(count, 6, count, points, 3)
        free = table[ends:-ends].reshape(count, flows - 6, count, points, 3)
        loads = table[-ends:].reshape(count, 6, count, points, 3)
        own = lamb.exterior_flows(self._normals, self.order)
        for i in range(count):
            rigid[i, :3, i] = self._roots * np.eye(3)[:, None]
            rigid[i, 3:, i] = self._roots * np.cross(np.eye(3)[:, None], self._normals)
            for j in range(count):
                relative = centres[i] - centres[j] + self._normals
                flow = own if i == j else lamb.exterior_flows(relative, self.order)
                loads[j, :, i] = self._roots * flow[:6] / lamb.WRENCH[:, None, None]
                free[j, :, i] = self._roots * flow[6:]
        return table

    @cached_property
    def _mobility_fit(self) -> _LeastSquares:
        return _LeastSquares(self._columns[: -6 * len(self.positions)])

    @cached_property
    def _resistance_fit(self) -> _LeastSquares:
        return _LeastSquares(self._columns[6 * len(self.positions) :])

    def _on_surfaces(self, slip: SurfaceSlip) -> np.ndarray:
        values = [self._roots * slip(i, self._normals) for i in range(len(self.positions))]
        return np.concatenate(values, axis=None)

    def _rows(self, name: str, pair: Pair | None) -> np.ndarray:
        shape = (len(self.positions), 3)
        given = (np.zeros(shape), np.zeros(shape)) if pair is None else pair
        return np.concatenate([finite_array(name, part, shape) for part in given], axis=1)

    def _flow(
        self, slip: SurfaceSlip, twist: np.ndarray, wrench: np.ndarray, free: np.ndarray
    ) -> ResolvedFlow:
        twist, loads = twist * self._twist_units, wrench * self._wrench_units
        return ResolvedFlow(
            positions=self.positions,
            velocities=twist[:, :3],
            angular_velocities=twist[:, 3:],
            forces=loads[:, :3],
            torques=loads[:, 3:],
            radius=self.radius,
            order=self.order,
            slip=slip,
            coefficients=np.hstack([wrench / lamb.WRENCH, free.reshape(len(wrench), -1)]),
        )


@dataclass(frozen=True)
class ResolvedFlow:
    """A solved flow: twists and wrenches of the spheres, and the velocity of the fluid.

    ``velocities``, ``angular_velocities``, ``forces`` and ``torques`` (on the spheres, from
    outside) are (N, 3); ``coefficients`` (N, 3L(L + 2)) belong to :func:`lamb.exterior_flows` in
    lengths of a.
    """

    positions: np.ndarray
    velocities: np.ndarray
    angular_velocities: np.ndarray
    forces: np.ndarray
    torques: np.ndarray
    radius: float
    order: int
    slip: SurfaceSlip
    coefficients: np.ndarray

    def velocity(self, points: np.ndarray) -> np.ndarray:
        """u at points (P, 3) outside the spheres: (P, 3)."""
        total = np.zeros_like(points, dtype=float)
        for centre, coefficients in zip(self.positions, self.coefficients, strict=True):
            flows = lamb.exterior_flows((points - centre) / self.radius, self.order)
            total += np.tensordot(coefficients, flows, axes=1)
        return total

    def residual(self) -> float:
        """max |u − v_i − ω_i × ρ − v_slip| over surface points that are not part of the fit."""
        normals = lamb.sphere_grid(self.order + 4)[0][:, [1, 2, 0]]
        worst = 0.0
        for i, (centre, v, w) in enumerate(
            zip(self.positions, self.velocities, self.angular_velocities, strict=True)
        ):
            arms = self.radius * normals
            miss = self.velocity(centre + arms) - v - np.cross(w, arms) - self.slip(i, normals)
            worst = max(worst, float(np.linalg.norm(miss, axis=1).max()))
        return worst


def resolved_twists(
    positions: np.ndarray,
    frames: np.ndarray | None,
    slip: SlipLike,
    *,
    wrenches: Pair | None = None,
    radius: float = 1.0,
    viscosity: float = 1.0,
    order: int = 10,
) -> Pair:
    """(v, ω) of spheres with slip under given forces and torques: see :class:`ResolvedSpheres`."""
    spheres = ResolvedSpheres(positions, radius=radius, viscosity=viscosity, order=order)
    flow = spheres.mobility_problem(frames, slip, wrenches=wrenches)
    return flow.velocities, flow.angular_velocities


def resolved_resistance(
    positions: np.ndarray, *, radius: float = 1.0, viscosity: float = 1.0, order: int = 10
) -> np.ndarray:
    """R in (F, T)_i = Σ_j R_ij (v, ω)_j, (N, 6, N, 6): see :meth:`ResolvedSpheres.resistance`."""
    return ResolvedSpheres(positions, radius=radius, viscosity=viscosity, order=order).resistance()


def order_change(
    positions: np.ndarray,
    frames: np.ndarray | None,
    slip: SlipLike,
    *,
    wrenches: Pair | None = None,
    radius: float = 1.0,
    viscosity: float = 1.0,
    order: int = 10,
) -> float:
    """max |Δv|, a|Δω| from order L − 2 to L: the error of the lower one, as convergence is fast.

    If it falls by a factor q every two orders, the error at L is about q/(1 − q) times this.
    """
    if order < 3:
        raise SceneError("order", order, "must be at least 3, to compare with order − 2")
    (v, w), (v_low, w_low) = (
        resolved_twists(
            positions,
            frames,
            slip,
            wrenches=wrenches,
            radius=radius,
            viscosity=viscosity,
            order=degree,
        )
        for degree in (order, order - 2)
    )
    change = np.concatenate([v - v_low, radius * (w - w_low)])
    return float(np.linalg.norm(change, axis=1).max())


class _LeastSquares:
    """min |xᵀA − b| for A (n, K) of full row rank, by corrected semi-normal equations (Björck).

    One step of refinement compensates for squaring the condition number, which is 5 for spheres 4a
    apart, 15 at 2.5a and 400 at 2.02a with L = 12. Cholesky does not depend on the scales of
    columns.
    """

    def __init__(self, rows: np.ndarray) -> None:
        self._rows = rows
        self._factor = cho_factor(rows @ rows.T, overwrite_a=True, check_finite=False)

    def solve(self, targets: np.ndarray) -> np.ndarray:
        """x (n,) or (n, R) for targets (K,) or (K, R)."""
        first = cho_solve(self._factor, self._rows @ targets)
        return first + cho_solve(self._factor, self._rows @ (targets - self._rows.T @ first))
