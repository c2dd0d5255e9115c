"""A run with a later end is the run that had that end from the first."""

import h5py
import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneError, TrajectoryError
from nrchain.planning.choice import Choice
from nrchain.run import loop
from nrchain.run.later_end import later_scene


def scene(name="wave", **changes):
    short = {"chain.particles": 6, "run.end": 400.0, "run.snapshots": 21}
    return nrchain.load_scene(name, **short | changes)


def whole(first, end, snapshots):
    """The run with the later end at once."""
    return nrchain.simulate(
        nrchain.load_scene(first, **{"run.end": end, "run.snapshots": snapshots})
    )


def assert_same(extended, other):
    assert extended.status == other.status == "completed"
    for name in ("time", "positions", "frames"):
        assert np.array_equal(getattr(extended, name), getattr(other, name)), name
    for count in ("steps", "evaluations", "restarts"):
        assert extended.counters[count] == other.counters[count]


@pytest.mark.parametrize(("integrator", "restart"), [("radau", 5), ("scipy-bdf", 30)])
def test_a_complete_run_goes_on_bit_for_bit(tmp_path, monkeypatch, integrator, restart):
    monkeypatch.setattr(loop, "RESTART_STEPS", restart)
    first = scene(**{"run.integrator": integrator, "run.end": 10.0, "run.snapshots": 3})
    done = nrchain.simulate(first, output=tmp_path)
    assert done.counters["restarts"] > 0
    extended = nrchain.resume(tmp_path, until=50.0)
    assert_same(extended, whole(first, 50.0, 11))
    assert np.array_equal(extended.positions[:3], done.positions)
    assert extended.counters["restarts"] > done.counters["restarts"]


def test_times_that_differ_in_their_last_bit_have_poses_that_do_too(tmp_path, monkeypatch):
    """3 · 0.1 and 0.3 are not the same number: the grids of the two ends are not either."""
    monkeypatch.setattr(loop, "RESTART_STEPS", 5)
    first = scene(**{"run.end": 33.3, "run.snapshots": 10})
    nrchain.simulate(first, output=tmp_path)
    extended, other = nrchain.resume(tmp_path, until=59.2), whole(first, 59.2, 17)
    assert not np.array_equal(extended.time, other.time)
    assert (np.diff(extended.time) > 0.0).all()
    assert extended.time == pytest.approx(other.time, rel=1e-14)
    assert abs(extended.positions - other.positions).max() < 1e-11
    assert extended.counters["steps"] == other.counters["steps"]


def test_cvode_goes_on_within_its_tolerance(tmp_path, monkeypatch):
    """Its first step after a restart depends on the end."""
    monkeypatch.setattr(loop, "RESTART_STEPS", 100)
    first = scene(**{"run.integrator": "cvode"})
    nrchain.simulate(first, output=tmp_path)
    extended, other = nrchain.resume(tmp_path, until=700.0), whole(first, 700.0, 36)
    assert np.array_equal(extended.time, other.time)
    assert abs(extended.positions - other.positions).max() < 10 * first.run.rtol
    assert abs(extended.frames - other.frames).max() < 10 * first.run.rtol


def test_a_run_that_spent_its_budget_is_extended_and_resumed(tmp_path):
    budget = scene(**{"run.max_steps": 40})
    assert nrchain.simulate(budget, output=tmp_path).cause is nrchain.Cause.BUDGET
    extended = nrchain.resume(tmp_path, until=500.0)
    while extended.status == "stopped":
        assert extended.cause is nrchain.Cause.BUDGET
        assert extended.scene.run.end == 500.0
        extended = nrchain.resume(tmp_path)
    assert_same(extended, whole(scene(), 500.0, 26))


def test_the_file_records_both_ends(tmp_path):
    first = nrchain.simulate(scene(), output=tmp_path)
    nrchain.resume(tmp_path, until=420.0)
    nrchain.resume(tmp_path, until=440.0)
    again = nrchain.Trajectory.open(tmp_path)
    assert (again.scene.run.end, again.scene.run.snapshots) == (440.0, 23)
    steps = [(step.how, step.time, step.frame) for step in again.provenance.steps]
    assert steps == [("extended", 400.0, 20), ("extended", 420.0, 21)]
    assert again.provenance.line == "extended from t = 420; 1 earlier step"
    assert nrchain.load_scene(again.scene, run=first.scene.run) == first.scene
    assert sorted(one.name for one in tmp_path.iterdir()) == ["trajectory.h5"]
    with h5py.File(again.path) as file:
        assert len(file["nrchain/times"]) == 23


