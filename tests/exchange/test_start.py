"""A run starts from a frame of a run, of an exported file or in memory, and says from which."""

import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nrchain
from nrchain.errors import SceneError, TrajectoryError
from nrchain.exchange.record import Record
from nrchain.exchange.start import read_start, split_frame
from nrchain.trajectory.provenance import Provenance, Step

EXACT = ["npz", "nc", "pvd"]
"""Formats that keep positions and frames bit for bit."""

PRECISION = {"gsd": 1e-6, "xyz": 1e-15}
"""Of the others: largest error of a pose, over the largest coordinate."""


def scene(**changes):
    short = {"chain.particles": 5, "start.shape": "random", "run.end": 10.0, "run.snapshots": 5}
    return nrchain.load_scene("passive", **short | {"slip.2s": 40.0} | changes)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run and its exports."""
    place = tmp_path_factory.mktemp("runs")
    trajectory = nrchain.simulate(scene(), output=place / "first")
    for ending in (*EXACT, *PRECISION):
        nrchain.export(trajectory, place / f"first.{ending}")
    return place


def sha(*arrays):
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(array.astype("<f8").tobytes())
    return digest.hexdigest()[:16]


def assert_starts_at(run, positions, frames, *, error=0.0):
    assert abs(run.positions[0] - positions).max() <= error * abs(positions).max()
    assert abs(run.frames[0] - frames).max() <= error
    gram = np.einsum("nak,nbk->nab", run.frames[0], run.frames[0])
    assert abs(gram - np.eye(3)).max() < 1e-8


def test_a_frame_of_a_run_is_taken_bit_for_bit(folder):
    first = nrchain.Trajectory.open(folder / "first")
    starts = [first[2], first[1:3], f"{folder / 'first'}:2", f"{folder / 'first'}:-3"]
    starts += [f"{folder / 'first' / 'trajectory.h5'}:2", read_start(f"{folder / 'first'}:2")]
    for start in starts:
        run = nrchain.simulate(scene(), start=start)
        assert_starts_at(run, first.positions[2], first.frames[2])
        assert run.time[0] == 0.0
        (step,) = run.provenance.steps
        where = step.how, step.format, step.source, step.frame, step.time
        path = str(folder / "first" / "trajectory.h5")
        assert where == ("started", "run", path, 2, first.time[2])
        toml = first.scene.to_toml().encode()
        assert step.scene == hashlib.sha256(toml).hexdigest()[:16]
        assert step.poses == sha(first.positions[2], first.frames[2])
        assert (step.precision, step.version) == ("float64", nrchain.__version__)


def test_without_a_number_it_is_the_last_frame(folder):
    first = nrchain.Trajectory.open(folder / "first")
    for start in (first, folder / "first", folder / "first.npz"):
        run = nrchain.simulate(scene(), start=start)
        assert_starts_at(run, first.positions[-1], first.frames[-1])


def test_a_run_goes_on_as_if_it_had_not_been_cut(folder):
    """The motion does not depend on time: a run from the middle repeats the second half."""
    first = nrchain.Trajectory.open(folder / "first")
    half = nrchain.simulate(scene(**{"run.end": 5.0, "run.snapshots": 3}), start=first[2])
    assert half.positions == pytest.approx(first.positions[2:], abs=1e-4)
    assert half.frames == pytest.approx(first.frames[2:], abs=1e-4)


@pytest.mark.parametrize("ending", EXACT)
def test_formats_of_64_bits_give_the_same_run(folder, ending):
    first = nrchain.Trajectory.open(folder / "first")
    expected = nrchain.simulate(scene(), start=first[2])
    run = nrchain.simulate(scene(), start=f"{folder / 'first'}.{ending}:2")
    assert np.array_equal(run.positions, expected.positions)
    assert np.array_equal(run.frames, expected.frames)


@pytest.mark.parametrize("ending", PRECISION)
def test_quaternions_give_the_poses_to_the_precision_of_the_format(folder, ending):
    first = nrchain.Trajectory.open(folder / "first")
    run = nrchain.simulate(scene(), start=f"{folder / 'first'}.{ending}:2")
    error = PRECISION[ending]
    assert_starts_at(run, first.positions[2], first.frames[2], error=error)
    assert run.provenance.steps[-1].precision == ("float32" if ending == "gsd" else "float64")
    assert ("float32" in run.provenance.line) == (ending == "gsd")


def test_one_frame_of_vtk_is_a_start(folder):
    first = nrchain.Trajectory.open(folder / "first")
    run = nrchain.simulate(scene(), start=folder / "first-vtp" / "000002.vtp")
    assert_starts_at(run, first.positions[2], first.frames[2])
    assert run.provenance.steps[-1].time == first.time[2]


def test_the_chain_of_steps_survives_runs_exports_and_files(folder, tmp_path):
    """run → GSD → run → netCDF → run: each step is in the file of the last run."""
    second = nrchain.simulate(scene(), start=f"{folder / 'first.gsd'}:3", output=tmp_path / "two")
    nrchain.export(second, tmp_path / "two.nc")
    third = nrchain.simulate(scene(), start=tmp_path / "two.nc", output=tmp_path / "three")
    kept = nrchain.Trajectory.open(tmp_path / "three").provenance
    assert kept == third.provenance
    seen = [(step.how, step.source, step.frame) for step in kept.steps]
    assert seen == [
        ("exported", str(folder / "first" / "trajectory.h5"), 4),
        ("started", str(folder / "first.gsd"), 3),
        ("exported", str(tmp_path / "two" / "trajectory.h5"), 4),
        ("started", str(tmp_path / "two.nc"), 4),
    ]
    assert kept.line == "from two.nc:4, t = 10; 3 earlier steps"
    assert kept.line in third._repr_html_()
    assert kept.steps[2].scene == kept.steps[3].scene
    assert kept.steps[0].poses == sha(
        *(getattr(nrchain.Trajectory.open(folder / "first"), n) for n in ("positions", "frames"))
    )
    # the scene of the file starts at these poses by itself
    again = nrchain.simulate(nrchain.Trajectory.open(tmp_path / "three").scene)
    assert np.array_equal(again.positions, third.positions)
    assert not again.provenance


def test_arrays_are_a_start(folder):
    first = nrchain.Trajectory.open(folder / "first")
    poses = first.positions[1], first.frames[1]
    for run in (
        nrchain.simulate(scene(), start=poses),
        nrchain.simulate(scene(), positions=poses[0], frames=poses[1]),
    ):
        assert_starts_at(run, *poses)
        (step,) = run.provenance.steps
        assert (step.format, step.poses) == ("arrays", sha(*poses))


def test_wrapped_positions_of_a_periodic_chain_are_unwrapped(tmp_path):
    closed = scene(**{"chain.ends": "periodic"})
    first = nrchain.simulate(closed)
    path = nrchain.export(first, tmp_path / "first.gsd")
    assert_starts_at(
        nrchain.simulate(closed, start=path), first.positions[-1], first.frames[-1], error=1e-6
    )


def refused(start, match, error=SceneError, **changes):
    with pytest.raises(error, match=match):
        nrchain.simulate(scene(**changes), start=start)


def test_what_is_no_start_is_refused(folder, tmp_path):
    first = nrchain.Trajectory.open(folder / "first")
    for start in (folder / "first", folder / "first.gsd", first[1], (first.positions[1],) * 2):
        match = "has 5 spheres, and chain.particles is 6"
        if isinstance(start, tuple):
            match = r"start: frames = \(5, 3\): the shape must be \(5, 3, 3\)"
        refused(start, match, **{"chain.particles": 6})
    missing = "there is no frame", TrajectoryError
    refused(f"{folder / 'first'}:5", r"no frame 5; .*frames 0 to 4, or -1 for the last", missing[1])
    refused(f"{folder / 'first'}:-6", *missing)
    refused(f"{folder / 'first.npz'}:7", r"first\.npz: there is no frame 7; ", missing[1])
    refused(f"{folder / 'first.npz'}:last", "'last'; frames are whole numbers", missing[1])
    refused(7, "must be a snapshot, a trajectory")
    refused(folder / "nowhere", "no such trajectory", TrajectoryError)
    refused(folder / "nowhere.xyz", "there is no such file", TrajectoryError)
    with pytest.raises(SceneError, match="takes the place of positions and frames"):
        nrchain.simulate(scene(), start=first, positions=first.positions[0])


def test_a_start_that_touches_or_is_torn_is_refused_with_its_source(folder):
    first = nrchain.Trajectory.open(folder / "first")
    positions, frames = first.positions[-1].copy(), first.frames[-1].copy()
    positions[1] = positions[0] + [1.9, 0.0, 0.0]
    refused((positions, frames), "start from arrays: positions.*spheres 0 and 1.*overlap")
    turned = first.frames[-1].copy()
    turned[2] = turned[2][[1, 0, 2]] * [[1], [-1], [1]]
    refused((first.positions[-1], turned), "start from arrays: frames.*link.*π/2")
    refused((first.positions[-1], 1.1 * frames), r"start from arrays: frames\[0\].*orthonormal")
    refused((first.positions[-1], -frames), "start from arrays: frames.*left-handed")


@pytest.mark.parametrize("ending", ["gsd", "xyz", "pvd", "vtp", "npz", "nc"])
def test_files_of_another_kind_are_refused_in_one_line(tmp_path, ending):
    path = tmp_path / f"odd.{ending}"
    for content in (b"", b"not what it seems\n", b"<VTKFile/>", b"3\nno properties\nX 0 0 0\n"):
        path.write_bytes(content)
        with pytest.raises((SceneError, TrajectoryError)) as error:
            read_start(path)
        assert "odd" in str(error.value)


def test_a_cut_array_of_vtk_is_refused(folder, tmp_path):
    path, text = tmp_path / "cut.vtp", (folder / "first-vtp" / "000000.vtp").read_text()
    begin = text.index('Name="e2"')
    end = text.index("</DataArray>", begin)
    path.write_text(text[: end - 16] + text[end:])
    with pytest.raises(TrajectoryError, match="e2 is cut short"):
        read_start(path)


def test_xyz_of_another_program_needs_orientations(tmp_path):
    path = tmp_path / "other.xyz"
    path.write_text("1\nProperties=species:S:1:pos:R:3\nX 0 0 0\n")
    with pytest.raises(TrajectoryError, match="orientation:R:4"):
        read_start(path)
    path.write_text("1\nProperties=id:I:1:orientation:R:4:pos:R:3\n7 0 0 0 1 1.5 2.5 3.5\n")
    found = read_start(path)
    assert found.positions.tolist() == [[1.5, 2.5, 3.5]]
    assert np.array_equal(found.frames, np.eye(3)[None])
    assert found.provenance.steps[-1].time is None
    for length in ("2", "0", "nan"):
        path.write_text(f"1\nProperties=orientation:R:4:pos:R:3\n0 0 0 {length} 1.5 2.5 3.5\n")
        with pytest.raises(TrajectoryError, match=f"sphere 0 must be .* and has length {length}"):
            read_start(path)


def test_paths_may_have_colons(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert split_frame("a:3") == (type(tmp_path)("a"), 3)
    assert split_frame("a.gsd:-2")[1] == -2
    (tmp_path / "a:3").mkdir()
    assert split_frame("a:3") == (type(tmp_path)("a:3"), -1)
    assert split_frame("a:3:4") == (type(tmp_path)("a:3"), 4)
    assert split_frame("a:b") == (type(tmp_path)("a:b"), -1)


@settings(max_examples=30)
@given(st.text(), st.text())
def test_a_record_survives_any_text_with_and_without_quotes(scene, source):
    step = Step("exported", source, "run", 1, 2.5, "a", "b")
    record = Record(scene, Provenance((step,)))
    assert Record.from_json(record.to_json()) == record
    line = record.unquoted()
    assert line.isascii()
    assert '"' not in line
    assert line.isprintable()
    assert Record.from_unquoted(line) == record
