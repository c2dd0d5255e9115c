"""Lamb's flows against SciPy's Legendre functions and, by differences, Stokes' equations."""

import math

import numpy as np
import pytest
from scipy.special import lpmv

from nrchain.hydrodynamics import lamb

POINTS = np.random.default_rng(0).normal(size=(7, 3)) * 0.4 + [1.3, -0.7, 0.9]


def gradient(field, points, step=1e-3):
    """∂_j field: fourth-order central differences, a new last axis."""
    columns = []
    for shift in step * np.eye(3):
        near = field(points + shift) - field(points - shift)
        far = field(points + 2 * shift) - field(points - 2 * shift)
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, axis=-1)


def test_harmonics_are_the_textbook_ones():
    r = np.linalg.norm(POINTS, axis=1)
    phi = np.arctan2(POINTS[:, 1], POINTS[:, 0])
    harmonics = lamb.solid_harmonics(POINTS, 6)
    for n in range(7):
        for m in range(n + 1):
            legendre = (-1) ** m * lpmv(m, n, POINTS[:, 2] / r)
            expected = math.factorial(n - m) * legendre * np.exp(1j * m * phi) / r ** (n + 1)
            np.testing.assert_allclose(harmonics[n, m], expected, rtol=1e-12)


def test_no_pole_on_the_axis():
    above = lamb.exterior_flows(np.array([[0.0, 0.0, 1.7]]), 8)
    beside = lamb.exterior_flows(np.array([[1e-12, 1e-12, 1.7]]), 8)
    np.testing.assert_allclose(above, beside, rtol=1e-9, atol=1e-9 * np.abs(above).max())


def test_first_flows_are_stokeslets_with_a_dipole_and_rotlets():
    r = np.linalg.norm(POINTS, axis=1)[:, None]
    flows = lamb.exterior_flows(POINTS, 1)
    for k, unit in enumerate(np.eye(3)):
        along = POINTS @ unit
        stokeslet = (unit / r + along[:, None] * POINTS / r**3) / 2
        dipole = (unit / r**3 - 3 * along[:, None] * POINTS / r**5) / 2
        np.testing.assert_allclose(flows[k], stokeslet - dipole, atol=1e-14)
        np.testing.assert_allclose(flows[3 + k], np.cross(unit, POINTS) / r**3, atol=1e-14)


def test_every_flow_obeys_stokes_equations():
    order = 4

    def flows(points):
        return lamb.exterior_flows(points, order)

    def vorticity(points):
        slope = gradient(flows, points)
        return np.einsum("ijk,mpkj->mpi", LEVI_CIVITA, slope)

    slope = gradient(flows, POINTS)
    scale = np.abs(slope).max()
    assert np.abs(np.einsum("mpkk->mp", slope)).max() < 1e-9 * scale
    # ∇p = ∇²u = −∇ × ∇ × u, where p is f for the pressure flows and 0 for the others.
    laplacian = -np.einsum("ijk,mpkj->mpi", LEVI_CIVITA, gradient(vorticity, POINTS, 1e-2))
    expected = np.zeros_like(laplacian)
    first = 0
    for n in range(1, order + 1):
        width = 2 * n + 1
        potential = flows(POINTS)[first + 2 * width : first + 3 * width]
        expected[first : first + width] = potential
        first += 3 * width
    np.testing.assert_allclose(laplacian, expected, atol=1e-5 * scale)


@pytest.mark.parametrize("order", [3, 9])
def test_flows_are_all_but_orthogonal_on_their_own_sphere(order):
    normals, weights = lamb.sphere_grid(order + 1)
    rows = (np.sqrt(weights)[:, None] * lamb.exterior_flows(normals, order)).reshape(
        lamb.flow_count(order), -1
    )
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    eigenvalues = np.linalg.eigvalsh(rows @ rows.T)
    assert eigenvalues[-1] < 3.2**2 * eigenvalues[0]


def test_quadrature_is_exact_up_to_its_degree():
    normals, weights = lamb.sphere_grid(4)
    x, y, z = normals.T
    assert weights @ (x**2 * y**2 * z**2) == pytest.approx(1 / 105, rel=1e-13)
    assert weights @ z**6 == pytest.approx(1 / 7, rel=1e-13)
    assert weights @ x**6 == pytest.approx(1 / 7, rel=1e-13)


LEVI_CIVITA = np.zeros((3, 3, 3))
for _i in range(3):
    LEVI_CIVITA[_i, (_i + 1) % 3, (_i + 2) % 3] = 1
    LEVI_CIVITA[_i, (_i + 2) % 3, (_i + 1) % 3] = -1
