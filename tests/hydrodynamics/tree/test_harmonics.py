"""Real solid harmonics: their sum is 1/|x − y|, and one table shifts them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrchain.hydrodynamics.tree.harmonics import (
    LANES,
    UNITS,
    coupling,
    fill_irregular,
    fill_regular,
)

VECTORS = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array)


def regular(x, degree):
    out = np.empty((degree + 1) ** 2)
    fill_regular(*x, degree, out)
    return out


def irregular(x, degree):
    points, out = np.ones((4, LANES)), np.empty(((degree + 1) ** 2, LANES))
    points[:3] = np.asarray(x)[:, None]
    fill_irregular(points, degree, out)
    assert (out == out[:, :1]).all()
    return out[:, 0]


def shift_tensor(degree):
    """G_cab as a full array, from its table of two terms."""
    table, count = coupling(degree), (degree + 1) ** 2
    tensor = np.zeros(((2 * degree + 1) ** 2, count, count))
    a, b = np.indices((count, count))
    np.add.at(tensor, (table.first, a, b), table.first_weight)
    np.add.at(tensor, (table.second, a, b), table.second_weight)
    return tensor


@pytest.mark.parametrize("degree", [2, 5, 9])
def test_their_sum_is_the_inverse_distance(degree):
    x, y = np.array([3.0, -2.0, 1.5]), np.array([0.3, 0.5, -0.4])
    ratio = np.linalg.norm(y) / np.linalg.norm(x)
    found = regular(y, degree) @ irregular(x, degree)
    assert found == pytest.approx(1 / np.linalg.norm(x - y), rel=2 * ratio ** (degree + 1))


@given(x=VECTORS, y=VECTORS)
def test_regular_harmonics_of_a_sum(x, y):
    degree = 4
    tensor = shift_tensor(degree)[: (degree + 1) ** 2]
    found = np.einsum("cab,a,b", tensor, regular(x, degree), regular(y, degree))
    np.testing.assert_allclose(found, regular(x + y, degree), rtol=0, atol=1e-14)


def test_the_inverse_distance_of_two_displaced_points():
    degree, far = 9, np.array([4.0, 3.0, -5.0])
    x, y = np.array([0.5, -0.3, 0.2]), np.array([-0.4, 0.1, 0.6])
    across = np.einsum("cab,c->ab", shift_tensor(degree), irregular(far, 2 * degree))
    across[np.sqrt(np.arange(len(across))).astype(int) % 2 == 1] *= -1
    found = regular(x, degree) @ across @ regular(y, degree)
    assert found == pytest.approx(1 / np.linalg.norm(far + x - y), rel=1e-8)


def test_slopes_of_the_first_degree():
    for k, (a, slope) in enumerate(UNITS):
        step = np.zeros(3)
        step[k] = 0.7
        expected = np.zeros(4)
        expected[[0, a]] = 1.0, 0.7 * slope
        np.testing.assert_allclose(regular(step, 1), expected, atol=1e-16)
