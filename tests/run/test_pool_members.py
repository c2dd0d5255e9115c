"""simulate_many by an executor: the same members, from processes that may also die."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import time
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneError
from nrchain.run import pool_members
from nrchain.run.pool_members import Parcel, Ran, run_member

SHORT = {"chain.particles": 6, "run.end": 2.0, "run.snapshots": 5}


def scene(**more):
    return nrchain.load_scene("buckling", **(SHORT | more))


def overlapping():
    """A scene that can be read, and whose start is refused."""
    here = [[0.1 * sphere, 0.0, 0.0] for sphere in range(6)]
    return scene(start={"shape": "given", "positions": here, "amplitude": None})


def test_processes_give_the_runs_failures_warnings_and_files_of_threads(tmp_path):
    straight = nrchain.load_scene("buckling", **{"start.shape": "straight", "run.end": 2e3})
    scenes = [scene(**{"slip.2s": 50.0}), overlapping(), straight, scene(**{"slip.2s": 60.0})]
    with (
        ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool,
        pytest.warns(nrchain.SceneWarning) as caught,
    ):
        found = list(nrchain.simulate_many(scenes, tmp_path / "runs", 2, executor=pool))
    assert all(str(one.message).startswith("scenes[2]: ") for one in caught)
    members = {member.index: member for member in found}
    assert sorted(members) == [0, 1, 2, 3]
    assert isinstance(members[1].error, SceneError)
    assert members[1].error.key == "start.positions"
    for index in (0, 3):
        wanted, run = nrchain.simulate(scenes[index]), members[index].result()
        assert members[index].scene == run.scene == scenes[index]
        assert run.path == tmp_path / "runs" / f"{index:04}.h5"
        kept = nrchain.Trajectory.open(run.path)
        assert np.array_equal(kept.positions, run.positions)
        # a process that compiles its kernels rounds differently from one that loads them
        assert np.allclose(run.positions, wanted.positions, rtol=0.0, atol=1e-7)


def test_files_are_where_the_caller_was_whatever_the_folder_of_a_worker(tmp_path, monkeypatch):
    class Elsewhere(Counting):
        def submit(self, task, *arguments):
            os.chdir(tmp_path / "worker")
            return super().submit(task, *arguments)

    for name in ("caller", "worker"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / "caller")
    executor = Elsewhere(1)
    (member,) = nrchain.simulate_many([scene()], "runs", executor=executor)
    assert member.result().path == tmp_path / "caller" / "runs" / "0000.h5"
    assert member.result().path.is_file()
    executor.threads.shutdown()


class Unreadable:
    """What pickle can write and not read, whatever library changes how errors are pickled."""

    def __repr__(self):
        return "unreadable"

    def __reduce__(self):
        return int, ("no number",)


def test_an_error_that_cannot_be_pickled_keeps_its_text_and_a_scene_is_read_in_its_run():
    ran = pickle.loads(pickle.dumps(Ran(None, OSError(Unreadable()), ("warned",))))
    assert isinstance(ran.error, RuntimeError)
    assert str(ran.error) == "OSError: unreadable"
    assert ran.warnings == ("warned",)
    refused = pickle.loads(pickle.dumps(Ran(None, SceneError("run.end", 0.0, "must be more"))))
    assert isinstance(refused.error, SceneError)
    assert pickle.loads(pickle.dumps(Parcel(scene()))).open() == scene()
    # a scene with a class that its process does not have
    found = run_member(Parcel(b"cnowhere\nNothing\n."), None, False, True, {}, time.time())
    assert isinstance(found.error, ModuleNotFoundError)


def test_a_process_that_a_signal_reached_begins_only_what_comes_later(monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt("SIGINT")

    def run(handed_over):
        return run_member(Parcel(scene()), None, False, True, {}, handed_over)

    monkeypatch.setattr(pool_members, "_interrupted", -np.inf)
    before = time.time()
    with monkeypatch.context() as patch:
        patch.setattr(pool_members, "simulate_in_memory", interrupted)
        assert isinstance(run(before).error, KeyboardInterrupt)
    assert isinstance(run(before).error, KeyboardInterrupt)
    later = run(time.time() + 1.0)
    assert later.error is None
    assert later.trajectory.status == "completed"


class Counting(Executor):
    """Runs tasks in threads, and keeps what it was given."""

    def __init__(self, threads=2):
        self.threads, self.futures = ThreadPoolExecutor(threads), []

    def submit(self, task, *arguments):
        self.futures.append(self.threads.submit(task, *arguments))
        return self.futures[-1]


@pytest.mark.parametrize("workers", [1, 2])
def test_an_executor_has_at_most_two_runs_for_each_worker(workers):
    executor = Counting()
    members = nrchain.simulate_many([scene()] * 9, None, workers, executor=executor)
    for taken, _ in enumerate(members):
        assert len(executor.futures) <= min(taken + 2 * workers, 9)
    assert len(executor.futures) == 9
    executor.threads.shutdown()


class Dying(Counting):
    """Its workers die after the first task."""

    def submit(self, task, *arguments):
        if self.futures:
            raise BrokenExecutor("a worker died")
        return super().submit(task, *arguments)


def test_a_pool_whose_workers_died_gives_an_error_for_each_run_that_is_left():
    executor = Dying()
    members = list(nrchain.simulate_many([scene()] * 4, executor=executor))
    errors = {member.index: member.error for member in members}
    assert errors.pop(0) is None
    assert sorted(errors) == [1, 2, 3]
    assert all(isinstance(error, BrokenExecutor) for error in errors.values())
    executor.threads.shutdown()


def test_leaving_early_cancels_the_runs_that_have_not_begun():
    executor = Counting(threads=1)
    members = nrchain.simulate_many([scene()] * 20, workers=5, executor=executor)
    next(members)
    members.close()
    executor.threads.shutdown()
    assert len(executor.futures) == 10
    # some may have run meanwhile, and one may be under way
    assert all(future.done() for future in executor.futures)
    assert any(future.cancelled() for future in executor.futures)


@pytest.mark.parametrize("executor", [4, "processes", ProcessPoolExecutor])
def test_what_is_no_executor_is_refused(executor):
    with pytest.raises(SceneError, match="must be an executor") as caught:
        nrchain.simulate_many([scene()], executor=executor)
    assert caught.value.key == "executor"
