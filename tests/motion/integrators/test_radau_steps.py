"""Single steps of Radau IIA: order conditions, decoupling, stability and the error estimate."""

import numpy as np
import pytest
from support.stepping import Probe, prepare

import nrchain
from nrchain.motion.integrators.base import IntegrationError
from nrchain.motion.integrators.radau_steps import DEFECT
from nrchain.motion.integrators.radau_tableau import COMPLEX, NODES, REAL, RUNGE_KUTTA, cubics


def linear(matrix, step, tolerance=1e-9, slope=None):
    """Two spheres, one on either side of their centre, with v = M·(r − centre), one step on.

    Nothing else moves them: the coordinates of each are those of ẏ = M (r + y). Newton's iteration
    is given M as the derivative, or ``slope``.
    """
    elasticity = {"stretch": 0.0, "shear": 0.0, "twist": 0.0, "bend": 0.0}
    scene = nrchain.load_scene(
        {"chain": {"particles": 2}, "elasticity": elasticity, "run": {"end": 10.0 * step}}
    )

    def twist(positions):
        return np.hstack([positions @ matrix.T, np.zeros((2, 3))])

    given = np.zeros((6, 6))
    given[:3, :3] = matrix if slope is None else slope
    probe = Probe(scene, twist, given)
    return prepare(scene, "radau", tolerance, probe, fixed_step=step)


START = 5.0
"""x of the second sphere, from the centre."""


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
    """The second iteration finds nothing left to change."""
    rng = np.random.default_rng(3)
    matrix, step = rng.standard_normal((3, 3)), 0.7
    chain, integrator = linear(matrix, step)
    integrator.step()
    large = np.eye(9) - step * np.kron(RUNGE_KUTTA, matrix)
    forcing = step * np.kron(RUNGE_KUTTA.sum(axis=1), matrix @ [START, 0.0, 0.0])
    expected = np.linalg.solve(large, forcing).reshape(3, 3)
    for node, stage in zip(NODES, expected, strict=True):
        y = integrator.at(step * node)
        assert y[6:9] == pytest.approx(stage, abs=1e-12)
        assert y[:3] == pytest.approx(-stage, abs=1e-12)
    assert chain.evaluations in (7, 8)
    assert integrator.solves in (5, 6)


@pytest.mark.parametrize("z", [-1e-3, -0.3, -5.0, -1e3, -1e8, -1e12])
def test_stability_function(z):
    """y₁/y₀ = (1 + 2z/5 + z²/20)/(1 − 3z/5 + 3z²/20 − z³/60): 0 as z → −∞."""
    _, integrator = linear(z * np.eye(3), 1.0)
    integrator.step()
    ratio = 1.0 + integrator.at(1.0)[6] / START
    expected = (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60)
    assert ratio == pytest.approx(expected, abs=1e-13)


def test_the_error_estimate_is_of_fourth_order():
    sizes = []
    for step in (0.02, 0.01):
        _, integrator = linear(-np.eye(3), step, tolerance=1e-3)
        integrator.step()
        sizes.append(abs(integrator.equation.vectors[DEFECT, 6]))
    assert sizes[0] < 1e-3
    assert np.log2(sizes[0] / sizes[1]) == pytest.approx(4.0, abs=0.05)


def test_a_first_error_above_the_tolerance_is_filtered():
    """It then tends to 0 as z → −∞, where the plain estimate would be of the size of y."""
    _, integrator = linear(-1e10 * np.eye(3), 1.0)
    integrator.step()
    assert abs(integrator.equation.vectors[DEFECT, 6]) < 1e-7 * START


def test_an_iteration_that_diverges_ends_a_fixed_step():
    _, integrator = linear(30.0 * np.eye(3), 1.0, slope=-30.0 * np.eye(3))
    with pytest.raises(IntegrationError, match=r"Newton's iteration does not converge in a step"):
        integrator.step()


def test_cubics_interpolate():
    coefficients = cubics(NODES)
    powers = np.arange(1, 4)
    for j, node in enumerate(NODES):
        assert coefficients @ node**powers == pytest.approx(np.eye(3)[j], abs=1e-13)
    cubic = np.array([0.3, -1.2, 0.8])
    values = np.array([cubic @ node**powers for node in NODES])
    assert (coefficients @ 1.7**powers) @ values == pytest.approx(cubic @ 1.7**powers)
