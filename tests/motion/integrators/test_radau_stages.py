"""The stage equations of Radau IIA: order conditions, decoupling and stability."""

import numpy as np
import pytest

from nrchain.motion.integrators.radau_stages import (
    COMPLEX,
    NODES,
    REAL,
    RUNGE_KUTTA,
    StageSystem,
    cubics,
    powers,
)


class Matrix:
    """A constant Jacobian."""

    def __init__(self, matrix):
        self.array = np.atleast_2d(matrix)

    def update(self, time, y):
        pass

    def matrix(self):
        return self.array

    def shifted_inverse(self, scale):
        inverse = np.linalg.inv(np.eye(len(self.array)) - scale * self.array)
        return lambda right: inverse @ right


def linear_system(matrix, step):
    """Stages of ẏ = M (y₀ + y), so that increments start from y₀ = 1."""
    jacobian = Matrix(matrix)
    start = np.ones(len(jacobian.array))

    def rates(time, y, out):
        out[:] = jacobian.array @ (start + y)

    system = StageSystem(rates, jacobian, len(start))
    system.factorise(step)
    return system, start


def solve(system, dimension):
    return system.solve(0.0, np.zeros((3, dimension)), np.ones(dimension), 1e-12, 1e-15)


def test_order_conditions():
    """B(5) and C(3): the quadrature is exact to degree 4, the stages to degree 2."""
    weights = RUNGE_KUTTA[-1]
    for k in range(1, 6):
        assert weights @ NODES ** (k - 1) == pytest.approx(1 / k, abs=1e-15)
    assert weights @ NODES**5 != pytest.approx(1 / 6, abs=1e-4)
    for k in range(1, 4):
        assert pytest.approx(NODES**k / k, abs=1e-15) == RUNGE_KUTTA @ NODES ** (k - 1)


def test_eigenvalues():
    """Sec. IV.8: γ̂ = (6 + 81^{1/3} − 9^{1/3})/30 and the pair that belongs to it."""
    gamma = (6 + 81 ** (1 / 3) - 9 ** (1 / 3)) / 30
    assert pytest.approx(1 / gamma, rel=1e-13) == REAL
    inverse = np.linalg.inv(RUNGE_KUTTA)
    assert REAL + 2 * COMPLEX.real == pytest.approx(np.trace(inverse), rel=1e-13)
    assert REAL * abs(COMPLEX) ** 2 == pytest.approx(np.linalg.det(inverse), rel=1e-13)


def test_stages_of_a_linear_problem_take_one_iteration():
    rng = np.random.default_rng(3)
    matrix, step = rng.standard_normal((5, 5)), 0.7
    system, start = linear_system(matrix, step)
    outcome = solve(system, 5)
    large = np.eye(15) - step * np.kron(RUNGE_KUTTA, matrix)
    forcing = step * np.kron(RUNGE_KUTTA.sum(axis=1), matrix @ start)
    assert outcome.converged
    assert outcome.iterations == 2
    assert outcome.rate < 1e-13
    assert outcome.stages.ravel() == pytest.approx(np.linalg.solve(large, forcing), abs=1e-13)
    assert system.solves == 4


@pytest.mark.parametrize("z", [-1e-3, -0.3, -5.0, -1e3, -1e8, -1e12])
def test_stability_function(z):
    """y₁/y₀ = (1 + 2z/5 + z²/20)/(1 − 3z/5 + 3z²/20 − z³/60): 0 as z → −∞."""
    system, _ = linear_system([[z]], 1.0)
    ratio = 1.0 + solve(system, 1).stages[-1, 0]
    expected = (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60)
    assert ratio == pytest.approx(expected, abs=1e-14)


def test_error_estimate_is_of_fourth_order_and_bounded_for_stiff_modes():
    sizes = []
    for step in (0.02, 0.01):
        system, start = linear_system([[-1.0]], step)
        stages = solve(system, 1).stages
        sizes.append(abs(system.error(-start, stages)[0]))
    assert np.log2(sizes[0] / sizes[1]) == pytest.approx(4.0, abs=0.05)
    system, start = linear_system([[-1e10]], 1.0)
    stages = solve(system, 1).stages
    error = system.error(-1e10 * start, stages)
    assert abs(error[0]) < 2.0
    assert abs(system.filtered_error(0.0, stages, error)[0]) < 1e-8


def test_an_iteration_that_diverges_says_so():
    def rates(time, y, out):
        out[:] = 30.0 * (1.0 + y)

    system = StageSystem(rates, Matrix([[-30.0]]), 1)
    system.factorise(1.0)
    assert not solve(system, 1).converged


def test_rates_that_are_not_finite_end_the_iteration():
    def rates(time, y, out):
        out[:] = np.inf

    system = StageSystem(rates, Matrix([[0.0]]), 1)
    system.factorise(1.0)
    assert not solve(system, 1).converged


def test_cubics_interpolate():
    coefficients = cubics(NODES)
    for j, node in enumerate(NODES):
        assert coefficients @ powers(node) == pytest.approx(np.eye(3)[j], abs=1e-13)
    cubic = np.array([0.3, -1.2, 0.8])
    values = np.array([cubic @ powers(node) for node in NODES])
    assert (coefficients @ powers(1.7)) @ values == pytest.approx(cubic @ powers(1.7))
