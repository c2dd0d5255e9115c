"""Frames of a film: as many as asked for, all different, spaced as asked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrchain.errors import SceneError
from nrchain.view.film_times import MOST_FRAMES, pick_frames


@given(
    count=st.integers(1, 60),
    share=st.floats(0, 1),
    scale=st.sampled_from(["linear", "logarithmic"]),
    seed=st.integers(0, 1000),
)
def test_frames_are_different_snapshots_in_order(count, share, scale, seed):
    steps = np.random.default_rng(seed).uniform(1e-6, 1.0, count)
    frames = 1 + int(share * (count - 1))
    chosen = pick_frames(np.cumsum(steps) - steps[0], frames, scale)
    assert len(chosen) == frames
    assert np.all(np.diff(chosen) > 0)
    assert chosen[-1] == count - 1
    assert chosen[0] == (0 if frames > 1 else count - 1)


def test_logarithmic_times_have_equal_ratios_where_snapshots_are_dense():
    times = np.linspace(0.0, 1000.0, 100_001)
    chosen = times[pick_frames(times, 30, "logarithmic")][15:]
    ratios = chosen[1:] / chosen[:-1]
    assert ratios == pytest.approx(ratios[-1], rel=1e-2)


def test_frames_are_one_a_snapshot_and_not_too_many():
    assert list(pick_frames(np.arange(5.0), None, "linear")) == [0, 1, 2, 3, 4]
    assert len(pick_frames(np.arange(5000.0), None, "linear")) == MOST_FRAMES


@pytest.mark.parametrize(
    ("frames", "scale", "message"),
    [
        (6, "linear", r"times = 6: there are 5 snapshots, .*larger run.snapshots"),
        (0, "linear", "times = 0: must be a whole number of at least 1"),
        (2, "square", "spacing = 'square': must be one of linear, logarithmic"),
    ],
)
def test_frames_that_do_not_exist_are_refused(frames, scale, message):
    with pytest.raises(SceneError, match=message):
        pick_frames(np.arange(5.0), frames, scale)
