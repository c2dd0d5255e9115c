"""A start below the tolerance never grows into noise, and a straight one warns."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.command_line import call

import nrchain
from nrchain.planning.checked_start import starting_poses
from nrchain.planning.regime import warnings
from nrchain.planning.shared_steps import SharedStepRun
from nrchain.scene.poses import initial_poses
from nrchain.watch.seed import bend_growth_exponent, seed_amplitude
from validation.report.gallery import GALLERY


def buckling(**changes):
    return nrchain.load_scene("buckling", **{"run.snapshots": 3} | changes)


def largest_offset(trajectory):
    return float(np.abs(trajectory.positions[-1, :, 1:]).max())


def test_an_unresolved_seed_is_refused_and_the_tolerance_named_resolves_its_growth():
    """Small offsets obey linear equations: a start a thousand times as high ends as high."""
    small = buckling(**{"start.amplitude": 1e-9})
    with pytest.raises(nrchain.SceneError, match=r"run.atol.*at most") as refused:
        nrchain.simulate(small)
    assert refused.value.key == "run.atol"
    named = float(re.search(r"at most (\S+):", refused.value.allowed)[1])
    # a thousandth of the start, to one digit
    assert named == pytest.approx(1e-3 * seed_amplitude(small, *initial_poses(small)), rel=0.5)
    found = nrchain.simulate(nrchain.load_scene(small, **{"run.atol": named}))
    large = nrchain.simulate(buckling(**{"start.amplitude": 1e-6, "run.atol": 1e-11}))
    assert largest_offset(found) > 300 * 1e-9
    assert largest_offset(found) == pytest.approx(1e-3 * largest_offset(large), rel=0.01)


@pytest.mark.parametrize(
    "changes",
    [{"run.end": 100.0, "start.amplitude": 1e-12}, {"slip.2s": -100.0, "start.amplitude": 1e-9}],
)
def test_a_seed_that_stays_below_the_tolerance_runs(changes):
    assert warnings(buckling(**changes)) == []
    assert nrchain.simulate(buckling(**changes)).status == "completed"


def test_the_smallest_start_of_the_gallery_is_refused_only_where_it_grows_beyond_the_tolerance():
    (case,) = [case for case in GALLERY if case.name == "amplitude 1e-12 a"]
    assert nrchain.simulate(case.scene()).status == "completed"
    with pytest.raises(nrchain.SceneError, match="bends grow"):
        nrchain.simulate(case.scene(**{"run.end": 5000.0}))


def test_a_straight_start_of_a_chain_that_buckles_warns():
    straight = buckling(**{"start.shape": "straight"})
    with pytest.warns(nrchain.SceneWarning, match=r"straight.*grow by up to e\^7"):
        nrchain.simulate(straight)
    assert any("start.shape" in text for text in warnings(straight))
    assert warnings(nrchain.load_scene(straight, **{"slip.2s": -100.0})) == []


@pytest.mark.parametrize("times", [9.0, 11.0])
def test_a_straight_chain_warns_if_bends_grow_tenfold(times):
    straight = buckling(**{"start.shape": "straight"})
    end = straight.run.end * np.log(times) / bend_growth_exponent(straight)
    warned = warnings(nrchain.load_scene(straight, **{"run.end": float(end)}))
    assert any("straight to rounding" in text for text in warned) == (times > 10.0)


def test_a_seed_barely_above_the_tolerance_warns():
    (warned,) = warnings(buckling(**{"start.amplitude": 1e-6}))
    named = float(re.search(r"run\.atol = (\S+) resolves it", warned)[1])
    assert warnings(buckling(**{"start.amplitude": 1e-6, "run.atol": named})) == []


@pytest.mark.parametrize("far", [0.0, 7.0, 1e5])
def test_the_seed_is_that_of_the_chain_however_it_lies(far):
    scene = buckling(**{"start.amplitude": 1e-3, "chain.ends": "free"})
    positions, frames = starting_poses(scene)
    turn = Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()
    own = seed_amplitude(scene, positions, frames)
    assert 1e-3 < own < 5e-3
    moved = seed_amplitude(scene, positions @ turn.T + far, frames @ turn.T)
    assert moved == pytest.approx(own, rel=1e-6)
    straight, still = starting_poses(buckling(**{"start.shape": "straight"}))
    assert seed_amplitude(scene, straight @ turn.T + far, still @ turn.T) == 0.0


def test_growth_that_cannot_be_judged_refuses_nothing():
    tilted = {"slip.4a": 100.0, "slip.4a.axis": [1.0, 1.0, 0.0]}
    assert bend_growth_exponent(nrchain.load_scene("passive", **tilted)) == 0.0


def test_probes_resolve_a_seed_below_their_own_tolerance():
    """At the probe's 3e-5 nothing of a start of 1e-6 would be seen to grow."""
    scene = buckling(**{"start.amplitude": 1e-6, "run.atol": 1e-9})
    probe = SharedStepRun([scene], starting_poses(scene), 3e-5)
    list(probe.advance([1000.0]))
    run = nrchain.simulate(scene)
    offset = float(np.abs(probe.poses[0][0][:, 1:]).max())
    assert offset == pytest.approx(largest_offset(run), rel=0.1)


def test_the_command_warns_once(tmp_path):
    changes = ("--set", "start.shape=straight", "--set", "run.snapshots=2")
    warned = call("run", "buckling", "-o", tmp_path, *changes)
    assert warned.exit_code == 0
    assert (warned.stdout + warned.stderr).count("the start is straight") == 1
