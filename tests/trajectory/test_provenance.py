"""Provenance in one line and in files: no wider than a terminal, and checked when it is read."""

import h5py
import numpy as np
import pytest

import nrchain
from nrchain.errors import TrajectoryError
from nrchain.trajectory.provenance import FROM_SCENE, Provenance, Step, pose_hash, scene_hash

LABEL = 15
"""Columns of `nrchain: note: ` before the line."""

SOURCES = {
    "/data/a/trajectory.h5": "a",
    "/data/a/run.gsd": "run.gsd",
    "/data/" + "a" * 40 + ".gsd": "…" + "a" * 9 + ".gsd",
    "": "memory",
}


def step(source, how="started", **more):
    parts = {"format": "gsd", "frame": 99999, "time": 123.4567, "precision": "float32"} | more
    return Step(how, source, scene="", poses="", **parts)


@pytest.mark.parametrize(("source", "name"), SOURCES.items())
def test_a_line_names_the_source_and_fits_a_terminal(source, name):
    last = step(source)
    assert last.words() == f"from {name}:99999, t = 123.457, float32"
    line = Provenance((*[step("/b.xyz")] * 12, last)).line
    assert line.endswith("; 12 earlier steps")
    assert LABEL + len(line) <= 80
    assert len(repr(Provenance((last,)))) < 120


def test_lines_of_other_steps():
    assert FROM_SCENE.line == ""
    assert step("/a.xyz", time=None, precision="float64").words() == "from a.xyz:99999"
    assert step("", format="arrays").words() == "from arrays in memory"
    assert step("/data/a/trajectory.h5", "exported").words() == "exported from a"
    assert step("/x/trajectory.h5", "extended").words() == "extended from t = 123.457"
    assert Provenance((step("/a.xyz"),) * 2).line.endswith("; 1 earlier step")


def test_hashes_tell_poses_and_scenes_apart():
    positions, frames = np.zeros((2, 3)), np.stack([np.eye(3)] * 2)
    moved = positions.copy()
    moved[1, 2] = np.nextafter(0.0, 1.0)
    assert pose_hash(positions, frames) != pose_hash(moved, frames)
    assert pose_hash(positions, frames) == pose_hash(positions.astype(np.float32), frames)
    scene = nrchain.load_scene("passive")
    assert scene_hash(scene) == scene_hash(nrchain.Scene.from_toml(scene.to_toml()))
    assert scene_hash(scene) != scene_hash(nrchain.load_scene(scene, **{"run.end": 1.0}))


def test_a_damaged_provenance_is_an_error_that_names_the_file(tmp_path):
    short = {"chain.particles": 4, "run.end": 1.0, "run.snapshots": 2}
    scene = nrchain.load_scene("passive", **short)
    first = nrchain.simulate(scene, output=tmp_path / "first")
    assert nrchain.Trajectory.open(tmp_path / "first").provenance == FROM_SCENE
    path = nrchain.simulate(scene, start=first, output=tmp_path / "second").path
    with h5py.File(path, "r+") as file:
        text = file["parameters/provenance"]
        text[()] = text[()].replace(b'"how"', b'"who"')
    with pytest.raises(TrajectoryError, match=r"second/trajectory\.h5: damaged"):
        nrchain.Trajectory.open(path)
