"""Friction between spheres: a symmetric, positive mobility, against closed forms and PyStokes."""

import tracemalloc

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.pair_reference import assert_close, crooked_chain, mobility, pair_mobility
from support.poses import dense
from support.side_by_side import reads_of_the_loop

from nrchain.hydrodynamics.friction import PairFriction


def apply(fluid, positions, wrenches):
    twists = np.zeros((len(positions), 6))
    fluid.apply(positions, wrenches, twists)
    return twists


def product(fluid, positions, wrenches, poses, wrench_changes):
    fluid.apply(positions, wrenches, np.zeros((len(positions), 6)))
    twists = np.zeros((len(positions), 6))
    fluid.add_product(poses, wrench_changes, twists)
    return twists


def pair_at(distance, direction=(1.0, 0.0, 0.0)):
    """The block of a pair in units of 1/6πηa, 1/8πηa² and 1/8πηa³, for a = 1."""
    fluid = PairFriction(2, 1, 1.0, 1 / (8 * np.pi))
    block = fluid.matrix(np.array([np.zeros(3), np.multiply(distance, direction)]))[6:, :6]
    block[:3, :3] *= 0.75
    return block


def scattered(rng, count, radius, spread):
    """Random positions in a cube: for a small spread most spheres overlap."""
    return radius * spread * rng.uniform(-1.0, 1.0, (count, 3))


@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(2, 12),
    spread=st.sampled_from([0.5, 1.0, 2.0, 5.0, 30.0]),
    radius=st.sampled_from([0.2, 1.0, 4.0]),
)
@settings(max_examples=60, deadline=None)
def test_the_matrix_is_the_closed_form_symmetric_and_positive(seed, count, spread, radius):
    positions = scattered(np.random.default_rng(seed), count, radius, spread)
    matrix = PairFriction(count, count - 1, radius, 1.3).matrix(positions)
    unit = np.sqrt([[6 * np.pi * 1.3 * radius] * 3 + [8 * np.pi * 1.3 * radius**3] * 3] * count)
    scaled = matrix * np.outer(unit, unit)
    expected = mobility(positions, count - 1, radius, 1.3) * np.outer(unit, unit)
    np.testing.assert_allclose(scaled, expected, rtol=0, atol=1e-13)
    np.testing.assert_allclose(scaled, scaled.T, rtol=0, atol=1e-14)
    assert np.linalg.eigvalsh(scaled).min() > 0


def test_touching_spheres():
    """The values of Rotne, Prager and Yamakawa at r = 2a, along and across the line of centres."""
    block = pair_at(2.0)
    np.testing.assert_allclose(np.diag(block), [5 / 8, 7 / 16, 7 / 16, 1 / 8, -1 / 16, -1 / 16])
    # Wajnryb et al.: T × n and F × n, times 1/r²
    np.testing.assert_allclose(block[1, 5], 1 / 4)
    np.testing.assert_allclose(block[5, 1], -1 / 4)


@pytest.mark.parametrize("slope", [0, 1])
def test_overlapping_spheres_continue_those_apart(slope):
    """The value and the slope meet at r = 2a, to the first and zeroth power of the gap left."""
    rng = np.random.default_rng(2)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    fluid, wrenches = PairFriction(2, 1, 0.8, 1.3), rng.normal(size=(2, 6))
    towards = np.zeros((2, 6))
    towards[1, :3] = direction
    for gap in (1e-3, 1e-5, 1e-7):
        inside, outside = (
            (
                product(fluid, positions, wrenches, towards, np.zeros((2, 6)))
                if slope
                else apply(fluid, positions, wrenches)
            )
            for positions in (
                np.array([np.zeros(3), 1.6 * (1 + sign * gap) * direction]) for sign in (-1, 1)
            )
        )
        assert np.abs(outside - inside).max() < 10 * gap * np.abs(inside).max()


def test_spheres_at_one_place_move_as_one():
    rng = np.random.default_rng(3)
    positions, wrenches = np.ones((3, 3)), rng.normal(size=(3, 6))
    fluid = PairFriction(3, 2, 1.7, 0.6)
    own = pair_mobility(np.zeros(3), 1.7, 0.6)
    np.testing.assert_allclose(fluid.matrix(positions), np.kron(np.ones((3, 3)), own), rtol=1e-14)
    poses = rng.normal(size=(3, 6))
    assert np.isfinite(product(fluid, positions, wrenches, poses, np.zeros((3, 6)))).all()


