"""The Cayley map of SO(3) against matrices, scipy's rotations and differences.

Angles are swept over fifteen decades, where a formula that cancels would show.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nrchain.geometry import lie

SIZES = [0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3]
EPSILON = np.finfo(float).eps
vectors = st.tuples(*[st.floats(-3, 3)] * 3).map(np.array)


def hat(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0.0]])


def call(function, *arguments, shape=(3,)):
    out = np.empty(shape)
    function(*arguments, out)
    return out


def cayley(theta):
    return call(lie.cayley, theta, shape=(3, 3))


def sample(size, seed=0):
    return size * np.random.default_rng(seed).standard_normal(3)


@pytest.mark.parametrize("size", SIZES)
def test_cayley_is_its_definition_and_orthonormal(size):
    theta = sample(size)
    half = hat(theta) / 2
    rotation = cayley(theta)
    assert rotation == pytest.approx(np.linalg.solve(np.eye(3) - half, np.eye(3) + half), abs=1e-13)
    # an entry up to 1 from products up to 2 carries 7 roundings of those and one of its own, each
    # of half an epsilon; a row squared carries 2√3 of them
    assert np.abs(rotation @ rotation.T - np.eye(3)).max() < 2 * np.sqrt(3) * 7.5 * EPSILON


@pytest.mark.parametrize("size", SIZES[1:])
def test_cayley_turns_by_twice_the_arctangent(size):
    theta = sample(size)
    angle = 2 * np.arctan(np.linalg.norm(theta) / 2)
    expected = Rotation.from_rotvec(angle * theta / np.linalg.norm(theta))
    assert cayley(theta) == pytest.approx(expected.as_matrix(), abs=1e-14)


@pytest.mark.parametrize("size", SIZES[1:-1])
def test_inverse_cayley_returns_every_digit(size):
    theta = sample(size)
    back = call(lie.inverse_cayley, cayley(theta))
    # near a half turn θ ~ 10 the trace cancels and takes digits with it
    assert back == pytest.approx(theta, rel=1e-15 * (4 + size**2) * 10)


@given(vectors, vectors)
def test_rate_and_tangent_are_inverse(theta, omega):
    rate = call(lie.rate, theta, omega)
    forward = call(lie.tangent, theta, shape=(3, 3))
    backward = call(lie.inverse_tangent, theta, shape=(3, 3))
    assert forward @ rate == pytest.approx(omega, abs=1e-12)
    assert backward @ omega == pytest.approx(rate, abs=1e-12)


@pytest.mark.parametrize("size", [1e-9, 1e-3, 1.0, 5.0])
def test_tangent_is_the_angular_velocity_of_the_rotation(size):
    theta, change, step = sample(size), sample(1.0, seed=1), 1e-5
    ahead, behind = cayley(theta + step * change), cayley(theta - step * change)
    spin = (ahead - behind) / (2 * step) @ cayley(theta).T
    omega = call(lie.tangent, theta, shape=(3, 3)) @ change
    assert omega == pytest.approx([spin[2, 1], spin[0, 2], spin[1, 0]], abs=1e-8)


@pytest.mark.parametrize("size", [0.0, 1e-3, 1.0, 5.0])
def test_rate_derivative_against_differences(size):
    theta, omega, step = sample(size), sample(1.0, seed=2), 1e-5
    exact = call(lie.rate_derivative, theta, omega, shape=(3, 3))
    rates = [
        (call(lie.rate, theta + step * e, omega) - call(lie.rate, theta - step * e, omega))
        / (2 * step)
        for e in np.eye(3)
    ]
    assert exact == pytest.approx(np.array(rates).T, abs=1e-8 * (1 + size**2))


@given(vectors, st.floats(1e-9, 1e-3))
def test_orthonormalise_repairs_a_frame(theta, noise):
    """A singular value 1 + e becomes 1 − 3e²/2, and then 1 − 27e⁴/8."""
    exact = cayley(theta)
    error = noise * np.random.default_rng(0).standard_normal((3, 3))
    frame = exact + error
    lie.orthonormalise(frame[None])
    largest = np.linalg.norm(error, 2)
    left = 2 * 27 / 8 * largest**4 * (1 + 10 * largest) + 10 * EPSILON
    assert np.abs(frame @ frame.T - np.eye(3)).max() < left
    assert np.abs(frame - exact).max() < 2 * largest
