"""What a run writes is what is read back, whatever interrupts it."""

import io
import os
import re
import signal
import subprocess
import sys
import time as clock

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.selection import few_of

from nrchain.effects.registry import acting
from nrchain.errors import SceneError, TrajectoryError
from nrchain.outcome import Cause
from nrchain.run.simulation import resume, simulate
from nrchain.scene.loading import load_scene
from nrchain.trajectory import new_file, rows
from nrchain.trajectory import writer as trajectory_writer
from nrchain.trajectory.block import Block
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.trajectory.file import FILE_NAME, open_file
from nrchain.trajectory.layout import COUNTERS, REASON_BYTES
from nrchain.trajectory.trajectory import Trajectory
from nrchain.trajectory.writer import TrajectoryWriter

TIMES = np.linspace(0.0, 8.0, 5)


def make_scene(particles=4, **changes):
    return load_scene(
        {"chain.particles": particles, "run.end": 8.0, "slip.3a": 0.1, "title": "a test"}, **changes
    )


def poses(particles, seed):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(particles, 3)), rng.normal(size=(particles, 3, 3))


def write(writer, index, time=None):
    time = TIMES[index] if time is None else time
    writer.write(
        index, Block.of_one(time, *poses(writer.scene.chain.particles, index), step=10 * index)
    )


def checkpoint(seed, particles=4):
    return Checkpoint(
        time=0.1 * seed,
        positions=poses(particles, seed)[0],
        frames=poses(particles, seed)[1],
        snapshot=seed,
        spin=-0.3 * seed,
        drift=np.array([seed, 0.5, -1.0]),
        counters={"steps": 3 * seed, "wall_time": 0.25},
    )


def same(first, second):
    return all(np.array_equal(getattr(first, k), getattr(second, k)) for k in vars(first))


@pytest.fixture
def path(tmp_path):
    return tmp_path / FILE_NAME


def test_a_finished_run_is_read_back_bit_for_bit(path):
    scene = make_scene()
    with TrajectoryWriter(path, scene, TIMES) as writer:
        for index in range(len(TIMES)):
            write(writer, index)
        writer.update_counters({"steps": 41, "wall_time": 1.5})
        writer.update_counters({"evaluations": 99})
        writer.close("completed")
    for source in (path, path.parent, str(path)):
        trajectory = Trajectory.open(source)
        assert np.array_equal(trajectory.time, TIMES)
        for index in range(len(TIMES)):
            positions, frames = poses(4, index)
            assert np.array_equal(trajectory.positions[index], positions)
            assert np.array_equal(trajectory.frames[index], frames)
        assert trajectory.scene == scene
        assert (trajectory.status, trajectory.reason) == ("completed", "")
        assert trajectory.counters == dict.fromkeys(COUNTERS, 0) | {
            "steps": 41,
            "evaluations": 99,
            "wall_time": 1.5,
        }
        assert trajectory.path == path
    assert repr(trajectory) == (
        f"<Trajectory 'a test': 4 spheres, 5 snapshots to t = 8, completed, {str(path)!r}>"
    )


@pytest.mark.parametrize("ends", ["free", "periodic"])
def test_the_file_is_h5md(path, ends):
    scene = make_scene(**{"chain.ends": ends})
    with TrajectoryWriter(path, scene, TIMES) as writer:
        write(writer, 0)
        write(writer, 1)
    with h5py.File(path) as file:
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        assert file["h5md/creator"].attrs["name"] == "nrchain"
        assert "name" in file["h5md/author"].attrs
        box = file["particles/trajectory/box"]
        along = "periodic" if ends == "periodic" else "none"
        assert box.attrs["dimension"] == 3
        assert box.attrs["boundary"].tolist() == [along, "none", "none"]
        assert ("edges" in box) == (ends == "periodic")
        elements = ["position", "frame"] + ["box/edges"] * (ends == "periodic")
        for element in elements:
            for name in ("time", "step"):
                series = file[f"particles/trajectory/{element}/{name}"]
                assert series == file[f"particles/trajectory/position/{name}"]
                assert len(series) == len(file[f"particles/trajectory/{element}/value"]) == 2
        if ends == "periodic":
            assert (box["edges/value"][()] == scene.length).all()
        assert file["particles/trajectory/position/value"].shape == (2, 4, 3)
        assert file["particles/trajectory/frame/value"].shape == (2, 4, 3, 3)
        assert file["particles/trajectory/position/step"][()].tolist() == [0, 10]
        assert file["parameters/scene"].asstr()[()] == scene.to_toml()
        assert file["parameters/versions"].attrs["numpy"] == np.__version__
        names = [effect.name for effect in acting(scene)]
        assert list(file["parameters/effects"].asstr()[()]) == names


