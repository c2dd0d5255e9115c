"""A sweep on a cluster of Dask on this machine: one of its two workers is killed in the middle."""

import os
import signal
import time
import warnings
from contextlib import contextmanager

import pytest
from support.command_line import assert_refused, call

import nrchain
from nrchain.errors import NrchainError
from nrchain.sweeps.executors import cluster

distributed = pytest.importorskip("distributed")


def scene():
    short = {"chain.particles": 5, "run.end": 2.0, "run.snapshots": 6, "elasticity.ratio": 1e8}
    return nrchain.load_scene("buckling", **short)


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
            scene(),
            {"slip.2s": f"-100:100:{count}"},
            executor=client,
            observe=observables(seconds),
            output=folder,
            progress=kill,
        )
    return found, killed[0]


def assert_equal_to_one_process(found, count):
    alone = nrchain.sweep(
        scene(), {"slip.2s": f"-100:100:{count}"}, observe=["end.size", "end.energy"], workers=1
    )
    assert len(found) == count
    assert found.failed == ()
    for name in ("end.size", "end.energy"):
        assert found.column(name) == alone.column(name)
    for point, own in zip(found.points, alone.points, strict=True):
        assert point.counters == own.counters


def test_points_of_a_worker_that_is_killed_go_to_another(tmp_path):
    with local_cluster() as local:
        found, killed = sweep_with_a_death(local, 9, tmp_path / "s", 0.1)
        assert_equal_to_one_process(found, 9)
        processes = set(found.column("process"))
        assert os.getpid() not in processes
        assert len(processes - {killed}) >= 1
        # the command reaches the same cluster by its address, and finds all points there
        grid = ("--grid", "slip.2s=-100:100:9", "--observe", "end.size")
        changes = {"chain.particles": 5, "run.end": 2, "run.snapshots": 6, "elasticity.ratio": 1e8}
        words = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
        again = call(
            *("sweep", "buckling", *words, *grid, "-o", tmp_path / "s"),
            *("--cluster", local.scheduler_address),
        )
        assert "points      9 points\n" in again.stdout, again.stderr


@pytest.mark.slow
def test_200_points_are_those_of_one_process(tmp_path):
    with local_cluster() as local:
        found, killed = sweep_with_a_death(local, 200, tmp_path / "s", 0.02)
    assert_equal_to_one_process(found, 200)
    # the worker that was started in its place took points too
    assert len(set(found.column("process")) - {killed}) >= 2


def test_a_scheduler_that_is_not_there_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("nrchain.sweeps.executors.PATIENCE", 0.5)
    with pytest.raises(NrchainError, match="no scheduler answers"), cluster("tcp://127.0.0.1:9"):
        pass
    missing = tmp_path / "none.json"
    refused = call("sweep", "buckling", "--grid", "slip.2s=1", "--cluster", missing)
    assert_refused(refused, "none.json", "no such file")
