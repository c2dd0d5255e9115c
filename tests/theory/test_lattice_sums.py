"""Lattice sums against exact values, Bernoulli polynomials and plain sums with a smooth cutoff."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrchain.errors import SceneError
from nrchain.theory.lattice_sums import MOST_TERMS, cosine_defect, cosine_sum, power_sum, sine_sum

POWERS = range(2, 9)
PHASES = np.array([0.3, 0.7, 1.0, 2.0, 3.0, math.pi])
ZETA3 = 1.2020569031595942854


def smooth_sum(power: int, theta: float, term, terms: int = 4000) -> float:
    """Σ term(mθ)/m^s with a cutoff that is smooth to all orders, so that it leaves no remainder."""
    m = np.arange(terms - 1, 0.0, -1.0)
    x = np.clip((m / terms - 0.25) / 0.75, 1e-9, 1 - 1e-9)
    window = 1.0 / (1.0 + np.exp(np.clip(1.0 / (1.0 - x) - 1.0 / x, -700, 700)))
    return math.fsum(term(m * theta) * window / m**power)


@pytest.mark.parametrize("power", POWERS)
def test_polylogarithms_equal_plain_sums(power):
    for theta in PHASES:
        assert cosine_sum(power, theta) == pytest.approx(
            smooth_sum(power, theta, np.cos), abs=5e-15
        )
        assert sine_sum(power, theta) == pytest.approx(smooth_sum(power, theta, np.sin), abs=5e-15)


def test_values_known_exactly():
    theta = np.linspace(1e-6, math.pi, 50)
    np.testing.assert_allclose(
        sine_sum(3, theta), math.pi**2 * theta / 6 - math.pi * theta**2 / 4 + theta**3 / 12, 1e-14
    )
    defect = math.pi * theta / 2 - theta**2 / 4
    np.testing.assert_allclose(cosine_defect(2, theta), defect, 1e-14)
    assert cosine_sum(3, math.pi) == pytest.approx(-0.75 * ZETA3, rel=1e-15)
    assert cosine_sum(3, math.pi / 2) == pytest.approx(-3 / 32 * ZETA3, rel=3e-15)
    np.testing.assert_allclose(cosine_sum(1, theta), -np.log(2 * np.sin(theta / 2)), 1e-14)
    np.testing.assert_allclose(sine_sum(1, theta), (math.pi - theta) / 2, 1e-13)
    assert math.isinf(cosine_sum(1, 0.0))
    assert power_sum(3) == pytest.approx(ZETA3, rel=1e-15)
    assert math.isinf(power_sum(1))


def test_small_phases_keep_their_digits():
    """To leading orders Σ(1 − cos mθ)/m³ = θ²(3/2 − ln θ)/2 and Σ sin(mθ)/m⁴ = ζ(3)θ."""
    theta = np.logspace(-12, -5, 15)
    np.testing.assert_allclose(cosine_defect(3, theta), theta**2 * (1.5 - np.log(theta)) / 2, 1e-11)
    np.testing.assert_allclose(sine_sum(4, theta), ZETA3 * theta, 1e-9)
    np.testing.assert_array_equal(cosine_defect(3, [0.0]), [0.0])
    np.testing.assert_array_equal(sine_sum(4, [0.0]), [0.0])


@given(st.integers(2, 7), st.floats(-3.1, 3.1), st.integers(1, 40))
def test_parity_period_and_tails(power, theta, reach):
    for k in (reach, "all"):
        assert cosine_defect(power, -theta, k) == cosine_defect(power, theta, k)
        assert sine_sum(power, -theta, k) == -sine_sum(power, theta, k)
        turned = sine_sum(power, theta + 2 * math.pi, k)
        assert turned == pytest.approx(float(sine_sum(power, theta, k)), abs=1e-13)
        whole = float(cosine_sum(power, theta, k) + cosine_defect(power, theta, k))
        assert whole == pytest.approx(power_sum(power, k), rel=1e-14)
    tail = abs(float(cosine_sum(power, theta) - cosine_sum(power, theta, reach)))
    assert tail <= 1.0 / ((power - 1) * reach ** (power - 1)) + 1e-14


def test_finite_sums_are_plain_sums_in_any_shape():
    theta = np.array([[0.1, 1.0], [2.0, -3.0]])
    m = np.arange(1, 8)[:, None, None]
    np.testing.assert_allclose(sine_sum(3, theta, 7), (np.sin(m * theta) / m**3).sum(0), 1e-14)
    np.testing.assert_allclose(cosine_sum(3, theta, 7), (np.cos(m * theta) / m**3).sum(0), 1e-13)
    assert cosine_sum(5, theta).shape == theta.shape


def test_sums_too_long_to_take_are_refused():
    with pytest.raises(SceneError, match="use 'all'"):
        sine_sum(3, 0.1, MOST_TERMS + 1)
