"""Spectral elements: exact for polynomials of the degree that theory promises."""

import numpy as np
import pytest

from nrchain.theory.rod.nonlinear.elements import Elements, lobatto


@pytest.mark.parametrize("degree", [2, 3, 8, 24])
def test_quadrature_integrates_degree_2p_minus_1(degree):
    points, weights = lobatto(degree)
    for power in range(2 * degree):
        assert weights @ points**power == pytest.approx((1 - (-1) ** (power + 1)) / (power + 1))


@pytest.mark.parametrize(("count", "degree"), [(1, 5), (3, 4)])
def test_derivatives_and_interpolation_of_polynomials_are_exact(count, degree):
    elements = Elements.of(1.7, count, degree, closed=False)
    s, coefficients = elements.places, np.arange(1.0, degree + 2)
    slope = np.polyval(np.polyder(coefficients), s[elements.nodes])
    values = np.polyval(coefficients, s)
    assert np.allclose(values[elements.nodes] @ elements.slopes.T, slope, rtol=1e-12)
    at = np.linspace(0.0, 1.7, 11)
    assert np.allclose(elements.interpolation(at) @ values, np.polyval(coefficients, at))


def test_closed_elements_share_the_first_node():
    elements = Elements.of(2.0, 3, 4, closed=True)
    assert len(elements.places) == 12
    assert elements.nodes[-1, -1] == 0
    assert elements.lumped().sum() == pytest.approx(2.0)
