"""u = U + v_slip on r = 1, u → 0 far away, no force, no torque: the flow of one slipping sphere.

Lamb's general solution outside a sphere, for slip that is symmetric about an axis: for each degree
l, with P_l(cos θ),

    pressure   u_r = (l+1)/(2(2l−1)) r^{−l} P_l,   u_θ = −(l−2)/(2l(2l−1)) r^{−l} ∂_θ P_l
    potential  u_r = −(l+1) r^{−l−2} P_l,           u_θ = r^{−l−2} ∂_θ P_l
    swirl      u_φ = r^{−l−1} ∂_θ P_l

The pressure flow and the swirl of degree 1 are the flows of a force and a torque. A free sphere has
neither; it moves with velocity U and angular velocity Ω instead. (H. Lamb, Hydrodynamics, §§ 335,
336; S. Kim and S. J. Karrila, Microhydrodynamics, ch. 4.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import Legendre, leggauss
from numpy.typing import NDArray

Array = NDArray[np.float64]
Slip = Callable[[Array], tuple[Array, Array, Array]]
Term = tuple[str, int]

NODES = 24
ROUNDING = 1e-13


@dataclass(frozen=True)
class ExteriorFlow:
    """The flow around one free sphere of radius 1 in polar components about the axis of its slip.

    ``coefficients`` are those of Lamb's terms, (kind, degree); ``swimming`` and ``turning`` are U
    and Ω along the axis; ``residual`` is the largest misfit of the boundary condition.
    """

    coefficients: dict[Term, float]
    swimming: float
    turning: float
    residual: float

    @classmethod
    def of(cls, slip: Slip, degrees: int = 6) -> ExteriorFlow:
        """Solve for the slip (v_r, v_θ, v_φ)(θ); exact for slip of up to that degree."""
        theta = np.arccos(leggauss(NODES)[0])
        terms: list[Term] = [("potential", 1)]
        for degree in range(2, degrees + 1):
            terms += [("pressure", degree), ("potential", degree), ("swirl", degree)]
        columns = [np.concatenate(_term(*term, np.ones_like(theta), theta)) for term in terms]
        zero = np.zeros_like(theta)
        swim = np.concatenate([np.cos(theta), -np.sin(theta), zero])
        turn = np.concatenate([zero, zero, np.sin(theta)])
        matrix = np.stack([*columns, -swim, -turn], axis=1)
        wanted = np.concatenate(slip(theta))
        solution = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
        # far away, a term of pure rounding could exceed the true ones
        solution[np.abs(solution) < ROUNDING * np.abs(solution).max()] = 0.0
        return cls(
            dict(zip(terms, solution[:-2].tolist(), strict=True)),
            float(solution[-2]),
            float(solution[-1]),
            float(np.max(np.abs(matrix @ solution - wanted))),
        )

    def velocity(self, r: Array, theta: Array) -> Array:
        """(u_r, u_θ, u_φ) at distances r and angles θ, (3, M)."""
        return np.sum(
            [c * np.stack(_term(*term, r, theta)) for term, c in self.coefficients.items()], axis=0
        )


def _term(kind: str, degree: int, r: Array, theta: Array) -> tuple[Array, Array, Array]:
    legendre = Legendre.basis(degree)
    p = legendre(np.cos(theta))
    slope = -np.sin(theta) * legendre.deriv()(np.cos(theta))
    zero = np.zeros_like(p)
    if kind == "pressure":
        decay = r ** (-float(degree))
        radial = (degree + 1) / (2 * (2 * degree - 1))
        polar = -(degree - 2) / (2 * degree * (2 * degree - 1))
        return radial * decay * p, polar * decay * slope, zero
    if kind == "potential":
        decay = r ** (-float(degree + 2))
        return -(degree + 1) * decay * p, decay * slope, zero
    return zero, zero, r ** (-float(degree + 1)) * slope