def test_only_finished_snapshots_are_read(path):
    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        assert len(Trajectory.open(path).time) == 0
        write(writer, 0)
        write(writer, 1)
        with pytest.raises(ValueError, match="snapshot 3 comes after 2, not yet written"):
            write(writer, 3)
        writer.close()
    trajectory = Trajectory.open(path)
    assert trajectory.time.tolist() == TIMES[:2].tolist()
    assert np.array_equal(trajectory.positions[1], poses(4, 1)[0])
    assert trajectory.status == "running"


def test_a_snapshot_that_is_written_again_stays_and_another_one_is_the_last(path):
    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        for index in range(4):
            write(writer, index)
        write(writer, 1)
        assert Trajectory.open(path).time.tolist() == TIMES[:4].tolist()
        write(writer, 2, time=3.5)
        assert Trajectory.open(path).time.tolist() == [TIMES[0], TIMES[1], 3.5]
        write(writer, 3)
    trajectory = Trajectory.open(path)
    assert trajectory.time.tolist() == [TIMES[0], TIMES[1], 3.5, TIMES[3]]
    for index in range(4):
        assert np.array_equal(trajectory.frames[index], poses(4, index)[1])


def test_a_snapshot_that_cannot_be_written_does_not_count(path, monkeypatch):
    put = rows.put

    def full(dataset, *what):
        if dataset.name.endswith("frame/value"):
            raise OSError(28, "No space left on device")
        put(dataset, *what)

    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        write(writer, 0)
        monkeypatch.setattr(rows, "put", full)
        with pytest.raises(TrajectoryError, match="No space left"):
            write(writer, 1)
        monkeypatch.undo()
    with h5py.File(path) as file:
        group = file["particles/trajectory"]
        sizes = {group[f"{k}/{n}"].shape[0] for k in ("position", "frame") for n in group[k]}
    assert sizes == {1}


def test_an_existing_file_is_replaced_only_on_request(path):
    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        write(writer, 0)
    for where in (path, path.parent):
        with pytest.raises(TrajectoryError, match=re.escape(str(path)) + r".*overwrite"):
            TrajectoryWriter(where, make_scene(), TIMES)
    assert len(Trajectory.open(path).time) == 1
    TrajectoryWriter(path, make_scene(6), TIMES, overwrite=True).close()
    assert Trajectory.open(path).positions.shape == (0, 6, 3)
    assert list(path.parent.iterdir()) == [path]


