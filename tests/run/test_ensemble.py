"""simulate_many: the results of simulate, as they finish, and an end in order at any time."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from queue import Queue

import numpy as np
import pytest
from support.selection import few_of

import nrchain
from nrchain.errors import SceneError, TrajectoryError
from nrchain.outcome import Cause
from nrchain.run.interruption import GLANCE, Interruption
from nrchain.run.members import wait_for

SHORT = {"chain.particles": 6, "run.end": 2.0, "run.snapshots": 5}
ENDLESS = {
    "chain": {"particles": 3},
    "flow": {"gradient": [[0.0, 0.0, 0.02], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]},
    "friction": "pairwise",
    "start": {"shape": "random"},
    "run": {"end": 1e9, "snapshots": 3},
}
"""A chain that tumbles in a shear flow: no machine gets to its end."""

PATIENCE = 300.0
"""Seconds for what takes one: a busy machine may compile kernels meanwhile."""


def scene(name="buckling", **more):
    return nrchain.load_scene(name, **(SHORT | more))


def overlapping():
    """A scene that can be read, and whose start is refused."""
    here = [[0.1 * sphere, 0.0, 0.0] for sphere in range(6)]
    return scene(start={"shape": "given", "positions": here, "amplitude": None})


def within_patience(task):
    """What a task returns; an error if it takes longer than :data:`PATIENCE`."""
    ended = []
    thread = threading.Thread(target=lambda: ended.append(task()), daemon=True)
    thread.start()
    thread.join(PATIENCE)
    assert not thread.is_alive(), "the task does not end"
    assert ended, "the task raised an error"
    return ended[0]


@pytest.mark.parametrize("workers", [None, 1, 2, 5])
def test_each_run_has_the_bits_of_simulate(workers):
    scenes = [
        scene(**{"slip.2s": 50.0 + index, "start.seed": index, "run.integrator": integrator})
        for index, integrator in enumerate(["cvode", "radau", "cvode", "scipy-bdf", "cvode"])
    ]
    alone = [nrchain.simulate(one) for one in scenes]
    members = sorted(nrchain.simulate_many(scenes, workers=workers), key=lambda one: one.index)
    assert [member.index for member in members] == list(range(5))
    for member, wanted in zip(members, alone, strict=True):
        assert member.error is None
        assert member.scene == member.result().scene == wanted.scene
        assert np.array_equal(member.result().positions, wanted.positions)
        assert np.array_equal(member.result().frames, wanted.frames)


def test_results_come_as_they_finish():
    def first():
        return next(nrchain.simulate_many([ENDLESS, scene()], workers=2)).index

    assert within_patience(first) == 1


def test_a_failure_does_not_end_the_others():
    members = list(nrchain.simulate_many([scene(), overlapping(), scene()], workers=2))
    failed = {member.index: member.error for member in members if member.error is not None}
    assert list(failed) == [1]
    assert failed[1].key == "start.positions"
    for member in members:
        if member.index == 1:
            assert member.trajectory is None
            with pytest.raises(SceneError, match="overlap"):
                member.result()
        else:
            assert member.result().status == "completed"


def test_an_error_of_an_effect_is_handed_on(spring, monkeypatch):
    broken = scene(**{"spring.stiffness": 1.0})

    def fail(*_):
        raise RuntimeError("no such spring")

    monkeypatch.setattr(spring, "add_wrenches", fail)
    members = list(nrchain.simulate_many([broken, scene()], workers=1))
    assert str(members[0].error) == "no such spring"
    assert members[1].result().status == "completed"


def test_a_run_that_stops_is_no_failure():
    (member,) = nrchain.simulate_many([scene(**{"run.max_steps": 2})])
    assert member.error is None
    assert member.result().cause is Cause.BUDGET


@pytest.mark.parametrize(
    ("source", "key", "value"),
    [
        ({"chain": {"particles": 6, "spacing": -1.0}}, "scenes[2].chain.spacing", -1.0),
        ("no-such-scene", "scenes[2]", "no-such-scene"),
        (7, "scenes[2]", 7),
    ],
)
def test_a_scene_that_cannot_be_read_is_named_before_any_run(source, key, value, tmp_path):
    with pytest.raises(SceneError) as caught:
        nrchain.simulate_many(["buckling", scene(), source], tmp_path / "runs")
    assert (caught.value.key, caught.value.value) == (key, value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("scenes", ["buckling", scene(), {"chain": {"particles": 6}}, 3])
def test_one_scene_is_not_several(scenes):
    with pytest.raises(SceneError, match="must be several scenes"):
        nrchain.simulate_many(scenes)


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "2"])
def test_workers_are_a_positive_whole_number(workers):
    with pytest.raises(SceneError) as caught:
        nrchain.simulate_many([], workers=workers)
    assert (caught.value.key, caught.value.value) == ("workers", workers)


def test_no_scenes_have_no_results():
    assert list(nrchain.simulate_many(iter(()))) == []


def test_each_run_has_a_file_and_names_sort_by_index(tmp_path):
    scenes = [scene(**{"slip.2s": 10.0 + index}) for index in range(11)]
    members = list(nrchain.simulate_many(scenes, tmp_path / "new" / "runs", workers=2))
    files = sorted((tmp_path / "new" / "runs").iterdir())
    assert len(files) == 11
    for file, wanted in zip(files, scenes, strict=True):
        assert nrchain.Trajectory.open(file).scene == wanted
    for member in members:
        assert member.result().path == files[member.index]
        kept = nrchain.Trajectory.open(files[member.index])
        assert np.array_equal(kept.positions, member.result().positions)


def test_a_file_that_exists_is_replaced_only_when_asked(tmp_path):
    kept = tmp_path / "0001.h5"
    nrchain.simulate(scene(), output=kept)
    before = kept.read_bytes()
    with pytest.raises(TrajectoryError, match=r"0001\.h5: exists"):
        nrchain.simulate_many([scene(), scene()], tmp_path)
    assert kept.read_bytes() == before
    assert list(tmp_path.iterdir()) == [kept]
    members = nrchain.simulate_many([scene(), scene(**{"slip.2s": 7.0})], tmp_path, overwrite=True)
    assert all(member.result().status == "completed" for member in members)
    assert nrchain.Trajectory.open(kept).scene.slip.modes["2s"].strength == 7.0


def test_an_output_that_is_the_name_of_a_file_is_refused(tmp_path):
    with pytest.raises(TrajectoryError, match="must be a folder"):
        nrchain.simulate_many([scene()], tmp_path / "all.h5")


def test_runs_are_not_far_ahead_of_the_results_taken(tmp_path):
    members = nrchain.simulate_many([scene()] * 20, tmp_path, workers=1)
    for taken in (1, 2):
        next(members)
        time.sleep(0.5)
        assert len(list(tmp_path.glob("*.h5"))) <= taken + 2
    assert len(list(members)) == 18


def assert_stopped_in_order(folder):
    kept = [nrchain.Trajectory.open(file) for file in sorted(folder.glob("*.h5"))]
    assert len(kept) > 1
    assert kept[0].status == "completed"
    assert all(one.cause is Cause.INTERRUPTED for one in kept[1:])
    assert list(folder.glob("*.lock")) == []


def leave_by_break(members):
    for _ in members:
        break


def fail_at_first(members):
    for _ in members:
        raise KeyError


def leave_by_error(members):
    with pytest.raises(KeyError):
        fail_at_first(members)


def leave_by_close(members):
    next(members)
    members.close()


@pytest.mark.parametrize(
    "leave", few_of([leave_by_break, leave_by_error, leave_by_close], {leave_by_break})
)
def test_leaving_early_stops_the_runs_and_closes_their_files(leave, tmp_path):
    scenes = [scene(), ENDLESS, ENDLESS, ENDLESS]

    def early():
        before = set(threading.enumerate())
        leave(nrchain.simulate_many(scenes, tmp_path, workers=2))
        return set(threading.enumerate()) - before

    assert within_patience(early) == set()
    assert_stopped_in_order(tmp_path)


def test_a_run_left_early_resumes_to_the_bits_of_a_whole_one(tmp_path):
    long = nrchain.load_scene(ENDLESS, **{"run.end": 3000.0})
    whole = nrchain.simulate(long)
    members = nrchain.simulate_many([scene(), long], tmp_path, workers=2)
    next(members)
    members.close()
    done = nrchain.resume(tmp_path / "0001.h5")
    assert done.status == "completed"
    assert np.array_equal(done.positions, whole.positions)


def test_warnings_reach_the_caller_with_the_index():
    straight = nrchain.load_scene("buckling", **{"start.shape": "straight", "run.end": 2e3})
    with pytest.warns(nrchain.SceneWarning) as caught:
        list(nrchain.simulate_many([scene(), straight, scene()], workers=2))
    assert all(str(one.message).startswith("scenes[1]: ") for one in caught)
    assert any("straight" in str(one.message) for one in caught)
    assert {one.filename for one in caught} == {__file__}


def test_members_treat_floating_point_errors_as_the_caller_does(spring, monkeypatch):
    seen = []
    init = spring.__init__

    def look(self, scene):
        seen.append(np.geterr())
        init(self, scene)

    monkeypatch.setattr(spring, "__init__", look)
    with np.errstate(under="raise", divide="ignore"):
        wanted = np.geterr()
        list(nrchain.simulate_many([scene(**{"spring.stiffness": 1.0})]))
    assert seen
    assert all(found == wanted for found in seen)


def test_a_signal_that_is_handled_late_is_not_lost(monkeypatch):
    """The main thread may get the lock of the interpreter only after its wait has run out."""
    note = Interruption.note

    def late(self, number, frame):
        note(self, number, frame)
        time.sleep(2.0 * GLANCE)

    monkeypatch.setattr(Interruption, "note", late)
    queue = Queue()
    arrives = threading.Timer(0.5 * GLANCE, os.kill, (os.getpid(), signal.SIGINT))
    rescue = threading.Timer(20.0, queue.put, (None,))
    for timer in (arrives, rescue):
        timer.start()
    try:
        with pytest.raises(KeyboardInterrupt, match="SIGINT"):
            wait_for(queue)
        assert rescue.is_alive()
    finally:
        rescue.cancel()


PROGRAM = """
import sys
import nrchain
scene = {endless}
short = nrchain.load_scene("passive", **{{"run.end": 1.0, "run.snapshots": 2}})
members = nrchain.simulate_many([short, scene, scene, scene], sys.argv[1], workers=2)
print(next(members).index, flush=True)
{more}
"""


def program(folder, more):
    text = PROGRAM.format(endless=ENDLESS, more=more)
    return subprocess.Popen(
        [sys.executable, "-c", text, folder], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


@pytest.mark.parametrize("number", few_of([signal.SIGINT, signal.SIGTERM], {signal.SIGTERM}))
def test_a_signal_stops_the_runs_and_raises(number, tmp_path):
    running = program(tmp_path, "next(members)")
    with running:
        try:
            assert running.stdout.readline() == b"0\n"
            time.sleep(1.0)
            running.send_signal(number)
            _, errors = running.communicate(timeout=PATIENCE)
        finally:
            running.kill()
    assert errors.splitlines()[-1].startswith(b"KeyboardInterrupt")
    assert_stopped_in_order(tmp_path)


def test_a_program_that_ends_does_not_wait_for_its_runs(tmp_path):
    running = program(tmp_path, "import time; time.sleep(1.0)")
    with running:
        try:
            output, errors = running.communicate(timeout=PATIENCE)
        finally:
            running.kill()
    assert (output, errors, running.returncode) == (b"0\n", b"", 0)
    assert_stopped_in_order(tmp_path)
