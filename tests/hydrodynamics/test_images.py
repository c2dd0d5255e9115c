"""A few weighted images stand for all: against Hurwitz's zeta function."""

import numpy as np
import pytest
from scipy.special import zeta

from nrchain.hydrodynamics.images import EXACT, POINTS, image_offsets


def one_side():
    offsets, weights = image_offsets()
    return offsets[offsets > 0], weights[offsets > 0]


@pytest.mark.parametrize("power", range(2, 2 * POINTS + 2))
def test_every_power_it_promises(power):
    offsets, weights = one_side()
    assert weights @ offsets**-power == pytest.approx(zeta(power), rel=2e-15)


@pytest.mark.parametrize("x", [-1.0, -0.6, 0.3, 1.0])
def test_flows_seen_from_within_the_chain(x):
    # Σ_{p>2} (p + x)^−2, with x up to a whole period
    offsets, weights = one_side()
    beyond = offsets > EXACT + 1e-9
    sum_beyond = weights[beyond] @ (offsets[beyond] + x) ** -2.0
    assert sum_beyond == pytest.approx(zeta(2, EXACT + 1 + x), rel=1e-11)


def test_both_sides_are_alike_and_the_chain_itself_is_left_out():
    offsets, weights = image_offsets()
    assert len(offsets) == 2 * (EXACT + POINTS)
    assert np.array_equal(offsets, -offsets[::-1])
    assert np.array_equal(weights, weights[::-1])
    assert np.abs(offsets).min() == 1.0


def test_error_falls_geometrically_with_the_points():
    errors = []
    for points in (2, 3, 4, 5):
        offsets, weights = image_offsets(EXACT, points)
        right = offsets > EXACT + 1e-9
        errors.append(abs(weights[right] @ (offsets[right] - 1.0) ** -2.0 - zeta(2, EXACT)))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert (ratios > 30).all()
