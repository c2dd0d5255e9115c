"""Linear systems of Radau IIA where spheres far along the chain touch: against dense matrices."""

from ctypes import CFUNCTYPE, c_int32, c_ssize_t

import numpy as np
import pytest
from support.stepping import folded, prepare

import nrchain
from nrchain.motion.integrators.linear import RESIDUAL
from nrchain.motion.integrators.radau_steps import (
    AT,
    FACTORISE,
    LINEARISE,
    SOLVE_PAIR,
    SOLVE_REAL,
    STEP,
    STILL,
)
from nrchain.motion.integrators.radau_tableau import COMPLEX, REAL


def systems(scene, step):
    """The equation of a chain with factors at its start, J in full, and J near the diagonal."""
    chain, integrator = prepare(scene, "radau", 1e-6)
    equation, rows = integrator.equation, integrator._places
    equation.numbers[[AT, STEP]] = 0.0, step
    call(equation, LINEARISE, equation.vectors[STILL])
    call(equation, FACTORISE, equation.vectors[STILL])
    chain.linearise(0.0, np.zeros(chain.dimension))
    return equation, rows, chain.jacobian(), chain.near_jacobian().toarray()


def call(equation, which, vector):
    """Solve as the steps do."""
    solve = CFUNCTYPE(c_int32, *5 * (c_ssize_t,))(int(equation.functions[which]))
    context = int(equation.functions[-1])
    assert solve(context, vector.ctypes.data, 0, 0, which) == 0


@pytest.mark.parametrize("ends", ["free", "clamped"])
@pytest.mark.parametrize("step", [1e-3, 0.1, 10.0])
@pytest.mark.parametrize(("which", "eigenvalue"), [(SOLVE_REAL, REAL), (SOLVE_PAIR, COMPLEX)])
def test_far_pairs_are_solved_for(which, eigenvalue, step, ends):
    """After preconditioning, residuals are below their bound; without far pairs they are not."""
    equation, rows, whole, near = systems(folded(ends=ends), step)
    left_out = np.abs(whole - near)
    assert left_out.max() > 0.1 * np.abs(near).max()
    rng, size = np.random.default_rng(0), len(whole)
    right = rng.standard_normal(size)
    if which == SOLVE_PAIR:
        right = right + 1j * rng.standard_normal(size)
    vector = np.zeros(equation.vectors.shape[1], right.dtype)
    vector[rows] = right
    call(equation, which, vector)
    matrix, factors = (np.eye(size) - step / eigenvalue * part for part in (whole, near))
    begin = np.linalg.solve(factors, right)

    def residual(found):
        return np.linalg.norm(np.linalg.solve(factors, right - matrix @ found))

    assert residual(vector[rows]) < 1.001 * RESIDUAL * np.linalg.norm(begin)
    if step > 1e-3:
        assert residual(begin) > 10.0 * RESIDUAL * np.linalg.norm(begin)


def test_without_far_pairs_factors_are_enough():
    """Legs apart by more than the range: factors alone solve, and GMRES is not compiled."""
    scene = folded()
    positions = np.array(scene.start.positions)
    positions[:, 1] *= 1.5
    apart = nrchain.load_scene(scene, **{"start.positions": positions.tolist()})
    equation, rows, whole, near = systems(apart, 0.1)
    assert np.abs(whole - near).max() < 1e-9 * np.abs(near).max()
    vector, right = np.zeros(equation.vectors.shape[1]), np.arange(float(len(rows)))
    vector[rows] = right
    assert equation.functions[SOLVE_REAL] == equation.functions[FACTORISE]
    call(equation, SOLVE_REAL, vector)
    expected = np.linalg.solve(np.eye(len(rows)) - 0.1 / REAL * near, right)
    assert vector[rows] == pytest.approx(expected, rel=1e-9, abs=1e-9)
