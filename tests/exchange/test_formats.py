"""Exported files hold the poses of the run, as programs that are not ours read them."""

import json
import warnings
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import nrchain
from nrchain.errors import SceneError, TrajectoryError
from nrchain.exchange import export as exporting
from nrchain.exchange.start import read_start

with warnings.catch_warnings():
    # of their own dependencies
    warnings.simplefilter("ignore")
    import ase.io
    import gsd.hoomd
    import MDAnalysis
    import xarray
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

SINGLE = 1e-6
"""Rounding to 32 bits of coordinates up to ten."""


@cache
def run(ends):
    """A chain that turns and, if it is periodic, lies off the middle of its box."""
    table = {
        "title": 'it\'s "odd"',
        "chain": {"particles": 6, "spacing": 7.3, "radius": 1.5, "ends": ends},
        "slip": {"2s": 40.0, "3a": {"strength": 60.0, "axis": [0.0, 1.0, 0.0]}},
        "start": {"shape": "random", "amplitude": 0.3},
        "run": {"end": 20.0, "snapshots": 5},
    }
    return nrchain.simulate(nrchain.load_scene(table))


ENDS = ["free", "periodic"]


@pytest.fixture(params=ENDS)
def trajectory(request):
    return run(request.param)


def rotations(trajectory):
    """What turns the axes of the lab into those of each sphere."""
    return Rotation.from_matrix(np.swapaxes(trajectory.frames.reshape(-1, 3, 3), 1, 2))


def assert_turned(quaternions, trajectory, precision, *, scalar_first):
    found = Rotation.from_quat(quaternions.reshape(-1, 4), scalar_first=scalar_first)
    off = (found * rotations(trajectory).inv()).magnitude()
    assert off.max() < precision


def test_gsd_as_its_own_library_reads_it(trajectory, tmp_path):
    path = nrchain.export(trajectory, tmp_path / "run.gsd")
    with gsd.hoomd.open(path, "r") as file:
        frames = list(file)
    chain = trajectory.scene.chain
    closed = chain.ends == "periodic"
    assert len(frames) == len(trajectory)
    for k, frame in enumerate(frames):
        frame.validate()
        box = frame.configuration.box
        half = box[:3] / 2
        assert (abs(frame.particles.position) <= half).all()
        assert (box[0] == np.float32(trajectory.scene.length)) == closed
        unwrapped = frame.particles.position + frame.particles.image * box[:3].astype(float)
        assert unwrapped == pytest.approx(trajectory.positions[k], abs=5 * SINGLE)
        assert (frame.particles.diameter == 2 * chain.radius).all()
        assert frame.bonds.group.tolist()[0] == [0, 1]
        assert chain.particles - (not closed) == frame.bonds.N
        assert frame.log["nrchain/time"][0] == trajectory.time[k]
    turned = np.array([frame.particles.orientation for frame in frames])
    assert_turned(turned, trajectory, SINGLE, scalar_first=True)
    images = np.array([frame.particles.image for frame in frames])
    assert images.any() == closed


def test_gsd_as_mdanalysis_reads_it(trajectory, tmp_path):
    path = nrchain.export(trajectory, tmp_path / "run.gsd")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = MDAnalysis.Universe(str(path))
        found = np.array([frame.positions.copy() for frame in universe.trajectory])
        edges = universe.dimensions[:3]
    assert len(universe.bonds) == trajectory.scene.chain.particles - (
        trajectory.scene.chain.ends != "periodic"
    )
    off = (found - trajectory.positions) / edges
    if trajectory.scene.chain.ends == "periodic":
        off[..., 0] -= np.rint(off[..., 0])
    assert abs(off * edges).max() < 5 * SINGLE


def test_xyz_as_ase_reads_it(trajectory, tmp_path):
    path = nrchain.export(trajectory, tmp_path / "run.xyz")
    found = ase.io.read(path, index=":", format="extxyz")
    assert np.array_equal([one.positions for one in found], trajectory.positions)
    assert [one.info["Time"] for one in found] == trajectory.time.tolist()
    closed = trajectory.scene.chain.ends == "periodic"
    assert found[0].pbc.tolist() == [closed, False, False]
    assert found[0].cell[0, 0] == (trajectory.scene.length if closed else 0.0)
    assert (found[0].arrays["radius"] == 1.5).all()
    turned = np.array([one.arrays["orientation"] for one in found])
    assert_turned(turned, trajectory, 1e-14, scalar_first=False)


def test_vtp_as_vtk_reads_it(trajectory, tmp_path):
    path = nrchain.export(trajectory, tmp_path / "run.pvd")
    text, count = path.read_text(), trajectory.scene.chain.particles
    for k, time in enumerate(trajectory.time.tolist()):
        name = f"run-vtp/{k:06d}.vtp"
        assert f'timestep="{time!r}" part="0" file="{name}"' in text
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(tmp_path / name))
        reader.Update()
        data = reader.GetOutput()
        assert np.array_equal(vtk_to_numpy(data.GetPoints().GetData()), trajectory.positions[k])
        at_points = data.GetPointData()
        for row, vector in enumerate(("e1", "e2", "e3")):
            found = vtk_to_numpy(at_points.GetArray(vector))
            assert np.array_equal(found, trajectory.frames[k, :, row])
        assert (vtk_to_numpy(at_points.GetArray("radius")) == 1.5).all()
        assert data.GetNumberOfLines() == count - 1
        ends = vtk_to_numpy(data.GetLines().GetConnectivityArray()).reshape(-1, 2)
        assert ends.tolist() == [[i, i + 1] for i in range(count - 1)]
        assert vtk_to_numpy(data.GetFieldData().GetArray("TimeValue")).tolist() == [time]