def test_a_file_that_cannot_be_made_leaves_nothing(tmp_path, monkeypatch):
    with pytest.raises(TrajectoryError, match="No such file or directory"):
        TrajectoryWriter(tmp_path / "missing" / "t.h5", make_scene(), TIMES)

    def full(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(h5py.Group, "create_dataset", full)
    with pytest.raises(TrajectoryError, match="No space left"):
        TrajectoryWriter(tmp_path, make_scene(), TIMES)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("overwrite", [False, True])
def test_of_two_runs_started_together_one_gets_the_file(path, monkeypatch, overwrite):
    replace = os.replace

    def late(partial, target):
        with pytest.raises(TrajectoryError, match="h5: this process is writing to it"):
            TrajectoryWriter(path, make_scene(6), TIMES, overwrite=overwrite)
        replace(partial, target)
        with pytest.raises(TrajectoryError, match=r"this process is writing|exists"):
            TrajectoryWriter(path, make_scene(6), TIMES, overwrite=overwrite)

    monkeypatch.setattr(os, "replace", late)
    with TrajectoryWriter(path, make_scene(), TIMES, overwrite=overwrite) as writer:
        write(writer, 0)
        writer.close("completed")
    assert Trajectory.open(path).positions.shape == (1, 4, 3)
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("name", ["a\0b", "a\0b.h5", "x" * 300, "d/" * 3000 + "x.h5"])
def test_names_that_no_file_can_have_are_refused(tmp_path, name):
    for use in (
        Trajectory.open,
        TrajectoryWriter.reopen,
        lambda path: TrajectoryWriter(path, make_scene(), TIMES),
        lambda path: simulate(make_scene(), output=path),
    ):
        with pytest.raises(TrajectoryError, match=r"cannot be|no such trajectory"):
            use(tmp_path / name)


def take_away(path):
    path.unlink()


def replace(path):
    path.with_name("other").write_bytes(b"")
    path.with_name("other").replace(path)


@pytest.mark.parametrize("spoil", [take_away, replace])
def test_a_run_whose_file_is_taken_away_stops_and_returns_what_it_reached(path, spoil):
    def progress(now):
        if now.snapshot == 3:
            spoil(path)

    run = simulate(make_scene(**{"run.snapshots": 5}), output=path, progress=progress)
    assert (run.status, run.cause, run.path) == ("stopped", Cause.ERROR, None)
    assert "was removed or replaced while it was written" in run.reason
    assert len(run.time) == 3


def test_a_file_that_is_cut_short_during_its_run_stays_cut(path):
    def progress(now):
        if now.snapshot == 3:
            os.truncate(path, 3000)

    with pytest.raises(TrajectoryError, match="cut short while it was written"):
        simulate(make_scene(**{"run.snapshots": 5}), output=path, progress=progress)
    with pytest.raises(TrajectoryError, match="cut short"):
        Trajectory.open(path)


def truncate(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def delete_frames(path):
    with h5py.File(path, "r+") as file:
        del file["particles/trajectory/frame"]


def spoil_scene(path):
    with h5py.File(path, "r+") as file:
        file["parameters/scene"][()] = "[chain]\nparticles = 'many'"


def make_foreign(path):
    with h5py.File(path, "w") as file:
        file["h5md"] = 1


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: path.unlink(), "trajectory.h5: there is no such trajectory"),
        (lambda path: path.write_text("time 0 1 2"), "not an HDF5 file"),
        (lambda path: path.write_bytes(b""), "it is empty"),
        (truncate, "cut short"),
        (make_foreign, "not one written by nrchain"),
        (delete_frames, "damaged"),
        (spoil_scene, "scene cannot be read.*chain.particles"),
    ],
)
def test_what_is_no_trajectory_is_refused_with_the_cause(path, spoil, message):
    TrajectoryWriter(path, make_scene(), TIMES).close()
    spoil(path)
    for use in (Trajectory.open, TrajectoryWriter.reopen):
        with pytest.raises(TrajectoryError, match=message) as caught:
            use(path.parent)
        assert str(path.parent) in str(caught.value)


def spoilt(path):
    """A file with each object or attribute missing in turn, and each data set in another shape."""
    whole, names, attributes = path.read_bytes(), [], []
    with h5py.File(path) as file:
        file.visit(names.append)
        for name in names:
            attributes += [(name, key) for key in file[name].attrs]
    for name in names:
        for shape in (None, (2, 7), ()):
            path.write_bytes(whole)
            with h5py.File(path, "r+") as file:
                del file[name]
                if shape is not None:
                    file[name] = np.zeros(shape)
            yield
    for name, key in attributes:
        path.write_bytes(whole)
        with h5py.File(path, "r+") as file:
            del file[name].attrs[key]
        yield


def flipped(path, times, seed=0):
    """Copies of a file with bytes flipped, and some cut short, at random places."""
    whole, rng = path.read_bytes(), np.random.default_rng(seed)
    for number in range(times):
        content = bytearray(whole)
        for place in rng.integers(0, len(whole), rng.choice([1, 2, 8, 64])):
            content[place] ^= int(rng.integers(1, 256))
        path.write_bytes(content[: rng.integers(len(whole))] if number % 8 == 0 else content)
        yield


