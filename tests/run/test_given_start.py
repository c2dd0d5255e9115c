"""A run from given poses records them, and its file alone repeats the run."""

import copy
import pickle

import h5py
import numpy as np
import pytest
from support.poses import random_chain
from support.selection import few_of
from typer.testing import CliRunner

import nrchain
from nrchain.cli.app import app
from nrchain.errors import SceneError
from nrchain.inputs.arrays import GivenArray
from nrchain.planning.checked_start import starting_poses
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.trajectory.file import FILE_NAME

COUNT, SPACING = 6, 7.0


def make_scene(ends="free", **changes):
    chain = {"particles": COUNT, "spacing": SPACING, "radius": 1.5, "viscosity": 0.7, "ends": ends}
    table = {"chain": chain, "start.shape": "random", "slip.2s": 5.0, "slip.4a": 20.0}
    return load_scene(table | {"run.end": 20.0, "run.snapshots": 5}, **changes)


def chain_of(seed=3):
    return random_chain(COUNT, spacing=SPACING, bend=0.2, noise=0.3, seed=seed)


def same_run(one, other):
    return all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("time", "positions", "frames")
    )


@pytest.mark.parametrize("ends", few_of(["free", "clamped", "periodic"], {"free", "periodic"}))
def test_a_run_is_made_again_from_its_file_alone(tmp_path, ends):
    positions, frames = chain_of()
    scene = make_scene(ends)
    found = nrchain.simulate(scene, output=tmp_path, positions=positions, frames=frames)
    assert np.array_equal(found.positions[0], positions)
    read = nrchain.Trajectory.open(tmp_path).scene
    assert read == found.scene != scene
    assert read.start.shape == "given"
    assert np.array_equal(read.start.positions, positions)
    assert np.array_equal(read.start.frames, frames)
    assert same_run(nrchain.simulate(read), found)
    # and from a table of text that was taken out of it, by the command line too
    assert Scene.from_toml(read.to_toml()) == read
    (tmp_path / "again.toml").write_text(read.to_toml())
    result = CliRunner().invoke(
        app, ["run", str(tmp_path / "again.toml"), "-o", str(tmp_path / "b")]
    )
    assert result.exit_code == 0, result.stderr
    assert same_run(nrchain.Trajectory.open(tmp_path / "b"), found)


@pytest.mark.parametrize("given", ["positions", "frames"])
def test_what_is_not_given_is_the_scenes_and_is_recorded_too(given):
    poses = dict(zip(("positions", "frames"), chain_of(), strict=True))
    scene = make_scene()
    found = nrchain.simulate(scene, **{given: poses[given]})
    built = dict(zip(("positions", "frames"), starting_poses(scene), strict=True))
    for name, values in (built | {given: poses[given]}).items():
        assert np.array_equal(getattr(found.scene.start, name), values)
    assert same_run(nrchain.simulate(found.scene), found)


def test_a_start_of_the_scene_stays_the_scenes(tmp_path):
    scene = make_scene()
    assert nrchain.simulate(scene, output=tmp_path).scene == scene
    with h5py.File(tmp_path / FILE_NAME) as file:
        assert "parameters/start" not in file
        assert file["parameters/scene"].asstr()[()] == scene.to_toml()


def test_the_file_says_where_the_start_came_from_and_holds_it(tmp_path):
    positions, frames = chain_of()
    nrchain.simulate(make_scene(), output=tmp_path, positions=positions, frames=frames)
    with h5py.File(tmp_path / FILE_NAME) as file:
        text = file["parameters/scene"].asstr()[()]
        assert np.array_equal(file["parameters/start/position"], positions)
        assert np.array_equal(file["parameters/start/frame"], frames)
    assert 'shape = "given"' in text
    assert "random" not in text
    with pytest.raises(
        SceneError, match=r"parameters/start.*Trajectory.open\(path\).scene has them"
    ):
        Scene.from_toml(text)