def test_npz_as_numpy_reads_it(trajectory, tmp_path):
    path = nrchain.export(trajectory, tmp_path / "run.npz")
    with np.load(path) as file:
        for name in ("time", "positions", "frames"):
            assert np.array_equal(file[name], getattr(trajectory, name))
        assert 'title = "it\'s \\"odd\\""' in str(file["scene"])


def test_netcdf_as_xarray_reads_it(trajectory, tmp_path):
    path = nrchain.export(trajectory, tmp_path / "run.nc")
    with xarray.open_dataset(path, engine="h5netcdf") as file:
        found = file.load()
    assert found.identical(trajectory.to_xarray().assign_attrs(record=found.attrs["record"]))
    assert found["position"].dims == ("time", "sphere", "axis")
    assert np.array_equal(found["position"].sel(axis="y"), trajectory.positions[..., 1])
    assert np.array_equal(found["frame"].sel(vector="e3"), trajectory.frames[..., 2, :])
    assert found["time"].dtype == float
    assert found["arclength"].values.tolist() == [7.3 * i for i in range(6)]
    assert "radius 1.5" in found["position"].units
    assert "viscosity is 1" in found["time"].units
    assert found.attrs["slip.2s"] == 40.0
    assert found.attrs["slip.3a.axis"].tolist() == [0.0, 1.0, 0.0]
    assert found.attrs["chain.ends"] == trajectory.scene.chain.ends


def test_a_verified_run_keeps_its_errors(tmp_path):
    short = {"chain.particles": 4, "run.end": 1.0, "run.snapshots": 3, "run.verify": True}
    trajectory = nrchain.simulate(nrchain.load_scene("buckling", **short))
    dataset = trajectory.to_xarray()
    assert np.array_equal(dataset["position_error"], trajectory.position_error)
    assert dataset["frame_error"].units == "rad"
    with np.load(nrchain.export(trajectory, tmp_path / "run.npz")) as file:
        assert np.array_equal(file["frame_error"], trajectory.frame_error)


@pytest.mark.parametrize("ending", ["gsd", "xyz", "pvd", "npz", "nc"])
def test_a_slice_has_its_own_frames_and_the_record_of_the_run(ending, tmp_path):
    trajectory = run("free")
    path = nrchain.export(trajectory[1::2], tmp_path / f"run.{ending}")
    for index, row in ((0, 1), (1, 3), (-1, 3)):
        found = read_start(f"{path}:{index}")
        assert found.positions == pytest.approx(trajectory.positions[row], abs=SINGLE * 5)
        assert found.provenance.steps[-1].time == trajectory.time[row]
    with pytest.raises(TrajectoryError, match="frames 0 to 1, or -1 for the last"):
        read_start(f"{path}:2")


def test_endings_and_files_that_exist_are_refused(tmp_path):
    trajectory = run("free")
    with pytest.raises(SceneError, match=r"must end in \.gsd, \.xyz, \.pvd, \.npz, \.nc"):
        nrchain.export(trajectory, tmp_path / "run.vtu")
    with pytest.raises(SceneError, match="at least one snapshot"):
        nrchain.export(trajectory[5:], tmp_path / "run.npz")
    path = nrchain.export(trajectory, tmp_path / "run.pvd")
    with pytest.raises(TrajectoryError, match="exists; it is replaced only with overwrite=True"):
        nrchain.export(trajectory, path)
    path.unlink()
    with pytest.raises(TrajectoryError, match="run-vtp: exists"):
        nrchain.export(trajectory, path)
    nrchain.export(trajectory[:2], path, overwrite=True)
    assert sorted(one.name for one in (tmp_path / "run-vtp").iterdir()) == [
        "000000.vtp",
        "000001.vtp",
    ]


@pytest.mark.parametrize("ending", ["xyz", "pvd"])
def test_an_export_that_fails_leaves_nothing(ending, tmp_path, monkeypatch):
    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(exporting.Record, "to_json", fail)
    with pytest.raises(TrajectoryError, match="No space left"):
        nrchain.export(run("free"), tmp_path / f"run.{ending}")
    assert not list(tmp_path.iterdir())


def test_the_keys_of_a_scene_are_in_each_file(tmp_path):
    trajectory = run("free")
    with gsd.hoomd.open(nrchain.export(trajectory, tmp_path / "run.gsd"), "r") as file:
        record = json.loads(bytes(file.file.read_chunk(frame=0, name="nrchain/record")))
        assert list(file[0].log) == list(file[1].log) == ["nrchain/time"]
    assert nrchain.Scene.from_toml(record["scene"]) == trajectory.scene
