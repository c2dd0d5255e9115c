"""Other programs read the files of runs: finished, stopped, killed, resumed, and of those going."""

import os
import shutil
import signal
import subprocess
import sys
import warnings

import h5py
import numpy as np
import pyh5md
import pytest
from support.selection import few_of

import nrchain
from nrchain.errors import TrajectoryError
from nrchain.outcome import Cause
from nrchain.trajectory.file import FILE_NAME

with warnings.catch_warnings():
    # of its own dependencies
    warnings.simplefilter("ignore")
    import MDAnalysis


def make_scene(ends="free", **changes):
    """Lengths in which the radius, the viscosity and the spacing are none of the defaults."""
    chain = {"particles": 6, "spacing": 7.0, "radius": 1.5, "viscosity": 0.7, "ends": ends}
    start = {"shape": "random", "amplitude": 0.05}
    run = {"end": 40.0, "snapshots": 9}
    return nrchain.load_scene(
        {"chain": chain, "start": start, "run": run, "slip.2s": 5.0}, **changes
    )


def universe(path, particles):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        made = MDAnalysis.Universe.empty(particles, trajectory=True)
        made.load_new(str(path), format="H5MD")
    return made


def assert_read_by_all(path, found):
    """MDAnalysis and pyh5md find the snapshots that we do, and no more."""
    count, particles = found.positions.shape[:2]
    periodic = found.scene.chain.ends == "periodic"
    read = universe(path, particles)
    try:
        assert len(read.trajectory) == count
        for k, frame in enumerate(read.trajectory):
            assert frame.time == found.time[k]
            # MDAnalysis keeps coordinates in single precision
            assert np.array_equal(frame.positions, found.positions[k].astype(np.float32))
            if periodic:
                assert frame.dimensions.tolist() == [found.scene.length] * 3 + [90.0] * 3
            else:
                assert frame.dimensions is None
    finally:
        read.trajectory.close()
    with pyh5md.File(str(path), "r") as file:
        group = file.particles_group("trajectory")
        position = pyh5md.element(group, "position")
        assert position.element_type == "TimeElement"
        assert np.array_equal(position.value[()], found.positions)
        assert np.array_equal(position.time[()], found.time)
        assert np.array_equal(pyh5md.element(group, "frame").value[()], found.frames)
        assert (np.diff(position.step[()]) >= 0).all()
        assert position.step[0] == 0
        edges = pyh5md.element(group["box"], "edges") if periodic else None
        if edges is not None:
            assert np.array_equal(edges.value[()], np.full((count, 3), found.scene.length))


@pytest.mark.parametrize("ends", ["free", "clamped", "periodic"])
def test_a_completed_run_is_read(tmp_path, ends):
    found = nrchain.simulate(make_scene(ends), output=tmp_path)
    assert found.status == "completed"
    assert len(found.time) == 9
    assert_read_by_all(tmp_path / FILE_NAME, found)


