"""Which growth a step resolves: by its size in tolerances, by h μ, and by the other modes."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from nrchain.motion.integrators import INTEGRATORS, find_integrator
from nrchain.motion.integrators.radau_tableau import RUNGE_KUTTA
from nrchain.watch.growing_modes import Growth
from nrchain.watch.resolved_growth import LARGEST, SEEN, SHARE, SOLVED, Resolution

RADIUS, ATOL = 2.0, 1e-9
BACKWARD = [name for name in INTEGRATORS if name != "radau"]


def resolution(rtol=0.0, y=0.0, most=0.0, growth_limit=1.0, share=1.0):
    atol = ATOL * np.tile(np.repeat([RADIUS, 1.0], 3), 2)
    integrator = SimpleNamespace(atol=atol, rtol=rtol, growth_limit=growth_limit, share=share)
    return Resolution.of(integrator, ATOL, np.full(12, y), np.full(12, most))


def alike(*amplitudes):
    """Parts with equal coordinates, in radii and radians."""
    return np.outer(amplitudes, np.tile(np.repeat([RADIUS, 1.0], 3), 2))


def lost(rates, sizes, step, left=1e3):
    amplitudes = ATOL * np.array(sizes)
    growth = Growth(np.array(rates, float), alike(*amplitudes))
    return resolution().lost_mode(growth, step, left, amplitudes.max())


def radau_factor(z):
    """R(z) = 1 + z bᵀ(I − zA)⁻¹1, of which bᵀ is the last row of A."""
    return 1.0 + z * RUNGE_KUTTA[-1] @ np.linalg.solve(np.eye(3) - z * RUNGE_KUTTA, np.ones(3))


def test_radau_resolves_growth_up_to_the_step_it_states():
    limit = find_integrator("radau").growth_limit
    for z in np.linspace(0.0, limit, 20):
        assert radau_factor(z) == pytest.approx(math.exp(z), rel=0.02)
    assert abs(radau_factor(10.0 * limit)) < 1.0


@pytest.mark.parametrize("name", BACKWARD)
@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_backward_differences_overestimate_growth_up_to_the_step_they_state(name, order):
    """Σ_k (1 − 1/ξ)^k/k = z has a root ξ ≥ exp z up to the sum at 1/ξ = 0, the pole."""
    poles = sum(1.0 / k for k in range(1, order + 1))
    assert find_integrator(name).growth_limit <= poles
    for z in np.linspace(0.05, 0.95, 10):
        series = [-z, *(1.0 / k for k in range(1, order + 1))]
        roots = np.polynomial.Polynomial(series).roots()
        passed = [1.0 / (1.0 - x.real) for x in roots if abs(x.imag) < 1e-9 and 0.0 < x.real < 1.0]
        assert passed
        assert max(passed) >= math.exp(z)


def test_sizes_are_in_tolerances_of_radii_and_radians():
    assert resolution().over_tolerance(alike(3e-7), ATOL, 0.0)[0] == pytest.approx(3e-7 / ATOL)
    seen = resolution(rtol=1e-5, y=-0.5).over_tolerance(alike(1e-6), 0.0, 1e-5)[0]
    assert seen == pytest.approx(1e-6 / 5e-6 * math.sqrt((RADIUS**2 + 1.0) / 2.0))


def test_step_control_resolves_what_it_sees_in_steps_of_any_length():
    assert lost([10.0], [1.01 * SEEN], step=10.0) is None
    assert lost([10.0], [0.99 * SEEN], step=10.0) == 0


def test_short_steps_resolve_what_step_control_does_not_see():
    assert lost([10.0], [0.5], step=0.09) is None
    assert lost([10.0], [0.5], step=0.11) == 0


def test_what_is_far_below_the_tolerance_may_be_made_of_errors():
    assert lost([10.0], [1.01 * SOLVED], step=1e-6) is None
    assert lost([10.0], [0.99 * SOLVED], step=1e-6) == 0


def test_errors_of_spheres_that_have_come_far_hide_a_bend():
    """Step control would resolve it if spheres had not moved."""
    growth = Growth(np.array([10.0]), alike(1e-6))
    far = np.r_[np.full(6, 1.0), np.zeros(6)]
    held = resolution(rtol=1e-3)
    moved = Resolution(held.unit, held.atol, held.rtol, far, far, held.growth_limit)
    assert held.lost_mode(growth, 1e-6, 1e3, 1e-6) is None
    assert moved.over_tolerance(growth.parts, ATOL, 1e-3)[0] > SEEN
    assert moved.lost_mode(growth, 1e-6, 1e3, 1e-6) == 0
    assert moved.finer_tolerances(growth.parts[0]).startswith("run.rtol = ")


def test_what_stays_below_the_tolerance_does_not_matter():
    folds = math.log(1.0 / 0.5)
    assert lost([10.0], [0.5], step=10.0, left=0.09 * folds) is None
    assert lost([10.0], [0.5], step=10.0, left=0.11 * folds) == 0


def test_what_is_a_small_part_of_the_bend_by_then_does_not_matter():
    """The bend of 1000 tolerances at rate 10 is large after a time in which the other grows too."""
    large = 1e3
    time = math.log(LARGEST / (large * ATOL)) / 10.0
    needed = SHARE * LARGEST / ATOL * math.exp(-20.0 * time)
    assert lost([10.0, 20.0], [large, 0.9 * needed], step=1.0) is None
    assert lost([10.0, 20.0], [large, 1.1 * needed], step=1.0) == 1


@pytest.mark.parametrize(
    ("size", "rtol", "moved", "advised"),
    [
        (2.0, 0.0, 0.0, "run.atol = 2e-11"),
        (300.0, 1e-3, 1.0, "run.rtol = 2e-09"),
        (2.0, 1e-3, 1.0, "run.atol = 2e-11 and run.rtol = 3e-11"),
        (1e-5, 0.0, 0.0, ""),
    ],
)
def test_the_tolerance_named_is_the_one_that_hides_it(size, rtol, moved, advised):
    part = alike(size * ATOL)[0]
    assert resolution(rtol=rtol, y=moved, most=moved).finer_tolerances(part) == advised


def test_tolerances_are_named_as_those_of_the_run():
    """20 times those of a step, where steps have a twentieth: 2e-11 and 3e-11, see above."""
    part = alike(2.0 * ATOL)[0]
    named = resolution(rtol=1e-3, y=1.0, most=1.0, share=0.05).finer_tolerances(part)
    assert named == "run.atol = 4e-10 and run.rtol = 6e-10"