def test_far_spheres_are_point_forces():
    """Oseen's tensor and its curls, the next order being (a/r)³."""
    x = np.array([300.0, -200.0, 600.0])
    r, n = 700.0, x / 700.0
    fluid = PairFriction(2, 1, 1.0, 1.3)
    block = fluid.matrix(np.array([np.zeros(3), x]))[6:, :6]
    oseen = (np.eye(3) + np.outer(n, n)) / (8 * np.pi * 1.3 * r)
    np.testing.assert_allclose(block[:3, :3], oseen, rtol=0, atol=2e-6 * oseen.max())
    gradient = np.cross(np.eye(3), n).T / (8 * np.pi * 1.3 * r**2)
    np.testing.assert_allclose(block[3:, :3], gradient, rtol=1e-12)


def stimson_jeffery(distance):
    """Speed of two equal spheres that fall along their line of centres, over that of one.

    1/λ of Stimson & Jeffery, Proc. R. Soc. A 111 (1926) 110, who tabulate λ against cosh⁻¹ r/2a.
    """
    alpha = np.arccosh(distance / 2)
    total = 0.0
    for n in range(1, 400):
        if (2 * n + 1) * alpha > 600:
            break
        numerator = 4 * np.sinh((n + 0.5) * alpha) ** 2 - (2 * n + 1) ** 2 * np.sinh(alpha) ** 2
        denominator = 2 * np.sinh((2 * n + 1) * alpha) + (2 * n + 1) * np.sinh(2 * alpha)
        weight = n * (n + 1) / ((2 * n - 1) * (2 * n + 3))
        total += weight * (1 - numerator / denominator)
    return 1 / (4 / 3 * np.sinh(alpha) * total)


def test_two_falling_spheres_against_the_exact_series():
    """Rotne, Prager and Yamakawa leave out 15/4 (a/r)⁴, the pull of the stresslets they induce."""
    for alpha, drag in ((0.02, 0.645), (0.5, 0.660), (1.0, 0.702)):
        assert 1 / stimson_jeffery(2 * np.cosh(alpha)) == pytest.approx(drag, abs=6e-4)
    for distance in (4.0, 8.0, 16.0, 32.0):
        pairwise = 1 + pair_at(distance)[0, 0]
        excess = (pairwise - stimson_jeffery(distance)) * distance**4
        assert excess == pytest.approx(15 / 4, abs=12 / distance)
    assert 1 + pair_at(4.0)[0, 0] == pytest.approx(stimson_jeffery(4.0), rel=0.011)


@pytest.mark.parametrize("spread", [1.0, 8.0])
@pytest.mark.parametrize(("reach", "period"), [(6, 0.0), (2, 0.0), (3, 19.0), (9, 19.0)])
def test_product_is_the_change_with_positions_and_wrenches(reach, period, spread):
    rng = np.random.default_rng(4)
    positions, wrenches = scattered(rng, 7, 0.9, spread), rng.normal(size=(7, 6))
    poses, changes = rng.normal(size=(7, 6)), rng.normal(size=(7, 6))
    fluid = PairFriction(7, reach, 0.9, 1.3, period)

    def at(step):
        return apply(fluid, positions + step * poses[:, :3], wrenches + step * changes)

    h = 1e-4
    expected = (8 * (at(h) - at(-h)) - at(2 * h) + at(-2 * h)) / (12 * h)
    assert_close(product(fluid, positions, wrenches, poses, changes), expected, 1e-9)


@pytest.mark.parametrize(("reach", "period"), [(7, 0.0), (2, 0.0), (2, 40.0), (9, 40.0)])
def test_blocks_of_all_pairs_are_the_product(reach, period):
    count, w = 8, 2
    rng = np.random.default_rng(5)
    positions, wrenches = crooked_chain(rng, count, 1.0)[0], rng.normal(size=(count, 6))
    wrench_blocks = rng.normal(size=(count, 2 * w + 1, 6, 6))
    if not period:
        for i in range(count):
            for m in range(-w, w + 1):
                wrench_blocks[i, w + m] *= 0 <= i + m < count
    fluid = PairFriction(count, reach, 1.0, 0.8, period)
    blocks = np.zeros((count, 2 * (reach + w) + 1, 6, 6))
    fluid.add_jacobian(positions, wrenches, wrench_blocks, blocks, near=reach)

    poses = rng.normal(size=(count, 6))
    changes = np.einsum("ipjq,jq->ip", dense(wrench_blocks, period > 0), poses)
    expected = product(fluid, positions, wrenches, poses, changes)
    assert_close(np.einsum("ipjq,jq->ip", dense(blocks, period > 0), poses), expected, 1e-13)

    narrow = np.zeros((count, 2 * reach + 1, 6, 6))
    fluid.add_jacobian(positions, wrenches, wrench_blocks, narrow, near=reach)
    np.testing.assert_array_equal(narrow, blocks[:, w:-w])