@pytest.mark.parametrize("ends", ["free", "periodic"])
def test_a_stopped_run_is_read_to_its_stop_and_so_it_is_once_resumed(tmp_path, ends):
    whole = nrchain.simulate(make_scene(ends))
    scene = make_scene(ends, **{"run.max_steps": whole.counters["steps"] // 2 + 1})
    stopped = nrchain.simulate(scene, output=tmp_path)
    assert stopped.cause is Cause.BUDGET
    assert 1 < len(stopped.time) < 9
    assert_read_by_all(tmp_path / FILE_NAME, stopped)
    resumed = nrchain.resume(tmp_path)
    assert resumed.status == "completed"
    assert np.array_equal(resumed.positions, whole.positions)
    assert_read_by_all(tmp_path / FILE_NAME, resumed)


def test_the_units_are_named_with_what_they_stand_for(tmp_path):
    nrchain.simulate(make_scene("periodic"), output=tmp_path)
    with h5py.File(tmp_path / FILE_NAME) as file:
        group = file["particles/trajectory"]
        length = group["position/value"].attrs["unit"]
        assert length == group["box/edges/value"].attrs["unit"] == "Angstrom"
        assert group["position/time"].attrs["unit"] == "ps"
        assert "unit" not in group["frame/value"].attrs
        assert "radius of a sphere is 1.5" in file["nrchain"].attrs[f"unit {length}"]
        assert "viscosity is 0.7" in file["nrchain"].attrs["unit ps"]


RUN = """
import sys, nrchain
scene = nrchain.Scene.from_toml(sys.argv[2])
def wait(progress):
    print(progress.snapshot, flush=True)
    sys.stdin.readline()
nrchain.simulate(scene, output=sys.argv[1], progress=wait)
"""


class Going:
    """A run in a process of its own, which waits after every snapshot until it is told to go on."""

    def __init__(self, path, scene, program=RUN):
        arguments = [sys.executable, "-c", program, str(path), scene.to_toml()]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self.child = subprocess.Popen(arguments, **pipes)
        self.pid = self.child.pid

    def reach(self):
        return int(self.child.stdout.readline())

    def begin(self):
        """Reach the second snapshot, with a checkpoint to go on from before it."""
        assert self.reach() == 1
        self.go_on()
        assert self.reach() == 2

    def go_on(self):
        self.child.stdin.write("\n")
        self.child.stdin.flush()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.child.kill()
        self.child.communicate()


@pytest.mark.parametrize("ends", few_of(["free", "periodic"], {"periodic"}))
def test_a_run_is_read_while_it_goes_on_and_after_it_was_killed(tmp_path, ends):
    path = tmp_path / FILE_NAME
    with Going(path, make_scene(ends)) as going:
        for snapshot in range(1, 5):
            assert going.reach() == snapshot
            found = nrchain.Trajectory.open(path)
            assert len(found.time) == snapshot
            assert_read_by_all(path, found)
            with h5py.File(path, "r") as file:
                assert len(file["particles/trajectory/position/value"]) == snapshot
                going.go_on()
    assert_read_by_all(path, nrchain.Trajectory.open(path))


def test_a_run_goes_on_while_others_have_its_file_open(tmp_path):
    path = tmp_path / FILE_NAME
    reading = "import sys, h5py; file = h5py.File(sys.argv[1]); print(1, flush=True); input()"
    with Going(path, make_scene()) as going:
        assert going.reach() == 1
        with Going(path, make_scene(), reading) as reader:
            assert reader.reach() == 1
            going.go_on()
            assert going.reach() == 2
            with h5py.File(path, "r"):
                going.go_on()
                assert going.reach() == 3
    assert len(nrchain.Trajectory.open(path).time) == 3


def test_a_run_is_resumed_and_replaced_while_others_have_its_file_open(tmp_path):
    path = tmp_path / FILE_NAME
    nrchain.simulate(make_scene(**{"run.max_steps": 3}), output=path)
    reading = "import sys, h5py; file = h5py.File(sys.argv[1]); print(1, flush=True); input()"
    with Going(path, make_scene(), reading) as reader:
        assert reader.reach() == 1
        assert nrchain.resume(path).time[-1] > 0
        nrchain.simulate(make_scene(), output=path, overwrite=True)
    assert nrchain.Trajectory.open(path).status == "completed"


@pytest.mark.parametrize(
    "act", [nrchain.resume, lambda p: nrchain.simulate(make_scene(), output=p, overwrite=True)]
)
def test_the_process_that_writes_is_named(tmp_path, act):
    path = tmp_path / FILE_NAME
    with Going(path, make_scene()) as going:
        going.begin()
        with pytest.raises(TrajectoryError, match=f"process {going.pid} is writing to it"):
            act(path)
        (tmp_path / "link.h5").symlink_to(path)
        with pytest.raises(TrajectoryError, match=f"process {going.pid} is writing to it"):
            act(tmp_path / "link.h5")
    writing = "import sys, h5py; file = h5py.File(sys.argv[1], 'r+'); print(1, flush=True); input()"
    with Going(path, make_scene(), writing) as other:
        assert other.reach() == 1
        with pytest.raises(TrajectoryError, match="another program has it open for writing"):
            act(path)
    act(path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["link.h5", FILE_NAME]


def test_others_cannot_write_to_the_file_of_a_run(tmp_path):
    path = tmp_path / FILE_NAME
    with Going(path, make_scene()) as going:
        assert going.reach() == 1
        with pytest.raises(OSError, match="unable to lock file"):
            h5py.File(path, "r+")


def test_a_file_that_is_renamed_while_it_is_written_is_not_written_by_two(tmp_path):
    path, other = tmp_path / FILE_NAME, tmp_path / "other.h5"
    with Going(path, make_scene()) as going:
        going.begin()
        shutil.copy(path, tmp_path / "copy.h5")
        path.rename(other)
        with pytest.raises(TrajectoryError, match=rf"process {going.pid} .* called {path}"):
            nrchain.resume(other)
        other.rename(path)
        # a copy is another file
        assert nrchain.resume(tmp_path / "copy.h5").status == "completed"
        path.rename(other)
    assert nrchain.resume(other).status == "completed"


def test_a_process_that_has_the_file_open_is_named(tmp_path):
    path = tmp_path / FILE_NAME
    nrchain.simulate(make_scene(**{"run.max_steps": 3}), output=path)
    with h5py.File(path, "r"):
        assert len(nrchain.Trajectory.open(path).time) >= 1
        with pytest.raises(TrajectoryError, match="this process has it open for reading"):
            nrchain.resume(path)
    nrchain.resume(path)


def test_a_run_in_this_process_is_read_in_it(tmp_path):
    path, seen = tmp_path / FILE_NAME, []

    def look(progress):
        seen.append(len(nrchain.Trajectory.open(path).time))

    nrchain.simulate(make_scene(), output=path, progress=look)
    assert seen == list(range(1, 10))


def test_a_child_that_a_run_leaves_behind_does_not_keep_its_file(tmp_path):
    path, children = tmp_path / FILE_NAME, []

    def fork(progress):
        if progress.snapshot == 2:
            child = os.fork()
            if not child:
                signal.pause()
                os._exit(0)
            children.append(child)

    scene = make_scene(**{"run.max_steps": 3})
    try:
        nrchain.simulate(scene, output=path, progress=fork)
        nrchain.resume(path)
    finally:
        for child in children:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
    assert len(children) == 1
