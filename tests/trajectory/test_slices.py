"""A trajectory is a sequence of snapshots; a slice of it is a trajectory."""

from __future__ import annotations

import copy
import pickle
import random

import numpy as np
import pytest

from nrchain.analysis import measure
from nrchain.outcome import Cause
from nrchain.run.simulation import simulate
from nrchain.scene.loading import load_scene
from nrchain.trajectory.block import Block
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.trajectory.trajectory import Snapshot, Trajectory
from nrchain.trajectory.writer import TrajectoryWriter

COUNT, PARTICLES = 7, 4
SCENE = load_scene({"chain.particles": PARTICLES, "run.end": 6.0, "run.snapshots": COUNT})
TIMES = np.arange(float(COUNT))


def poses(index):
    rng = np.random.default_rng(index)
    return rng.normal(size=(PARTICLES, 3)), rng.normal(size=(PARTICLES, 3, 3))


def checkpoint(snapshot):
    """A second one overwrites the first but one: the file holds two."""
    return Checkpoint(float(snapshot), *poses(snapshot), snapshot, 0.0, np.zeros(3), {"steps": 1})


@pytest.fixture
def whole():
    positions, frames = map(np.array, zip(*map(poses, range(COUNT)), strict=True))
    errors = np.linspace(0.0, 1e-6, COUNT)
    return Trajectory(
        TIMES, positions, frames, SCENE, {"steps": 3}, position_error=errors, frame_error=2 * errors
    )


@pytest.mark.parametrize("row", [0, 3, COUNT - 1, -1, -COUNT, np.int64(2)])
def test_an_item_is_the_snapshot_at_that_place_of_a_list(whole, row):
    snapshot = whole[row]
    assert snapshot.index == list(range(COUNT))[row]
    assert snapshot.time == list(TIMES)[row]
    assert type(snapshot.time) is float
    assert np.array_equal(snapshot.positions, poses(snapshot.index)[0])
    assert np.array_equal(snapshot.frames, poses(snapshot.index)[1])
    assert snapshot.position_error == whole.position_error[row]
    assert snapshot.frame_error == whole.frame_error[row]
    assert snapshot.scene is SCENE
    assert repr(snapshot) == f"<Snapshot {snapshot.index} at t = {snapshot.time:g}: 4 spheres>"


def test_slices_are_those_of_a_list_also_of_slices(whole):
    rng = random.Random(3)
    ends = [None, *range(-COUNT - 2, COUNT + 3)]
    for _ in range(200):
        first, second = (
            slice(rng.choice(ends), rng.choice(ends), rng.choice([None, -2, -1, 1, 2, 3]))
            for _ in range(2)
        )
        expected, part = list(range(COUNT))[first][second], whole[first][second]
        assert list(part.indices) == expected
        assert len(part) == len(expected)
        assert [one.index for one in part] == expected
        assert part.time.tolist() == [float(index) for index in expected]
        for one in part:
            assert np.array_equal(one.positions, poses(one.index)[0])
            assert np.array_equal(one.frames, poses(one.index)[1])


def test_a_slice_has_the_rest_of_its_run_and_copies_no_array(whole):
    part = whole[2:5]
    assert isinstance(part, Trajectory)
    assert (part.scene, part.counters, part.status) == (SCENE, whole.counters, "completed")
    for name in ("time", "positions", "frames", "position_error", "frame_error"):
        assert np.shares_memory(getattr(part, name), getattr(whole, name))
        assert np.array_equal(getattr(part, name), getattr(whole, name)[2:5])
    assert np.shares_memory(part[0].positions, whole.positions)


def test_loops_go_through_all_snapshots_either_way(whole):
    assert [one.index for one in whole] == list(range(COUNT))
    assert [one.index for one in reversed(whole)] == list(range(COUNT))[::-1]


@pytest.mark.parametrize("row", [COUNT, -COUNT - 1])
def test_a_snapshot_that_is_not_there_is_an_error_that_says_which_are(whole, row):
    with pytest.raises(IndexError, match=f"there is no snapshot {row}: 0 to 6, or -1 for the last"):
        whole[row]
    with pytest.raises(IndexError, match="there is no snapshot 0: none is finished"):
        whole[:0][0]


@pytest.mark.parametrize("which", ["0", 1.0, [0, 1], (0, 1), None])
def test_other_indices_are_refused(whole, which):
    with pytest.raises(TypeError):
        whole[which]


def test_a_trajectory_refuses_another_number_of_indices(whole):
    with pytest.raises(ValueError, match="indices: 2 of them, not 7"):
        Trajectory(whole.time, whole.positions, whole.frames, SCENE, indices=range(2))


def test_snapshots_and_slices_survive_pickle_and_copies(whole):
    for again in (pickle.loads(pickle.dumps(whole[3:])), copy.deepcopy(whole[3:])):
        assert again.indices == range(3, COUNT)
        assert np.array_equal(again.positions, whole.positions[3:])
    again = pickle.loads(pickle.dumps(whole[-1]))
    assert isinstance(again, Snapshot)
    assert (again.index, again.time) == (COUNT - 1, TIMES[-1])
    assert np.array_equal(again.frames, whole.frames[-1])


def test_measurements_take_slices():
    run = simulate(
        load_scene("buckling", **{"chain.particles": 5, "run.end": 1.0, "run.snapshots": 9})
    )
    straight = measure.straightness(run)
    assert np.array_equal(measure.straightness(run[3:8:2]), straight[3:8:2])
    assert run[-1].time == 1.0
    assert run[-1].position_error is None


def test_a_run_that_goes_on_has_the_snapshots_it_has_finished(tmp_path):
    path = tmp_path / "trajectory.h5"
    with TrajectoryWriter(path, SCENE, TIMES) as writer:
        assert len(Trajectory.open(path)) == 0
        assert list(Trajectory.open(path)) == []
        early = None
        for index in range(4):
            writer.write(index, Block.of_one(TIMES[index], *poses(index), step=index))
            writer.checkpoint(checkpoint(index + 1))
            now = Trajectory.open(path)
            assert (len(now), now[-1].index, now.status) == (index + 1, index, "running")
            assert np.array_equal(now[-1].positions, poses(index)[0])
            early = early or now
        # what was opened before does not change
        assert len(early) == 1
        assert now[-1].path == path
        writer.close("stopped", "for a test", Cause.TOUCH)
    ended = Trajectory.open(path)[1:]
    assert (ended.status, ended.cause, ended.indices) == ("stopped", Cause.TOUCH, range(1, 4))
    assert ended.latest_checkpoint().snapshot == 4