@pytest.mark.parametrize("times", few_of([80, 200], {80}))
def test_no_damage_is_met_with_any_but_the_documented_error(path, times):
    simulate(make_scene(**{"run.max_steps": 3, "run.snapshots": 5}), output=path)
    whole, messages = path.read_bytes(), []
    for damages in (spoilt(path), flipped(path, times)):
        for _ in damages:
            for use in (Trajectory.open, read_checkpoint, reopen):
                try:
                    use(path)
                except TrajectoryError as error:
                    messages.append(str(error))
        path.write_bytes(whole)
    assert len(messages) > times
    assert all(str(path) in line and "\n" not in line for line in messages)


def read_checkpoint(path):
    Trajectory.open(path).latest_checkpoint()


def reopen(path):
    TrajectoryWriter.reopen(path).close()


def test_a_checkpoint_that_no_run_has_written_is_refused(path):
    simulate(make_scene(**{"run.max_steps": 3, "run.snapshots": 5}), output=path)
    whole = path.read_bytes()
    for name, place, value in (
        ("frame", (slice(None), 1), 0.0),
        ("position", (slice(None), 1, 1), 1e200),
        ("state", (slice(None), 0), 1e3),
        ("state", (slice(None), 1), 4.0),
    ):
        path.write_bytes(whole)
        with h5py.File(path, "r+") as file:
            file[f"nrchain/checkpoints/{name}"][place] = value
        with pytest.raises(TrajectoryError, match="damaged: its last checkpoint"):
            resume(path)


def test_a_missing_path_is_refused(tmp_path):
    with pytest.raises(TrajectoryError, match="no such trajectory"):
        Trajectory.open(tmp_path / "nothing.h5")
    with pytest.raises(TrajectoryError, match="no such trajectory"):
        TrajectoryWriter.reopen(tmp_path / "nothing.h5")


def test_arrays_of_the_wrong_shape_or_not_finite_are_refused(path):
    positions, frames = poses(4, 0)
    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        with pytest.raises(ValueError, match=r"positions: shape \(1, 3\)"):
            writer.write(0, Block.of_one(0.0, positions[0], frames, 0))
        with pytest.raises(ValueError, match=r"frames: shape"):
            writer.write(0, Block.of_one(0.0, positions, frames[0], 0))
        with pytest.raises(ValueError, match="time: not all values are finite"):
            writer.write(0, Block.of_one(np.nan, positions, frames, 0))
        with pytest.raises(ValueError, match=r"'step' is not a counter; the counters are steps"):
            writer.update_counters({"step": 1})
    with pytest.raises(ValueError, match=r"positions: shape"):
        Trajectory(TIMES, np.zeros((5, 3, 3)), np.zeros((5, 4, 3, 3)), make_scene())


