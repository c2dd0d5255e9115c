"""All near pairs, by either search."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrchain.geometry import near_pairs as module
from nrchain.geometry.near_pairs import near_pairs, separations


def plainly(positions, cutoff, period):
    pairs = []
    for i in range(len(positions)):
        for j in range(i + 1, len(positions)):
            x = positions[i] - positions[j]
            if period:
                x[0] -= period * np.round(x[0] / period)
            if np.linalg.norm(x) < cutoff:
                pairs.append((i, j))
    return np.array(pairs, int).reshape(-1, 2)


@settings(deadline=None)
@given(
    count=st.integers(2, 40),
    seed=st.integers(0, 10**6),
    cutoff=st.floats(0.1, 4.9),
    period=st.sampled_from([0.0, 10.0]),
    search=st.sampled_from([0, 1024]),
)
def test_every_pair_below_the_cutoff_and_no_other(count, seed, cutoff, period, search):
    positions = np.random.default_rng(seed).uniform(-20, 20, (count, 3))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "DIRECT_SEARCH", search)
        pairs = near_pairs(positions, cutoff, period)
    assert np.array_equal(pairs, plainly(positions, cutoff, period))
    assert (np.linalg.norm(separations(positions, pairs, period), axis=1) < cutoff).all()


def test_more_pairs_than_expected_are_all_listed():
    crowd = np.random.default_rng(0).uniform(0, 1, (30, 3))
    assert len(near_pairs(crowd, 10.0)) == 30 * 29 / 2
