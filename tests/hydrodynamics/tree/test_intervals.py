"""Intervals of the index: every pair of spheres is in one pair of intervals, far ones are far."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.long_chains import SHAPES, long_chain

from nrchain.hydrodynamics.tree.intervals import (
    GROUP,
    fill_balls,
    interval_bounds,
    interval_lists,
)

RATIOS = np.array([0.0, 0.0, 0.2, 0.4])


def lists_of(positions, leaf, ratios=RATIOS, gap=2.0):
    bounds = interval_bounds(len(positions), leaf)
    balls = np.zeros((len(bounds), 4))
    fill_balls(np.ascontiguousarray(positions.T), bounds, balls)
    return bounds, balls, interval_lists(bounds, balls, ratios, gap)


def visits(positions, leaf):
    """(N, N): how often each sphere feels each."""
    bounds, _, lists = lists_of(positions, leaf)
    count = np.zeros((len(positions),) * 2, int)
    for target, source, _ in lists.far:
        count[slice(*bounds[target]), slice(*bounds[source])] += 1
    for target in range(len(bounds)):
        for first, last in lists.near[lists.near_begin[target] : lists.near_begin[target + 1]]:
            count[slice(*bounds[target]), first:last] += 1
    return count


@given(
    shape=st.sampled_from(sorted(SHAPES)),
    count=st.integers(1, 300),
    leaf=st.integers(1, 40),
    seed=st.integers(0, 1000),
)
@settings(max_examples=40, deadline=None)
def test_every_pair_is_summed_once(shape, count, leaf, seed):
    rng = np.random.default_rng(seed)
    positions = SHAPES[shape](rng, count, 10.0)
    assert (visits(positions, leaf) == 1).all()


def test_leaves_are_full_by_half_and_follow_the_chain():
    for count, leaf in ((1, 4), (4, 4), (5, 4), (1000, 32), (1023, 1)):
        bounds = interval_bounds(count, leaf)
        leaves = bounds[len(bounds) // 2 :]
        assert leaves[0, 0] == 0
        assert leaves[-1, 1] == count
        np.testing.assert_array_equal(leaves[1:, 0], leaves[:-1, 1])
        sizes = np.diff(leaves, axis=1)
        assert sizes.max() <= leaf
        assert len(leaves) == 1 or 2 * sizes.max() >= leaf // 2


def test_balls_hold_their_spheres():
    positions, _ = long_chain("walk", 200)
    bounds, balls, _ = lists_of(positions, 16)
    for (first, last), (*centre, radius) in zip(bounds[1:], balls[1:], strict=True):
        distances = np.linalg.norm(positions[first:last] - centre, axis=1)
        assert distances.max() == pytest.approx(radius, rel=1e-14, abs=1e-12)


def test_far_intervals_are_apart_by_the_ratio_of_their_degree():
    positions, _ = long_chain("walk", 600)
    ratios = np.array([0.0, 0.0, 0.33, 0.4])
    _, balls, lists = lists_of(positions, 16, ratios)
    i, j, degree = lists.far.T
    distance = np.linalg.norm(balls[i, :3] - balls[j, :3], axis=1)
    ratio = (balls[i, 3] + balls[j, 3]) / distance
    assert (ratio < ratios[degree]).all()
    assert (ratio >= ratios[degree - 1]).all()
    assert set(degree) == {2, 3}


def test_groups_hold_their_targets_by_degree():
    positions, _ = long_chain("walk", 600)
    _, _, lists = lists_of(positions, 16)
    for group, (first, last) in enumerate(
        zip(lists.far_begin[:-1], lists.far_begin[1:], strict=True)
    ):
        assert (lists.far[first:last, 0] // GROUP == group).all()
        assert (np.diff(lists.far[first:last, 2]) >= 0).all()
    assert lists.far_begin[-1] == len(lists.far)


def test_spheres_that_overlap_are_never_far():
    """A chain of coincident spheres has balls of no size."""
    positions = np.zeros((100, 3))
    positions[50:, 0] = 1.9
    _, _, lists = lists_of(positions, 10)
    assert not len(lists.far)


def test_a_sphere_nowhere_is_near_all():
    positions, _ = long_chain("straight", 200)
    positions[120, 1] = np.nan
    bounds, _, lists = lists_of(positions, 8)
    felt = [slice(*bounds[s]) for _, s, _ in lists.far]
    assert not any(s.start <= 120 < s.stop for s in felt)
