"""The clamped filament with a follower force: the beam, the effect, and short chains."""

import cmath

import numpy as np
import pytest

import nrchain
from validation.states import beam
from validation.states.benchmark import cantilever, order, threshold, units
from validation.states.cantilever import Cantilever, cantilevers


@pytest.fixture(autouse=True)
def effect():
    with cantilevers():
        yield


def test_without_a_force_the_beam_has_the_rates_of_a_cantilever():
    """Λ = −m⁴ with cos m cosh m = −1."""
    for m in (1.8751040687119611, 4.694091132974175):
        assert abs(cmath.cos(m) * cmath.cosh(m) + 1.0) < 1e-10
        near = abs(beam.determinant(-(m**4) * 1.01, 0.0))
        assert abs(beam.determinant(-(m**4), 0.0)) < 1e-9 * near


def test_the_slowest_rates_merge_at_the_load_of_beck():
    assert beam.merging() == pytest.approx(beam.BECK, rel=1e-7)


def test_the_beam_flutters_as_a_matrix_of_differences_does():
    """Centred differences on 400 points, of order 2; ghost points keep y'' = y''' = 0."""
    force, frequency = beam.flutter()
    count = 400
    h = 1.0 / count
    values = np.zeros((count + 5, count))
    # y₋₁ = y₁ and y₀ = 0 at the clamp; y_{n+1}, y_{n+2} from y'' = y''' = 0 at the free end
    for k in range(count):
        values[k + 2, k] = 1.0
    values[0] = values[2]
    values[count + 2] = 2.0 * values[count + 1] - values[count]
    values[count + 3] = 2.0 * values[count + 2] - 2.0 * values[count] + values[count - 1]
    values = values[: count + 4]
    second = np.diff(values, 2, axis=0)[1:-1] / h**2
    fourth = np.diff(values, 4, axis=0) / h**4
    rates = np.linalg.eigvals(-fourth - force * second)
    leading = rates[np.argmax(rates.real)]
    assert abs(leading.real) < 0.02 * frequency
    assert abs(leading.imag) == pytest.approx(frequency, rel=0.02)


def test_the_effect_has_the_derivative_of_its_wrench():
    nrchain.check_effect(Cantilever, cantilever(5))


def test_the_threshold_of_a_chain_tends_to_that_of_the_beam():
    found = [threshold(count) for count in (10, 20)]
    links = np.array([one.link for one in found])
    forces = np.array([one.force for one in found])
    expected, _ = beam.flutter()
    assert order(links, forces - expected) == pytest.approx(1.0, abs=0.25)
    limit = np.polynomial.Polynomial.fit(links, forces, 1)(0.0)
    assert limit == pytest.approx(expected, rel=0.02)
    assert found[1].frequency == pytest.approx(beam.flutter(links[1])[1], rel=0.02)


def test_beyond_the_threshold_the_filament_whirls_steadily():
    onset = threshold(10)
    force, (length, _, rate) = onset.scene.cantilever.force, units(onset.scene)
    state = nrchain.find_state(cantilever(10, 1.01 * force), nudge=0.5)
    assert state.is_stable
    assert abs(state.rotation[0]) / rate == pytest.approx(onset.frequency, rel=0.02)
    assert 0.01 < np.linalg.norm(state.positions[:, 1:], axis=1).max() / length < 0.2
