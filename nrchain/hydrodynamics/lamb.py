"""u = Σ_l [∇ × (x χ_l) + ∇Φ_l + (flows of pressure p_l)]: Lamb's solution of Stokes flow.

All flows are built from Cartesian derivatives of 1/r: there are no angles and no poles. Lengths are
in sphere radii and the viscosity is 1.

Sources: H. Lamb, *Hydrodynamics*, art. 335, 336; J. Happel and H. Brenner, *Low Reynolds Number
Hydrodynamics*, section 3-2; S. Kim and S. J. Karrila, *Microhydrodynamics*, chapter 4.
"""

from __future__ import annotations

import math

import numpy as np

WRENCH = np.repeat([4 * math.pi, 8 * math.pi], 3)
"""F = 4π ∇(r³ p_1) and T = 8π ∇(r³ χ_1) on the fluid, x, y, z, by unit coefficients of the first
three and the next three flows; all other flows have neither force nor torque.

Happel and Brenner, section 3-2, give the reactions, which act on the sphere.
"""


def flow_count(order: int) -> int:
    """3 L (L + 2): three flows for each harmonic of degree 1 … L."""
    return 3 * order * (order + 2)


def solid_harmonics(points: np.ndarray, order: int) -> np.ndarray:
    """I_l^m = (−1)^l ∂_z^{l−m} (∂_x + i∂_y)^m r⁻¹ = (l − m)! r^{−l−1} P_l^m(cos θ) e^{imφ}.

    P_l^m has no sign (−1)^m here. One recurrence runs along the diagonal and one away from it,

        r² I_{m+1}^{m+1} = (2m + 1)(x + iy) I_m^m
        r² I_{l+1}^m     = (2l + 1) z I_l^m − (l² − m²) I_{l−1}^m

    ``points`` is (P, 3); the result (L + 1, L + 1, P) complex, by l and m ≥ 0, zero for m > l.
    """
    r2 = np.einsum("pk,pk->p", points, points)
    along, across = points[:, 2] / r2, (points[:, 0] + 1j * points[:, 1]) / r2
    harmonics = np.zeros((order + 1, order + 1, len(points)), complex)
    harmonics[0, 0] = 1 / np.sqrt(r2)
    for n in range(order):
        m = np.arange(n + 1)[:, None]
        harmonics[n + 1, : n + 1] = (2 * n + 1) * along * harmonics[n, : n + 1]
        if n > 0:
            harmonics[n + 1, : n + 1] -= (n * n - m * m) / r2 * harmonics[n - 1, : n + 1]
        harmonics[n + 1, n + 1] = (2 * n + 1) * across * harmonics[n, n]
    return harmonics


def exterior_flows(points: np.ndarray, order: int) -> np.ndarray:
    """Three flows for each real solid harmonic f of degree l = 1 … L, with g = ∇f:

        pressure   [(l + 1) f x − (l/2 − 1)(r² − 1) g] / (l (2l − 1)),   of pressure f
        toroidal   ∇ × (f x) = g × x
        potential  g

    They span all flows outside the unit sphere that obey Stokes' equations, decay and have no
    source. The pressure flow is Lamb's minus a multiple of the potential flow, so that it is normal
    to the sphere on its surface: there the normalised flows have condition number 3.2 at any order.
    Degree 1 is f = x/r³, y/r³, z/r³: pressure and potential flows are those of a dragged sphere,
    toroidal flows those of a rotating one.

    Gradients are harmonics of the next degree, by the ladder
    (∂_x + i∂_y) I_l^m = −I_{l+1}^{m+1}, (∂_x − i∂_y) I_l^m = I_{l+1}^{m−1} (because ∇² r⁻¹ = 0, and
    with I_l^{−1} = −conj I_l^1), ∂_z I_l^m = −I_{l+1}^m.

    ``points`` is (P, 3) from the centre, in radii. The result is (M, P, 3), M = 3L(L + 2): by
    degree, then by family as above, then by harmonic, Re m = 1 … l, Im m = 1 … l and m = 0.
    """
    harmonics = solid_harmonics(points, order + 1)
    outside = np.einsum("pk,pk->p", points, points)[:, None] - 1
    flows = np.empty((flow_count(order), len(points), 3))
    first = 0
    for n in range(1, order + 1):
        above = harmonics[n + 1]
        up, level = above[1 : n + 2], above[: n + 1]
        down = np.concatenate([-above[1:2].conj(), above[:n]])
        g = _real(np.stack([(down - up) / 2, (down + up) * 0.5j, -level], axis=-1))
        fx = _real(harmonics[n, : n + 1])[:, :, None] * points
        pressure = ((n + 1) * fx - (n / 2 - 1) * outside * g) / (n * (2 * n - 1))
        for family in (pressure, np.cross(g, points), g):
            flows[first : first + 2 * n + 1] = family
            first += 2 * n + 1
    return flows


def sphere_grid(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals (2n², 3) and weights of sum 1: Gauss–Legendre in z, uniform in φ.

    Exact for polynomials up to degree 2n − 1.
    """
    z, share = np.polynomial.legendre.leggauss(count)
    phi = np.arange(2 * count) * (math.pi / count)
    z, phi = np.repeat(z, 2 * count), np.tile(phi, count)
    across = np.sqrt(1 - z * z)
    normals = np.stack([across * np.cos(phi), across * np.sin(phi), z], axis=1)
    return normals, np.repeat(share / (4 * count), 2 * count)


def _real(values: np.ndarray) -> np.ndarray:
    """Re m = 1 … l, Im m = 1 … l and m = 0 along the first axis, from m = 0 … l."""
    return np.concatenate([values[1:].real, values[1:].imag, values[:1].real])
