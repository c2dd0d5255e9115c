"""Processes, and a cluster of Dask on this machine: workers are killed in the middle of a sweep."""

import multiprocessing
import os
import signal
import time
import warnings
from contextlib import contextmanager

import pytest
from support.command_line import assert_refused, call
from support.one_process import in_one_process

import nrchain
from nrchain.errors import NrchainError
from nrchain.sweeps.executors import Workers, cluster

distributed = pytest.importorskip("distributed")


CHANGES = {"chain.particles": 5, "run.end": 2, "run.snapshots": 6, "elasticity.ratio": 1e8}


POINTS = 21


OBSERVE = ["end.size", "end.energy"]


def grid(count):
    return {"slip.2s": f"-100:100:{count}"}


def keep_kernels():
    """Run two points here, so that all processes find their kernels on disk."""
    nrchain.sweep(nrchain.load_scene("buckling", **CHANGES), grid(2), observe=OBSERVE, workers=1)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The sweep in one process, which like all others finds its kernels on disk."""
    file = tmp_path_factory.mktemp("alone") / "sweep"
    keep_kernels()
    return in_one_process(CHANGES, grid(POINTS), OBSERVE, file)


@contextmanager
def local_cluster():
    """Two workers, each a process with one thread, and no page of diagnostics."""
    with warnings.catch_warnings():
        # of the libraries of Dask
        warnings.simplefilter("ignore")
        with distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50
        ) as local:
            yield local


def observables(seconds):
    """A size and, so that the sweep lasts, a pause; by value, as workers do not know this file."""

    def paused(run):
        time.sleep(seconds)
        return os.getpid()

    return {"end.size": "end.size", "end.energy": "end.energy", "process": paused}


def sweep_with_a_death(local, count, folder, seconds):
    """The sweep of so many points, and the worker that is killed when a third of them are done."""
    killed = []

    def kill(progress):
        if progress.done == count // 3 and not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    with distributed.Client(local) as client:
        found = nrchain.sweep(
            nrchain.load_scene("buckling", **CHANGES),
            grid(count),
            executor=client,
            observe=observables(seconds),
            output=folder,
            progress=kill,
        )
    return found, killed[0]


def assert_equal(found, alone, count):
    """Bit for bit, but for the process of each run."""
    assert len(found) == len(alone) == count
    assert found.failed == ()
    for point, own in zip(found.points, alone.points, strict=True):
        assert point.name == own.name
        assert point.counters == own.counters
        for name in OBSERVE:
            assert point.observables[name] == own.observables[name]


def test_points_of_a_worker_that_is_killed_go_to_another(tmp_path, alone):
    with local_cluster() as local:
        found, killed = sweep_with_a_death(local, POINTS, tmp_path / "s", 0.05)
        processes = set(found.column("process"))
        assert os.getpid() not in processes
        assert processes - {killed}
        # the command reaches the same cluster by its address, and finds all points there
        changes = [word for key, value in CHANGES.items() for word in ("--set", f"{key}={value}")]
        again = call(
            *("sweep", "buckling", *changes, "--grid", f"slip.2s=-100:100:{POINTS}"),
            *("--observe", ",".join(OBSERVE), "-o", tmp_path / "s"),
            *("--cluster", local.scheduler_address),
        )
        assert f"points      {POINTS} points\n" in again.stdout, again.stderr
    assert_equal(found, alone, POINTS)


@pytest.mark.slow
def test_processes_that_die_are_replaced(monkeypatch, alone):
    """Both processes are killed at the first result, with 20 points to go."""
    killed, restarts, restart = [], [], Workers.restart

    def kill(progress):
        if progress.done and not killed:
            killed.extend(child.pid for child in multiprocessing.active_children())
            for process in killed:
                os.kill(process, signal.SIGKILL)

    monkeypatch.setattr(Workers, "restart", lambda own: restarts.append(1) or restart(own))
    found = nrchain.sweep(
        nrchain.load_scene("buckling", **CHANGES),
        grid(POINTS),
        observe=OBSERVE,
        processes=2,
        progress=kill,
    )
    assert restarts
    assert found == alone


@pytest.mark.slow
def test_200_points_are_those_of_one_process(tmp_path):
    keep_kernels()
    with local_cluster() as local:
        found, killed = sweep_with_a_death(local, 200, tmp_path / "s", 0.02)
    assert_equal(found, in_one_process(CHANGES, grid(200), OBSERVE, tmp_path / "alone"), 200)
    # the worker that was started in its place took points too
    assert len(set(found.column("process")) - {killed}) >= 2


def test_a_scheduler_that_is_not_there_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("nrchain.sweeps.executors.PATIENCE", 0.5)
    with pytest.raises(NrchainError, match="no scheduler answers"), cluster("tcp://127.0.0.1:9"):
        pass
    missing = tmp_path / "none.json"
    refused = call("sweep", "buckling", "--grid", "slip.2s=1", "--cluster", missing)
    assert_refused(refused, "none.json", "no such file")
