"""run.until = "settled": a run ends when its chain has settled, and not before."""

import re

import numpy as np
import pytest

import nrchain
from nrchain import measure


def scene(**changes):
    few = {"chain.particles": 8, "slip.neighbours": 1, "elasticity.ratio": 1e7}
    start = {"elasticity.measure": "isotropic", "start.amplitude": 0.5, "run.until": "settled"}
    return nrchain.load_scene("buckling", **few | start | changes)


PUSHERS = scene(**{"slip.2s": 700.0, "run.end": 200.0})


def to_the_end(given):
    return nrchain.simulate(nrchain.load_scene(given, **{"run.until": "end"}))


def test_a_run_ends_where_all_spheres_are_near_the_state_they_end_in():
    run, whole = nrchain.simulate(PUSHERS), to_the_end(PUSHERS)
    count = len(run.time)
    assert run.status == "completed"
    assert f"at t = {run.time[-1]:g}: settled in a steady state" in run.reason
    assert np.array_equal(run.positions, whole.positions[:count])
    assert np.array_equal(run.frames, whole.frames[:count])
    away = np.linalg.norm(whole.positions - whole.positions[-1], axis=2).max(axis=1)
    assert away[count - 1] <= 1e-3 < away[count - 2]
    assert measure.attractor(run).since == run.time[-1]


@pytest.mark.filterwarnings("ignore:the bend")
def test_a_straight_chain_that_is_about_to_buckle_has_not_settled():
    """It stays within 1e-4 a of the straight state for most of the run."""
    slow = scene(**{"slip.2s": 450.0, "start.amplitude": 1e-6, "run.atol": 1e-10, "run.end": 600.0})
    run = nrchain.simulate(slow)
    bend = np.abs(run.positions[..., 1:]).max(axis=(1, 2))
    assert (bend < 1e-4).sum() > 5
    assert bend[-1] > 1.0
    assert measure.attractor(run).kind == "buckled"


def test_a_chain_that_swims_and_spins_without_a_bend_has_settled():
    moving = {"chain.ends": "free", "slip.2s": 0.0, "slip.3t": 6000.0, "slip.4a": 4000.0}
    run = nrchain.simulate(scene(**moving, **{"run.end": 300.0}))
    assert "settled in a steady state" in run.reason
    assert measure.attractor(run).kind in ("swimming", "spinning")


FLUTTER = {
    "chain.particles": 10,
    "slip.2s": 600.0,
    "slip.3t": 6000.0,
    "elasticity.measure": "paper",
}


def test_a_wave_settles_when_its_amplitude_no_longer_changes():
    waving = scene(**FLUTTER, **{"run.end": 600.0, "run.snapshots": 601})
    run, whole = nrchain.simulate(waving), to_the_end(waving)
    assert "settled in a cycle" in run.reason
    period = measure.attractor(whole, further=False).period
    assert float(re.search("period ([0-9.]+)", run.reason)[1]) == pytest.approx(period, rel=1e-3)

    def height(begin, end):
        late = (whole.time > begin) & (whole.time <= end)
        return np.linalg.norm(whole.positions[late, :, 1:], axis=(1, 2)).max()

    end = run.time[-1]
    assert height(end - period, end) == pytest.approx(height(600.0 - period, 600.0), rel=5e-3)
    assert end < 600.0


def test_a_plane_wave_that_small_changes_leave_has_not_settled():
    plane = {"start.shape": "sine", "run.end": 600.0, "run.snapshots": 601}
    run = nrchain.simulate(scene(**FLUTTER, **plane))
    assert np.abs(run.positions[..., 2]).max() < 1e-6
    assert "unstable" in measure.attractor(run).confidence
    assert (run.reason, run.time[-1]) == ("", 600.0)