def test_how_a_run_ends_is_recorded(path):
    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        writer.close("stopped", "spheres touch at λ = 2", Cause.TOUCH)
    stopped = Trajectory.open(path)
    assert (stopped.reason, stopped.cause) == ("spheres touch at λ = 2", Cause.TOUCH)
    with TrajectoryWriter.reopen(path) as writer:
        assert np.array_equal(writer.times, TIMES)
        running = Trajectory.open(path)
        assert (running.status, running.reason, running.cause) == ("running", "", None)
        writer.close("stopped", "λ" * REASON_BYTES)
    assert Trajectory.open(path).reason == "λ" * (REASON_BYTES // 2)


@pytest.mark.parametrize(
    ("error", "reason", "cause"),
    [
        (KeyboardInterrupt(), "interrupted", Cause.INTERRUPTED),
        (ZeroDivisionError("by 0"), "ZeroDivisionError: by 0", Cause.ERROR),
    ],
)
def test_an_exception_stops_the_run_and_keeps_what_it_has(path, error, reason, cause):
    def run():
        with TrajectoryWriter(path, make_scene(), TIMES) as writer:
            write(writer, 0)
            raise error

    with pytest.raises(type(error)):
        run()
    trajectory = Trajectory.open(path)
    assert (trajectory.status, trajectory.reason) == ("stopped", reason)
    assert trajectory.cause is cause
    assert len(trajectory.time) == 1


@settings(max_examples=20, deadline=None)
@given(count=st.integers(0, 5))
def test_the_latest_checkpoint_is_the_last_written(tmp_path_factory, count):
    path = tmp_path_factory.mktemp("checkpoints") / FILE_NAME
    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        for seed in range(count):
            writer.checkpoint(checkpoint(seed))
        latest = writer.latest_checkpoint()
    for found in (latest, Trajectory.open(path).latest_checkpoint()):
        if count == 0:
            assert found is None
        else:
            wanted = checkpoint(count - 1)
            counters = dict.fromkeys(COUNTERS, 0) | wanted.counters
            assert same(found, Checkpoint(**vars(wanted) | {"counters": counters}))


def test_a_trajectory_in_memory_has_no_checkpoint():
    frames = np.broadcast_to(np.eye(3), (5, 4, 3, 3))
    trajectory = Trajectory(TIMES, np.zeros((5, 4, 3)), frames, make_scene())
    assert trajectory.latest_checkpoint() is None
    assert repr(trajectory) == "<Trajectory 'a test': 4 spheres, 5 snapshots to t = 8, completed>"
    untitled = Trajectory(TIMES, np.zeros((5, 4, 3)), frames, make_scene(title=""))
    assert repr(untitled) == "<Trajectory: 4 spheres, 5 snapshots to t = 8, completed>"


def uniform(time, particles):
    """Poses whose every number is the time, so that a mixture of two snapshots shows."""
    return np.full((particles, 3), time), np.full((particles, 3, 3), time)


def assert_whole(path):
    """Every snapshot and the checkpoint of a file consist of one state each."""
    trajectory = Trajectory.open(path)
    for time, positions, frames in zip(
        trajectory.time, trajectory.positions, trajectory.frames, strict=True
    ):
        assert np.all(positions == time)
        assert np.all(frames == time)
    latest = trajectory.latest_checkpoint()
    if latest is not None:
        assert np.all(latest.positions == latest.time)
        assert np.all(latest.frames == latest.time)
    return trajectory


class Killed(io.RawIOBase):
    """A file that keeps what a kill before and after each of its writes would leave."""

    def __init__(self, path):
        self.file, self.left = open(path, "r+b", buffering=0), []  # noqa: SIM115

    def note(self):
        self.left.append(os.pread(self.file.fileno(), os.fstat(self.file.fileno()).st_size, 0))

    def readinto(self, buffer):
        return self.file.readinto(buffer)

    def seek(self, place, whence=0):
        return self.file.seek(place, whence)

    def tell(self):
        return self.file.tell()

    def truncate(self, size=None):
        size = self.file.truncate(size)
        self.note()
        return size

    def write(self, data):
        written = self.file.write(data)
        self.note()
        return written

    def flush(self):
        self.file.flush()

    def close(self):
        super().close()
        self.file.close()


def test_the_disk_holds_a_whole_state_after_every_write(tmp_path, path, monkeypatch):
    """What kills between any two writes leave, to us and to plain h5py."""
    particles, times, written = 700, (0.0, 1.0, 2.0, 3.0, 2.5, 3.5), []
    kept = None

    def open_kept(where, mode):
        nonlocal kept
        if mode != "r+":
            return open_file(where, mode)
        kept = Killed(where)
        return h5py.File(kept, "r+")

    monkeypatch.setattr(trajectory_writer, "open_file", open_kept)
    with TrajectoryWriter(path, make_scene(particles), TIMES) as writer:
        for place, time in zip((0, 1, 2, 3, 2, 3), times, strict=True):
            writer.write(place, Block.of_one(time, *uniform(time, particles), step=0))
            writer.checkpoint(Checkpoint(time, *uniform(time, particles), 0, 0.0, np.zeros(3)))
            writer.update_counters({"steps": place})
            written.append((len(kept.left), time))
    kept.close()
    whole = [[], [0.0], [0.0, 1.0], [0.0, 1.0, 2.0], [0.0, 1.0, 2.0, 3.0], [0.0, 1.0]]
    whole += [[0.0, 1.0, 2.5], [0.0, 1.0, 2.5, 3.5]]
    state = 0
    for number, content in enumerate(kept.left):
        (tmp_path / "copy.h5").write_bytes(content)
        trajectory = assert_whole(tmp_path / "copy.h5")
        while trajectory.time.tolist() != whole[state]:
            state += 1
        done = [time for count, time in written if count <= number]
        assert state >= len(done)
        if done:
            assert trajectory.latest_checkpoint().time in (done[-1], *times[len(done) :][:1])
        with h5py.File(tmp_path / "copy.h5") as file:
            group = file["particles/trajectory"]
            sizes = {group[f"{k}/{n}"].shape[0] for k in ("position", "frame") for n in group[k]}
        # plain readers find a series or two that are ahead
        assert sizes <= {len(whole[state - 1]), len(whole[state]), len(whole[state]) + 1}
    assert state == len(whole) - 1
    assert number > 60


def block_of(indices, time=TIMES):
    """Snapshots in a row."""
    found = zip(*(poses(4, index) for index in indices), strict=True)
    positions, frames = map(np.array, found)
    return Block(time[list(indices)], positions, frames, 10 * np.array(indices))


def test_snapshots_written_at_once_are_those_written_one_by_one(tmp_path):
    single, several = tmp_path / "single.h5", tmp_path / "several.h5"
    with TrajectoryWriter(single, make_scene(), TIMES) as writer:
        for index in range(4):
            write(writer, index)
    with TrajectoryWriter(several, make_scene(), TIMES) as writer:
        writer.write(0, block_of([0]))
        writer.write(1, block_of([1, 2, 3]))
    first, second = (Trajectory.open(path) for path in (single, several))
    assert np.array_equal(first.time, second.time)
    assert np.array_equal(first.positions, second.positions)
    assert np.array_equal(first.frames, second.frames)
    with h5py.File(single) as one, h5py.File(several) as other:
        steps = "particles/trajectory/position/step"
        assert one[steps][()].tolist() == other[steps][()].tolist() == [0, 10, 20, 30]


@pytest.mark.parametrize(("place", "kept"), [(1, 4), (3, 3)])
def test_a_block_replaces_snapshots_from_the_first_that_differs_on(path, place, kept):
    """Those that agree stay where they are, also later ones if all of the block agree."""
    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        writer.write(0, block_of([0, 1, 2, 3]))
        again = block_of([1, 2]) if place == 1 else block_of([1, 2, 3, 4])
        if place == 3:
            again.positions[2, 1, 0] += 1e-12
        writer.write(1, again)
    found = Trajectory.open(path)
    assert len(found.time) == (4 if place == 1 else 5)
    assert np.array_equal(found.positions[:kept], block_of(range(kept)).positions)
    if place == 3:
        assert np.array_equal(found.positions[3:], again.positions[2:])


def test_the_two_checkpoints_take_turns(path):
    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        for seed in range(1, 6):
            writer.checkpoint(checkpoint(seed))
            with h5py.File(path, locking=False) as file:
                times = file["nrchain/checkpoints/state"][:, 0].tolist()
            before = checkpoint(seed - 1).time if seed > 1 else np.nan
            kept = [before, checkpoint(seed).time][:: 1 if seed % 2 == 0 else -1]
            assert times == pytest.approx(kept, nan_ok=True)


def test_every_mark_is_written_between_two_flushes(path, monkeypatch):
    events = []
    flush = h5py.File.flush

    def logging_flush(file):
        events.append("flush")
        flush(file)

    def logging(write):
        def log_and_write(dataset, *what):
            events.append(dataset.name.split("/")[-1])
            write(dataset, *what)

        return log_and_write

    with TrajectoryWriter(path, make_scene(), TIMES) as writer:
        size = path.stat().st_size
        monkeypatch.setattr(h5py.File, "flush", logging_flush)
        for place, name in ((h5py.Dataset, "__setitem__"), (rows, "put")):
            monkeypatch.setattr(place, name, logging(getattr(place, name)))
        for index in (0, 1, 1):
            write(writer, index)
            writer.checkpoint(checkpoint(index))
        writer.close("completed")
    assert path.stat().st_size == size
    marks = [k for k, event in enumerate(events) if event in ("sequence", "status")]
    assert len(marks) == 3 + 1
    assert all(events[k - 1] == events[k + 1] == "flush" for k in marks)
    ends = [events[k : k + 3] for k, event in enumerate(events) if event == "time"]
    assert ends == [["time", "finished", "flush"]] * 2


def test_a_file_takes_little_more_than_its_numbers(path):
    """Also where snapshots are many and short: they do not each have a chunk of their own."""
    snapshots, particles = 4000, 2
    with TrajectoryWriter(path, make_scene(particles), np.linspace(0.0, 8.0, snapshots)):
        pass
    numbers = 8 * snapshots * (12 * particles + 3)
    assert numbers < path.stat().st_size < 1.1 * numbers + 2**17


def test_a_snapshot_larger_than_a_chunk_should_be_has_one_of_its_own(path, monkeypatch):
    monkeypatch.setattr(new_file, "CHUNK_BYTES", 100)
    with TrajectoryWriter(path, make_scene(9), TIMES) as writer:
        for index in range(len(TIMES)):
            write(writer, index)
        writer.close("completed")
    found = Trajectory.open(path)
    assert np.array_equal(found.positions, [poses(9, index)[0] for index in range(len(TIMES))])


CHILD = """
import sys
import numpy as np
from nrchain.trajectory.block import Block
from nrchain.trajectory.checkpoint import Checkpoint
from nrchain.scene.loading import load_scene
from nrchain.trajectory.writer import TrajectoryWriter

scene = load_scene({"chain.particles": 300, "run.end": 1.0})
frames = np.empty((300, 3, 3))
with TrajectoryWriter(sys.argv[1], scene, np.arange(10000.0)) as writer:
    for step in range(10000):
        time = float(step)
        positions, frames[:] = np.full((300, 3), time), time
        writer.write(step, Block.of_one(time, positions, frames, step))
        writer.checkpoint(Checkpoint(time, positions, frames, 0, 0.0, np.zeros(3)))
        print(step, flush=True)
"""


@pytest.mark.parametrize("delay", few_of([0.0, 0.011, 0.037, 0.103], {0.037}))
def test_a_killed_run_keeps_every_finished_snapshot(path, delay):
    child = subprocess.Popen([sys.executable, "-c", CHILD, path], stdout=subprocess.PIPE, text=True)
    try:
        first = child.stdout.readline()
        assert first == "0\n"
        clock.sleep(delay)
        # A run can be read while it goes on, but not be written or replaced by another process.
        Trajectory.open(path)
        busy = f"process {child.pid} is writing to it"
        with pytest.raises(TrajectoryError, match=busy):
            TrajectoryWriter.reopen(path)
        with pytest.raises(TrajectoryError, match=busy):
            TrajectoryWriter(path, make_scene(), TIMES, overwrite=True)
    finally:
        child.send_signal(signal.SIGKILL)
        reported = int((first + child.communicate()[0]).split()[-1])
    trajectory = assert_whole(path)
    assert trajectory.status == "running"
    # At most the snapshot under way is beyond what was reported as written.
    assert trajectory.time.tolist() == list(range(len(trajectory.time)))
    assert reported + 1 <= len(trajectory.time) <= reported + 2
    assert trajectory.latest_checkpoint().time >= reported
    with TrajectoryWriter.reopen(path) as writer:
        writer.write(0, Block.of_one(0.5, *uniform(0.5, 300), step=1))
        writer.close("completed")
    assert assert_whole(path).status == "completed"
    assert list(path.parent.iterdir()) == [path]


def test_sizes_beyond_what_hdf5_counts_are_refused_in_one_line(tmp_path):
    times = np.broadcast_to(0.0, (2**59,))
    with pytest.raises(SceneError, match=r"run.snapshots = 576460752303423488: needs") as caught:
        TrajectoryWriter(tmp_path / "huge.h5", make_scene(), times)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []
