"""Slip flows and friction of long chains by a tree, against direct sums over all pairs."""

from fractions import Fraction

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.long_chains import SHAPES, long_chain
from support.pair_reference import LABELS

from nrchain import slip_modes
from nrchain.hydrodynamics.disturbance import Disturbance
from nrchain.hydrodynamics.friction import PairFriction
from nrchain.hydrodynamics.pairs import SlipFlow
from nrchain.hydrodynamics.slip_mode import SlipMode
from nrchain.hydrodynamics.tree import accuracy

COUNT = 1500
E1 = (1.0, 0.0, 0.0)


@pytest.fixture(autouse=True)
def trees_of_short_chains(monkeypatch):
    """Trees from 1000 spheres on or fewer, so that direct sums take little time."""
    monkeypatch.setattr(accuracy, "FEWEST", 100)


def slip_of(labels, accuracy, *, count=COUNT, radius=1.0, axes=None, seed=3, finite_size=False):
    rng = np.random.default_rng(seed)
    strengths = [rng.normal(1.0, 0.5, size=count) for _ in labels]
    axes = axes or [E1] * len(labels)
    options = {"count": count, "reach": None, "radius": radius, "finite_size": finite_size}
    return SlipFlow(labels, strengths, axes, accuracy=accuracy, **options)


def friction_of(accuracy, *, count=COUNT, radius=1.0, viscosity=1.0):
    return PairFriction(count, None, radius, viscosity, accuracy=accuracy)


def twists_of(flow, positions, other):
    """``other`` are the frames of slip, or the wrenches of friction."""
    out = np.zeros((len(positions), 6))
    add = flow.apply if isinstance(flow, PairFriction) else flow.add_twists
    add(positions, other, out)
    return out


def product_of(flow, *changes):
    out = np.zeros((flow.count, 6))
    flow.add_product(*changes, out)
    return out


def error(found, exact):
    """Largest error of v over the largest |v|, or of ω over the largest |ω|."""
    parts = [part for part in (slice(3), slice(3, 6)) if exact[:, part].any()]
    return max(np.abs((found - exact)[:, p]).max() / np.abs(exact[:, p]).max() for p in parts)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("relative", [1e-3, 1e-5])
def test_slip_is_as_accurate_as_asked(shape, relative):
    positions, frames = long_chain(shape, COUNT, spacing=12.0)
    by_tree, direct = (slip_of(LABELS, a, radius=1.3) for a in (relative, 0.0))
    assert by_tree.tree
    assert not direct.tree
    exact = twists_of(direct, positions, frames)
    assert error(twists_of(by_tree, positions, frames), exact) < relative


@pytest.mark.slow
@pytest.mark.parametrize("label", LABELS)
def test_each_mode_is_as_accurate_as_asked(label):
    positions, frames = long_chain("walk", COUNT)
    for finite_size in (False, True):
        by_tree, direct = (slip_of([label], a, finite_size=finite_size) for a in (1e-6, 0.0))
        assert by_tree.tree
        exact = twists_of(direct, positions, frames)
        assert error(twists_of(by_tree, positions, frames), exact) < 1e-6


def test_modes_act_each_along_its_own_axis():
    positions, frames = long_chain("coil", COUNT, spacing=7.0)
    axes = [(0.0, 2.0, 0.0), (1.0, -3.0, 0.5), E1, (0.0, 1.0, 0.0)]
    options = {"axes": axes, "radius": 2.1, "finite_size": True}
    by_tree, direct = (slip_of(LABELS, a, **options) for a in (1e-5, 0.0))
    exact = twists_of(direct, positions, frames)
    assert error(twists_of(by_tree, positions, frames), exact) < 1e-5


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("relative", [1e-3, 1e-5])
def test_friction_is_as_accurate_as_asked(shape, relative):
    positions, _ = long_chain(shape, COUNT, spacing=3.0)
    wrenches = np.random.default_rng(4).normal([0.5, 0, 0, 0, 0, 0], 1.0, (COUNT, 6))
    by_tree, direct = (friction_of(a, radius=0.7, viscosity=2.3) for a in (relative, 0.0))
    assert by_tree.tree
    assert not direct.tree
    exact = twists_of(direct, positions, wrenches)
    assert error(twists_of(by_tree, positions, wrenches), exact) < relative


@pytest.mark.parametrize("shape", ["coil", "walk", "folded"])
def test_product_of_slip_is_as_accurate_as_asked(shape):
    positions, frames = long_chain(shape, COUNT)
    poses = np.random.default_rng(5).normal(size=(COUNT, 6))
    by_tree, direct = (slip_of(LABELS, a, radius=1.3, finite_size=True) for a in (1e-5, 0.0))
    found = []
    for flow in (by_tree, direct):
        twists_of(flow, positions, frames)
        found.append(product_of(flow, poses))
    assert error(*found) < 1e-5


@pytest.mark.parametrize("shape", ["coil", "walk", "folded"])
def test_product_of_friction_is_as_accurate_as_asked(shape):
    positions, _ = long_chain(shape, COUNT)
    wrenches, changes, poses = np.random.default_rng(6).normal(size=(3, COUNT, 6))
    found = []
    for fluid in (friction_of(a, radius=0.7, viscosity=2.3) for a in (1e-5, 0.0)):
        twists_of(fluid, positions, wrenches)
        found.append(product_of(fluid, poses, changes))
    assert error(*found) < 1e-5


def test_product_of_the_far_field_is_its_derivative():
    """With intervals held fixed the far field is smooth: central differences at one tree."""
    positions, _ = long_chain("walk", COUNT)
    fluid = friction_of(1e-3)
    wrenches, poses = np.random.default_rng(7).normal(size=(2, COUNT, 6))
    twists_of(fluid, positions, wrenches)
    found, field = np.zeros((COUNT, 6)), fluid.tree._field
    field.changes[:] = 0.0
    field.add_product(poses[:, :3].T, found)
    step, sides = 1e-4, []
    for sign in (1, -1):
        moved = (positions + sign * step * poses[:, :3]).T
        field._points[:] = moved
        out = np.zeros((COUNT, 6))
        field.add(out)
        sides.append(out)
    expected = (sides[0] - sides[1]) / (2 * step)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("part", ["stresslet", "finite size"])
@pytest.mark.parametrize("shape", ["coil", "walk", "folded"])
def test_the_disturbance_of_a_flow_is_as_accurate_as_asked(part, shape):
    """With its product, about positions that later evaluations elsewhere leave as they are."""
    rng = np.random.default_rng(12)
    positions, _ = long_chain(shape, COUNT, spacing=7.0)
    gradient, poses = rng.normal(size=(3, 3)), rng.normal(size=(COUNT, 6))
    gradient -= np.trace(gradient) / 3 * np.eye(3)
    found = []
    for relative in (1e-5, 0.0):
        options = {"count": COUNT, "radius": 1.6, "reach": None, "accuracy": relative}
        disturbance = Disturbance(part, gradient, **options)
        assert bool(disturbance.tree) == (relative > 0)
        twists, product = np.zeros((2, COUNT, 6))
        disturbance.linearise(positions)
        disturbance.add_twists(positions + 1.0, np.zeros((COUNT, 6)))
        disturbance.add_twists(positions, twists)
        disturbance.add_product(poses, product)
        found.append((twists, product))
    for tree, exact in zip(*found, strict=True):
        assert error(tree, exact) < 1e-5


def test_products_follow_the_last_poses():
    positions, frames = long_chain("walk", COUNT)
    poses = np.random.default_rng(8).normal(size=(COUNT, 6))
    flow, fresh = (slip_of(LABELS, 1e-3) for _ in range(2))
    twists_of(flow, positions, frames)
    product_of(flow, poses)
    moved = positions + 0.5 * np.sin(np.arange(COUNT))[:, None]
    for other in (flow, fresh):
        twists_of(other, moved, frames)
    np.testing.assert_array_equal(product_of(flow, poses), product_of(fresh, poses))


@given(seed=st.integers(0, 1000), spacing=st.floats(2.1, 30.0), exponent=st.integers(-9, 9))
@settings(max_examples=15, deadline=None)
def test_units_of_length_do_not_matter(seed, spacing, exponent):
    radius = 10.0**exponent
    positions, frames = long_chain("walk", COUNT, spacing=spacing, seed=seed)
    flows = [slip_of(LABELS, a, radius=radius, seed=seed) for a in (1e-4, 0.0)]
    assert error(*(twists_of(flow, radius * positions, frames) for flow in flows)) < 1e-4