def test_estimated_errors_are_kept(tmp_path):
    first = scene(**{"run.verify": True, "run.end": 40.0, "run.snapshots": 3})
    done = nrchain.simulate(first, output=tmp_path)
    extended = nrchain.resume(tmp_path, until=60.0)
    assert np.array_equal(extended.position_error[:3], done.position_error)
    assert np.isfinite(extended.position_error).all()
    assert_same(extended, whole(first, 60.0, 4))


@pytest.mark.parametrize(
    ("until", "match"),
    [
        (400.0, r"until = 400\.0: must be later than run\.end = 400"),
        (0.5, "must be later"),
        (float("nan"), "until = nan: must be a finite number"),
        ("far", "must be a finite number"),
        (410.0, "snapshots are 20 apart, and it must be a multiple of that: 420"),
        (430.0, "a multiple of that: 420 or 440"),
    ],
)
def test_ends_that_are_not_later_or_between_snapshots_are_refused(tmp_path, until, match):
    nrchain.simulate(scene(), output=tmp_path)
    before = (tmp_path / "trajectory.h5").read_bytes()
    with pytest.raises(SceneError, match=match):
        nrchain.resume(tmp_path, until=until)
    assert (tmp_path / "trajectory.h5").read_bytes() == before


def test_an_end_that_rounding_puts_beside_a_snapshot_is_taken():
    tenth = nrchain.load_scene("passive", **{"run.end": 0.3, "run.snapshots": 4})
    assert later_scene(tenth, 0.7).run.snapshots == 8


def test_a_settled_run_is_refused(tmp_path):
    calm = nrchain.load_scene("passive", **{"chain.particles": 4, "run.until": "settled"})
    done = nrchain.simulate(calm, output=tmp_path)
    assert done.reason
    with pytest.raises(TrajectoryError, match=r"settled.*run\.until = 'end'.*--from"):
        nrchain.resume(tmp_path, until=10 * calm.run.end)


def test_a_failure_leaves_the_file_as_it_was(tmp_path, monkeypatch):
    from nrchain.trajectory import extension

    nrchain.simulate(scene(), output=tmp_path)
    before = (tmp_path / "trajectory.h5").read_bytes()

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(extension, "_copy", fail)
    with pytest.raises(TrajectoryError, match="No space left on device"):
        nrchain.resume(tmp_path, until=500.0)
    assert (tmp_path / "trajectory.h5").read_bytes() == before
    assert [one.name for one in tmp_path.iterdir()] == ["trajectory.h5"]


AUTO = {
    "slip.2s": 10.0,
    "effects": "auto",
    "tolerance": 0.5,
    "start.shape": "sine",
    "run.end": 20.0,
    "run.snapshots": 5,
}


def test_chosen_effects_are_chosen_again_for_the_later_end(tmp_path):
    chosen = nrchain.load_scene("passive", **{"chain.particles": 6}, **AUTO)
    done = nrchain.simulate(chosen, output=tmp_path)
    assert done.choice.end == 20.0
    extended = nrchain.resume(tmp_path, until=30.0)
    assert extended.choice.end == 30.0
    assert extended.choice.left_out == done.choice.left_out


def test_a_later_end_that_needs_other_effects_is_refused_with_their_keys(tmp_path, monkeypatch):
    from nrchain.planning import auto

    named = nrchain.load_scene(
        "passive", **{"chain.particles": 6, "slip.2s": 10.0, "run.end": 20.0}
    )
    left_out = Choice(
        0.5, ("slip of all pairs",), 0.1, 20.0, (0.0,), (1.0,), "saves work", end=20.0
    )
    nrchain.simulate(named, output=tmp_path, choice=left_out)

    def wants_all(scene, choice):
        return nrchain.load_scene(scene, **{"slip.neighbours": "all"}), choice

    monkeypatch.setattr(auto, "choose_again", wants_all)
    with pytest.raises(TrajectoryError, match=r"to t = 40.*takes slip\.neighbours = 'all'"):
        nrchain.resume(tmp_path, until=40.0)
    assert nrchain.Trajectory.open(tmp_path).scene == named
    unwatched = nrchain.resume(tmp_path, until=40.0, unwatched=True)
    assert unwatched.status == "completed"
    assert unwatched.choice.watched_until == 20.0