def test_a_wrapped_start_is_recorded_as_it_was_put_together():
    positions, frames = chain_of()
    wrapped = positions.copy()
    wrapped[4:, 0] -= COUNT * SPACING
    found = nrchain.simulate(make_scene("periodic"), positions=wrapped, frames=frames)
    assert found.scene.start.positions.values == pytest.approx(positions, abs=1e-12)
    assert same_run(nrchain.simulate(found.scene), found)


def test_a_resumed_run_still_holds_its_start(tmp_path):
    positions, frames = chain_of()
    poses = {"positions": positions, "frames": frames}
    whole = nrchain.simulate(make_scene(), **poses)
    limited = make_scene(**{"run.max_steps": whole.counters["steps"] // 2 + 1})
    assert nrchain.simulate(limited, output=tmp_path, **poses).status == "stopped"
    resumed = nrchain.resume(tmp_path)
    assert same_run(resumed, whole)
    assert np.array_equal(resumed.scene.start.positions, positions)
    again = nrchain.load_scene(resumed.scene, **{"run.max_steps": None})
    assert same_run(nrchain.simulate(again), whole)


def test_other_changes_keep_the_start():
    positions, frames = chain_of()
    scene = nrchain.simulate(make_scene(), positions=positions, frames=frames).scene
    other = load_scene(scene, **{"slip.2s": 7.0})
    assert other.start == scene.start
    assert np.array_equal(starting_poses(other)[0], positions)
    plain = load_scene(scene, start={"shape": "straight", "positions": None, "frames": None})
    assert starting_poses(plain)[0][:, 1:].any() == np.False_
    with pytest.raises(SceneError, match=r"start.positions = \(6, 3\): the shape must be \(7, 3\)"):
        load_scene(scene, **{"chain.particles": 7})


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({"shape": "given"}, "start.shape = 'given': must come with start.positions"),
        ({"positions": np.zeros((COUNT, 3))}, "start.positions .*is for start.shape = 'given'"),
        ({"shape": "given", "positions": np.zeros((4, 3))}, r"the shape must be \(6, 3\)"),
        ({"shape": "given", "positions": [[1.0, 2.0]] * 6}, r"start.positions.*\(N, 3\)"),
        ({"shape": "given", "frames": [["x"] * 3] * 3}, "start.frames .*must be numbers"),
        ({"shape": "given", "positions": np.full((6, 3), np.nan)}, "must be finite"),
    ],
)
def test_starts_that_are_none_are_refused_with_the_scene(start, message):
    with pytest.raises(SceneError, match=message):
        make_scene(start=start)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({"positions": np.zeros((COUNT, 3))}, "start.positions = .*overlap"),
        ({"frames": -np.tile(np.eye(3), (COUNT, 1, 1))}, r"start.frames\[0\] .*left-handed"),
    ],
)
def test_starts_that_cannot_be_run_are_refused_before_the_run(start, message):
    scene = load_scene(make_scene(), start={"shape": "given", **start})
    with pytest.raises(SceneError, match=message):
        nrchain.simulate(scene)


def test_a_given_start_is_planned_and_costed_as_it_is():
    positions, frames = chain_of()
    scene = nrchain.simulate(make_scene(), positions=positions, frames=frames).scene
    from nrchain.planning.plan import plan

    assert plan(scene).lines
    assert nrchain.describe(scene).without_effect == []


def test_arrays_of_scenes_are_values():
    one, other = GivenArray([[1.0, 0.0]]), GivenArray(np.array([[1.0, -0.0]]))
    assert one == other
    assert hash(one) == hash(other)
    assert one != GivenArray([1.0, 0.0])
    assert repr(one) == "<array of shape (1, 2)>"
    with pytest.raises(ValueError, match="read-only"):
        one.values[0] = 2.0
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        copied = pickle.loads(pickle.dumps(one, protocol))
        assert copied == one
        assert not copied.values.flags.writeable
    assert copy.deepcopy(one) == copy.copy(one) == one