def test_blocks_of_no_pairs_are_one_body_friction():
    rng = np.random.default_rng(6)
    positions, wrench_blocks = crooked_chain(rng, 5, 1.3)[0], rng.normal(size=(5, 3, 6, 6))
    blocks = np.zeros((5, 5, 6, 6))
    fluid = PairFriction(5, 4, 1.3, 0.9)
    fluid.add_jacobian(positions, rng.normal(size=(5, 6)), wrench_blocks, blocks)
    own = pair_mobility(np.zeros(3), 1.3, 0.9)
    np.testing.assert_allclose(blocks[:, 1:-1], own @ wrench_blocks, rtol=1e-14)
    assert not blocks[:, [0, -1]].any()


@pytest.mark.parametrize(("reach", "period"), [(0, 0.0), (1, 0.0), (4, 0.0), (2, 18.0), (7, 18.0)])
def test_reach_and_images_choose_the_pairs(reach, period):
    positions = crooked_chain(np.random.default_rng(7), 5, 1.0)[0]
    matrix = PairFriction(5, reach, 1.0, 1.0, period).matrix(positions)
    assert_close(matrix, mobility(positions, reach, 1.0, 1.0, period), 1e-14)


def test_results_do_not_depend_on_the_number_of_threads():
    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("one thread only")
    count = 301
    rng = np.random.default_rng(8)
    positions = crooked_chain(rng, count, 1.0)[0]
    wrenches, poses, changes = rng.normal(size=(3, count, 6))
    fluid = PairFriction(count, count - 1, 1.0, 1.0)
    assert fluid._parallel
    results = []
    before = numba.get_num_threads()
    try:
        for threads in (1, 2):
            numba.set_num_threads(threads)
            twists = apply(fluid, positions, wrenches)
            results.append((twists, product(fluid, positions, wrenches, poses, changes)))
    finally:
        numba.set_num_threads(before)
    np.testing.assert_array_equal(results[0], results[1])


def test_a_position_that_is_no_number_is_felt_by_all():
    rng = np.random.default_rng(9)
    positions, wrenches = crooked_chain(rng, 40, 1.0)[0], rng.normal(size=(40, 6))
    positions[17, 1] = np.nan
    assert np.isnan(apply(PairFriction(40, 39, 1.0, 1.0), positions, wrenches)).all()


def test_memory_grows_with_the_number_of_spheres_alone():
    count = 3000
    positions = np.arange(3.0 * count).reshape(-1, 3)
    tracemalloc.start()
    try:
        fluid = PairFriction(count, count - 1, 1.0, 1.0)
        twists = apply(fluid, positions, np.ones((count, 6)))
        fluid.add_product(twists, twists, twists.copy())
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 100 * 8 * count + 2**23


@pytest.mark.parametrize(("name", "tables"), [("sum_twists", 1), ("sum_changes", 2)])
def test_the_loop_over_pairs_reads_side_by_side(name, tables):
    """r, F and T of several spheres at once, and their changes."""
    lines = f"from nrchain.hydrodynamics.rotne_prager import {name} as function"
    assert reads_of_the_loop(lines, tables) == (9 * tables, 0)


def test_all_images_of_a_periodic_chain_whose_forces_cancel():
    """Against plain sums over whole images on both sides, extrapolated in their number."""
    count, period = 3, 9.0
    rng = np.random.default_rng(4)
    positions = rng.normal(scale=0.3, size=(count, 3))
    positions[:, 0] += 3.0 * np.arange(count)
    wrenches = rng.normal(size=(count, 6))
    wrenches[:, :3] -= wrenches[:, :3].mean(axis=0)

    def images(number):
        shifts = period * np.arange(-number, number + 1)
        every = np.concatenate([positions + np.array([s, 0, 0]) for s in shifts])
        total = np.zeros((len(every), 6))
        fluid = PairFriction(len(every), None, 1.0, 1.0)
        fluid.apply(every, np.tile(wrenches, (len(shifts), 1)), total)
        return total[number * count : (number + 1) * count]

    whole = np.zeros((count, 6))
    PairFriction(count, None, 1.0, 1.0, period).apply(positions, wrenches, whole)
    # what is left out on one side cancels to leading order with the other: 1/P² in place of 1/P
    near, far = images(100), images(200)
    errors = np.abs(near - whole).max(), np.abs(far - whole).max()
    assert errors[1] < 1e-4 * np.abs(whole).max()
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert np.abs((4 * far - near) / 3 - whole).max() < 0.02 * errors[1]
