"""Adaptive sampling: points gather where the target changes, and follow from it alone."""

import numpy as np
import pytest

import nrchain

pytest.importorskip("adaptive")

SCENE = nrchain.load_scene("buckling", **{"chain.particles": 4, "run.end": 0.1, "run.snapshots": 2})


def strength(run):
    return run.scene.slip.modes["2s"].strength


def places(found, *keys):
    return np.array([[point.values[key] for key in keys] for point in found.points])


def test_a_boundary_in_one_key_is_bisected():
    def side(run):
        return "left" if strength(run) < 33.0 else "right"

    found = nrchain.sweep(
        SCENE, adaptive={"slip.2s": (0.0, 100.0)}, samples=20, batch=4, observe={"side": side}
    )
    x = places(found, "slip.2s")[:, 0]
    assert len(x) == 20
    across = np.flatnonzero(x < 33.0).max()
    # even spacing would leave 5
    assert x[across + 1] - x[across] < 0.8


def test_a_boundary_in_two_keys_is_followed():
    def side(run):
        twist = run.scene.slip.modes["3t"].strength
        return "in" if np.hypot(strength(run), twist) < 60.0 else "out"

    ranges = {"slip.2s": (0.0, 100.0), "slip.3t": (0.0, 100.0)}
    found = nrchain.sweep(SCENE, adaptive=ranges, samples=60, observe={"side": side})
    radius = np.hypot(*places(found, "slip.2s", "slip.3t").T)
    near = np.abs(radius - 60.0) < 10.0
    # a ring of that width has a fifth of the area
    assert near.mean() > 0.4


def test_numbers_are_followed_where_they_rise_and_failures_do_not_stop_it():
    def step(run):
        x = strength(run)
        if 80.0 < x < 90.0:
            raise ValueError("no value here")
        return np.tanh((x - 20.0) / 2.0)

    options = {"adaptive": {"slip.2s": (0.0, 100.0)}, "samples": 30, "observe": {"step": step}}
    missing = "no value of step at .* most often: ValueError: no value here"
    with pytest.warns(nrchain.SceneWarning, match=missing):
        found = nrchain.sweep(SCENE, **options, workers=1)
    x = places(found, "slip.2s")[:, 0]
    assert (np.abs(x - 20.0) < 10.0).mean() > 0.4
    with pytest.warns(nrchain.SceneWarning, match=missing):
        assert nrchain.sweep(SCENE, **options, workers=3) == found


def test_a_folder_goes_on_where_it_was_left(tmp_path):
    options = {"adaptive": {"slip.2s": (0.0, 100.0)}, "observe": "end.size"}
    nrchain.sweep(SCENE, **options, samples=9, output=tmp_path)
    more = nrchain.sweep(SCENE, **options, samples=18, output=tmp_path)
    assert more == nrchain.sweep(SCENE, **options, samples=18)
