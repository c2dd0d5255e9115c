"""(I − cJ) x = b by blocks against dense matrices, for open, periodic and clamped chains."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import lapack

from nrchain.motion.band_columns import FINE, SINGULAR
from nrchain.motion.block_elimination import UNSTABLE, Elimination

EPS = np.finfo(float).eps


class System(NamedTuple):
    blocks: np.ndarray
    held: np.ndarray
    periodic: bool
    scale: complex

    def dense(self):
        """I − cJ as a matrix."""
        count, width = self.blocks.shape[:2]
        jacobian = np.zeros((count, 6, count, 6))
        for i in range(count):
            for m in range(width):
                j = i + m - width // 2
                if self.periodic or 0 <= j < count:
                    jacobian[i, :, j % count] += self.blocks[i, m]
        jacobian[self.held] = 0.0
        jacobian[:, :, self.held] = 0.0
        return np.eye(6 * count) - self.scale * jacobian.reshape(6 * count, -1)

    def solved(self, right):
        """The status and the solution by blocks."""
        held, kind = self.held.astype(np.int64), type(self.scale)
        elimination = Elimination(self.blocks, held, self.periodic, kind)
        status = elimination.factorise(self.scale)
        found = right.astype(kind)
        if status == FINE:
            elimination.solve(found)
        return status, found


def random_system(seed, count, reach, periodic, scale, clamped=False):
    rng = np.random.default_rng(seed)
    blocks = rng.standard_normal((count, 2 * reach + 1, 6, 6))
    held = rng.random(count) < (0.3 if clamped else 0.0)
    return System(blocks, held, periodic, scale), rng.standard_normal((count, 6))


def backward_error(system, right, found):
    """‖b − Ax‖ / (‖A‖ ‖x‖ + ‖b‖), Higham, Accuracy and Stability, 2nd ed., Theorem 7.1."""
    matrix = system.dense()
    residual = np.abs(right.ravel() - matrix @ found.ravel()).max()
    norm = np.abs(matrix).sum(axis=1).max()
    return residual / (norm * np.abs(found).max() + np.abs(right).max())


def bound(system, reach):
    """A bound on the backward error of elimination with growth ρ ≤ 10: 3 n ε ρ.

    Every element takes part in n = 6 (3w + 1) operations (Higham, section 9.3). A cut chain also
    has the response of its interior to the cut.
    """
    stable = 3 * 6 * (3 * reach + 1) * EPS * 10
    count = len(system.blocks)
    inner = 6 * (count - min(reach, count))
    if not system.periodic or inner in (0, 6 * count):
        return stable
    matrix = system.dense()
    response = np.linalg.solve(matrix[:inner, :inner], matrix[:inner, inner:])
    return stable * (1 + np.abs(response).sum(axis=1).max()) ** 2


systems = {
    "seed": st.integers(0, 2**32 - 1),
    "count": st.integers(1, 11),
    "reach": st.sampled_from([0, 1, 2, 3, 8]),
    "periodic": st.booleans(),
    "clamped": st.booleans(),
    "size": st.floats(-6, 6).map(lambda power: 10.0**power),
    "direction": st.sampled_from([1.0, -1.0, 1j, 0.6 - 0.8j]),
}


@settings(deadline=None, max_examples=200)
@given(**systems)
def test_residual_has_the_size_of_rounding(seed, count, reach, periodic, clamped, size, direction):
    system, right = random_system(seed, count, reach, periodic, size * direction, clamped)
    status, found = system.solved(right)
    assert status == FINE
    assert backward_error(system, right, found) <= bound(system, reach)


@pytest.mark.parametrize("scale", [1.0, 1.0 + 2.0j])
def test_clamped_spheres_keep_their_right_hand_side(scale):
    system, right = random_system(0, 12, 3, True, scale, clamped=True)
    _, found = system.solved(right)
    assert system.held.any()
    assert np.array_equal(found[system.held], right[system.held])


@pytest.mark.parametrize("scale", [1.0, 1.0 + 0.0j])
@pytest.mark.parametrize("size", [0.0, 1e-16, 1e-8])
def test_a_leading_block_that_is_nearly_singular(scale, size):
    """Rows of other spheres give the pivots: no growth of 1/size."""
    system, right = random_system(1, 9, 2, False, scale)
    system.blocks[:4, 2] = np.eye(6) - size * system.blocks[:4, 2]
    status, found = system.solved(right)
    assert status == FINE
    assert backward_error(system, right, found) <= bound(system, 2)


@pytest.mark.parametrize("scale", [1.0, 0.6 + 0.8j])
@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("reach", [1, 2, 3])
def test_rows_that_interchange_between_all_spheres(reach, periodic, scale):
    """Spheres w apart exchange their rows: the pivots of one are in the rows of the other."""
    count = 36
    system, right = random_system(10, count, reach, periodic, scale)
    system.blocks[:] *= 0.1
    for i in range(count):
        is_first = i // reach % 2 == 0
        system.blocks[i, reach] += (np.eye(6) / scale).real
        system.blocks[i, 2 * reach if is_first else 0] += 50.0 * np.eye(6)
    status, found = system.solved(right)
    assert status == FINE
    expected = np.linalg.solve(system.dense(), right.ravel())
    condition = np.linalg.cond(system.dense(), np.inf)
    assert condition < 1e4
    allowed = 2 * condition * bound(system, reach)
    assert np.abs(found.ravel() - expected).max() <= allowed * np.abs(expected).max()


@pytest.mark.parametrize("scale", [1.0, 0.6 + 0.8j])
@pytest.mark.parametrize("reach", [0, 1, 2, 3])
def test_rows_that_interchange_within_spheres(reach, scale):
    """Diagonal blocks that are permutations: six interchanges or fewer, and no fill."""
    system, right = random_system(11, 12, reach, False, scale)
    rng = np.random.default_rng(12)
    system.blocks[:] *= 1e-3
    for i in range(12):
        system.blocks[i, reach] += (np.eye(6) / scale).real - 50.0 * np.eye(6)[rng.permutation(6)]
    status, found = system.solved(right)
    assert status == FINE
    assert backward_error(system, right, found) <= bound(system, reach)


@pytest.mark.parametrize("scale", [1.0, 0.6 + 0.8j])
@pytest.mark.parametrize("sphere", [0, 7, 18, 19])
def test_one_sphere_that_interchanges_in_a_chain_that_does_not(sphere, scale):
    """The matrix is taken anew with room for fill, where only one sphere needs it."""
    system, right = random_system(13, 20, 3, False, scale)
    system.blocks[:, 3] -= 100.0 * np.eye(6)
    assert system.solved(right)[0] == FINE
    system.blocks[sphere, 3] = (np.eye(6) / scale).real
    status, found = system.solved(right)
    assert status == FINE
    assert backward_error(system, right, found) <= bound(system, 3)


def test_rows_that_are_not_needed_change_nothing():
    """A chain without interchanges has the same bits before and after another that has them."""
    plain, right = random_system(14, 12, 2, False, 1.0)
    plain.blocks[:, 2] -= 100.0 * np.eye(6)
    hard, _ = random_system(15, 12, 2, False, 1.0)
    blocks = plain.blocks.copy()
    elimination = Elimination(blocks, np.zeros(12, np.int64), False, float)
    solutions = []
    for taken in (plain, hard, plain):
        blocks[:] = taken.blocks
        assert elimination.factorise(1.0) == FINE
        solutions.append(right.copy())
        elimination.solve(solutions[-1])
    assert np.array_equal(solutions[0], solutions[2])
    assert backward_error(hard, right, solutions[1]) <= bound(hard, 2)


@settings(deadline=None, max_examples=50)
@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from([1.0, 1.0 + 0.5j]))
def test_an_indefinite_matrix(seed, scale):
    """Modes that grow give I − cJ eigenvalues of both signs."""
    system, right = random_system(seed, 10, 3, False, scale)
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], (10, 6))
    system.blocks[:, 3] = 1e3 * np.einsum("np,pq->npq", signs, np.eye(6))
    status, found = system.solved(right)
    assert status == FINE
    assert backward_error(system, right, found) <= bound(system, 3)


@pytest.mark.parametrize("scale", [0.7, 0.7 - 0.4j])
@pytest.mark.parametrize(("count", "reach"), [(20, 1), (20, 3), (64, 3)])
def test_lapack_finds_the_same_solution(count, reach, scale):
    """Both have errors of at most the condition number times their backward errors."""
    system, right = random_system(3, count, reach, False, scale)
    matrix, half = system.dense(), 6 * reach + 5
    band = np.zeros((3 * half + 1, 6 * count), matrix.dtype)
    for row, column in np.argwhere(matrix):
        band[2 * half + row - column, column] = matrix[row, column]
    (gbsv,) = lapack.get_lapack_funcs(("gbsv",), (band,))
    *_, expected, info = gbsv(half, half, band, right.ravel())
    assert info == 0
    _, found = system.solved(right)
    allowed = 2 * np.linalg.cond(matrix, np.inf) * bound(system, reach)
    assert np.abs(found.ravel() - expected).max() <= allowed * np.abs(expected).max()


def test_arrays_serve_again_after_interchanges_and_not_finite_numbers():
    first, right = random_system(4, 8, 2, True, 1.0)
    second, _ = random_system(5, 8, 2, True, 1.0)
    blocks = first.blocks.copy()
    elimination = Elimination(blocks, np.zeros(8, np.int64), True, float)
    assert elimination.factorise(1.0) == FINE
    elimination.solve(np.full((8, 6), np.nan))
    blocks[:] = np.inf
    assert elimination.factorise(1.0) != FINE
    blocks[:] = second.blocks
    assert elimination.factorise(1.0) == FINE
    found = right.copy()
    elimination.solve(found)
    assert np.array_equal(found, second.solved(right)[1])


@pytest.mark.parametrize("scale", [1.0, 1.0 + 2.0j])
@pytest.mark.parametrize("periodic", [False, True])
def test_spheres_that_are_left_out_have_zeros(scale, periodic):
    system, right = random_system(9, 11, 2, periodic, scale)
    spheres = np.array([1, 2, 5, 10])
    elimination = Elimination(system.blocks, np.zeros(11, np.int64), periodic, type(scale))
    assert elimination.factorise(scale) == FINE
    whole = np.zeros_like(right, dtype=type(scale))
    whole[spheres] = right[spheres]
    found = right[spheres].astype(type(scale)).ravel()
    elimination.solve(found, spheres)
    elimination.solve(whole)
    assert np.array_equal(found, whole[spheres].ravel())


@pytest.mark.parametrize("scale", [1.0, 1.0 + 0.0j])
@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_matrix_without_inverse_is_singular(scale, value):
    """A row of zeros, and one without numbers."""
    system, right = random_system(6, 6, 1, False, scale)
    system.blocks[2] = 0.0
    system.blocks[2, 1] = np.eye(6)
    system.blocks[2, 1, 4, 4] += value
    assert system.solved(right)[0] == SINGULAR


@pytest.mark.parametrize("offset", [0.0, 1e-14])
def test_a_periodic_chain_whose_interior_alone_is_singular_is_refused(offset):
    """Sphere 0 has no coupling but to the last sphere, where the chain is cut."""
    system, right = random_system(7, 5, 1, True, 1.0)
    system.blocks[0] = 0.0
    system.blocks[0, 1] = (1.0 + offset) * np.eye(6)
    system.blocks[0, 0] = np.eye(6)
    system.blocks[[1, 4], [0, 2]] = np.eye(6)
    system.blocks[1, 0] = 0.0
    assert np.linalg.cond(system.dense()) < 1e4
    assert system.solved(right)[0] == UNSTABLE


def test_responses_that_decay_below_all_floats_leave_no_trace():
    """Ends of a long stiff chain do not feel each other."""
    system, right = random_system(8, 900, 1, True, 1.0)
    system.blocks[:, 1] -= 60.0 * np.eye(6)
    status, found = system.solved(right)
    assert status == FINE
    middle = slice(400, 500)
    inner = System(system.blocks[300:600], system.held[300:600], False, 1.0)
    _, alone = inner.solved(right[300:600])
    assert found[middle] == pytest.approx(alone[100:200], rel=1e-12, abs=1e-14)
