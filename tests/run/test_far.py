"""A chain that swims far keeps the accuracy of its links; a step to a half turn is dropped."""

import numpy as np
import pytest

import nrchain
from nrchain.motion.integrators import INTEGRATORS
from nrchain.outcome import Cause
from nrchain.planning.checked_start import starting_poses


def test_a_chain_that_swims_ten_million_lengths_takes_no_more_steps():
    scene = nrchain.load_scene(
        {
            "chain": {"particles": 4},
            "elasticity": {"stretch": 20.0, "shear": 20.0},
            "slip": {"3t": 1e4},
            "start": {"shape": "random"},
            "run": {"end": 1e8, "snapshots": 3},
        }
    )
    run = nrchain.simulate(scene)
    assert run.status == "completed"
    assert run.counters["steps"] < 2000
    assert np.abs(run.positions[-1]).max() > 1e8


@pytest.mark.parametrize("far", [1e10, 1e12])
def test_a_clamped_chain_may_be_anywhere(far):
    """Its links are known by differences: 1e12 away a coordinate is rounded to 1e-4."""
    keys = {"run.end": 50.0, "run.max_steps": 1000, "run.integrator": "cvode"}
    scene = nrchain.load_scene("buckling", **keys)
    positions, frames = starting_poses(scene)
    shift = np.array([far, 0.0, 0.0])
    near = nrchain.simulate(scene)
    there = nrchain.simulate(scene, positions=positions + shift, frames=frames)
    assert there.status == "completed"
    assert there.counters["steps"] == near.counters["steps"]
    np.testing.assert_array_equal(there.positions[..., 1:], near.positions[..., 1:])
    np.testing.assert_array_equal(there.positions[-1, [0, -1]], positions[[0, -1]] + shift)


@pytest.mark.parametrize("far", [1e10, 1e12])
def test_charts_that_every_step_renews_lose_no_more_than_the_tolerance_far_away(far):
    keys = {"run.end": 50.0, "run.max_steps": 1000, "run.integrator": "radau"}
    scene = nrchain.load_scene("buckling", **keys)
    positions, frames = starting_poses(scene)
    near = nrchain.simulate(scene)
    there = nrchain.simulate(scene, positions=positions + far * np.eye(3)[0], frames=frames)
    assert there.status == "completed"
    off = np.abs(there.positions - near.positions)[..., 1:]
    assert off.max() < 10.0 * scene.run.atol


def test_nothing_of_a_step_to_the_half_turn_is_kept(monkeypatch):
    monkeypatch.setitem(INTEGRATORS, "cvode", "validation.hard_cases.charts:Leap")
    for end in (100.0, 4e-2):
        changes = {"chain.ends": "free", "run.snapshots": 1001, "run.end": end}
        changes["run.integrator"] = "cvode"
        run = nrchain.simulate(nrchain.load_scene("passive", **changes))
        assert run.cause is Cause.CHART
        assert np.abs(run.frames - run.frames[0]).max() < 1e-9