def test_one_sphere_moves_the_last():
    """A single force at the other end of the chain."""
    positions, _ = long_chain("straight", COUNT)
    for relative in (1e-4, 0.0):
        wrenches = np.zeros((COUNT, 6))
        wrenches[0, 1] = 1.0
        twists = twists_of(friction_of(relative), positions, wrenches)
        distance = 10.0 * (COUNT - 1)
        expected = (1 + 2 / (3 * distance**2)) / (8 * np.pi * distance)
        assert twists[-1, 1] == pytest.approx(expected, rel=1e-3)
        assert twists[-1, 5] == pytest.approx(-1 / (8 * np.pi * distance**2), rel=1e-3)


@pytest.mark.slow
def test_results_do_not_depend_on_the_number_of_threads():
    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("one thread only")
    count = 2500
    positions, frames = long_chain("walk", count)
    wrenches, poses, changes = np.random.default_rng(9).normal(size=(3, count, 6))
    flow, fluid = slip_of(LABELS, 1e-4, count=count), friction_of(1e-4, count=count)
    assert flow.tree._field.parallel
    results = []
    before = numba.get_num_threads()
    try:
        for threads in (1, 2):
            numba.set_num_threads(threads)
            twists = twists_of(flow, positions, frames), twists_of(fluid, positions, wrenches)
            results.append((*twists, product_of(flow, poses), product_of(fluid, poses, changes)))
    finally:
        numba.set_num_threads(before)
    np.testing.assert_array_equal(results[0], results[1])


def test_a_position_that_is_no_number_is_felt_by_all():
    positions, frames = long_chain("coil", COUNT)
    positions[700, 2] = np.nan
    assert np.isnan(twists_of(slip_of(["2s"], 1e-3), positions, frames)).all()
    assert np.isnan(twists_of(friction_of(1e-3), positions, np.ones((COUNT, 6)))).all()


def test_spheres_at_one_place_move_as_one():
    positions = np.zeros((COUNT, 3))
    wrenches = np.random.default_rng(10).normal(size=(COUNT, 6))
    found, exact = (twists_of(friction_of(a), positions, wrenches) for a in (1e-3, 0.0))
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-13 * np.abs(exact).max())


def test_the_break_even_chooses():
    for relative in (1e-2, 1e-7):
        fewest = accuracy.break_even(relative)
        for count in (fewest - 1, fewest):
            assert bool(friction_of(relative, count=count).tree) == (count == fewest)
            assert bool(slip_of(["3t"], relative, count=count).tree) == (count == fewest)
    assert accuracy.break_even(0.0) == np.inf


def test_cut_and_periodic_sums_are_direct():
    many = 5000
    assert not PairFriction(many, many - 2, 1.0, 1.0, accuracy=1e-2).tree
    assert not PairFriction(many, 3, 1.0, 1.0, 5e4, accuracy=1e-2).tree
    assert not PairFriction(many, None, 1.0, 1.0, 5e4, accuracy=1e-2).tree
    assert PairFriction(many, many + 7, 1.0, 1.0, accuracy=1e-2).tree


def test_registered_modes_are_summed_by_the_tree(monkeypatch):
    """A rotlet, and a flow of a power that is too high for the tree and is summed directly."""
    monkeypatch.setattr(slip_modes, "_MODES", dict(slip_modes._MODES))
    slip_modes.register(SlipMode("1r", "rotlet", 1, True, True, {("x", 2): (1,)}))
    positions, frames = long_chain("walk", COUNT)
    found, exact = (twists_of(slip_of(["1r"], a), positions, frames) for a in (1e-4, 0.0))
    assert error(found, exact) < 1e-4
    assert slip_of(["1r"], 1e-4).tree
    # P₇′(c) s⁸ e × n
    seventh = tuple(Fraction(q, 16) for q in (-35, 0, 945, 0, -3465, 0, 3003))
    slip_modes.register(SlipMode("8x", "a high power", 8, True, True, {("x", 8): seventh}))
    assert not slip_of(["8x"], 1e-4).tree


def test_direct_sums_at_some_spheres_are_those_of_all():
    positions, frames = long_chain("coil", 60)
    wrenches = np.random.default_rng(11).normal(size=(60, 6))
    for flow, other in (
        (slip_of(LABELS, 0.0, count=60), frames),
        (friction_of(0.0, count=60), wrenches),
    ):
        exact = twists_of(flow, positions, other)
        np.testing.assert_array_equal(flow.direct_twists([0, 7, 59]), exact[[0, 7, 59]])
