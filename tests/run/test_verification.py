"""run.verify: the estimate is the error, and the run that it is made for stays as it is."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time

import h5py
import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneError
from nrchain.outcome import Cause
from nrchain.run import second_run

TUMBLING = {
    "chain": {"particles": 3, "radius": 1.25},
    "flow": {"gradient": [[0.0, 0.0, 0.02], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]},
    "friction": "pairwise",
    "start": {"shape": "random"},
    "run": {"end": 1e9, "snapshots": 3},
}
"""A chain that tumbles in a shear flow: no machine gets to its end."""

SCENES = {
    "buckling": {"chain.particles": 8, "run.end": 300.0},
    "helix-left": {"chain.particles": 8, "run.end": 30.0},
    "wave": {"chain.particles": 8, "run.end": 30.0},
}


def scene(name, tolerance, **more):
    tolerances = {"run.rtol": tolerance, "run.atol": tolerance, "run.snapshots": 6}
    return nrchain.load_scene(name, **(SCENES[name] | tolerances | more))


def verified(given):
    return nrchain.load_scene(given, **{"run.verify": True})


def errors(run, reference):
    """max |r − r′| and max ∠(frame, frame′) at each snapshot; sin(α/2) = ‖F − F′‖ / √8."""
    apart = np.linalg.norm(run.positions - reference.positions, axis=-1).max(axis=1)
    chord = np.linalg.norm(run.frames - reference.frames, axis=(2, 3)).max(axis=1)
    return apart, 2.0 * np.arcsin(chord / np.sqrt(8.0))


@pytest.mark.parametrize(
    ("integrator", "other", "tight"), [("cvode", "radau", 1e-10), ("radau", "cvode", 1e-12)]
)
@pytest.mark.parametrize("name", SCENES)
def test_the_estimate_is_within_a_factor_of_three_of_the_error(name, integrator, other, tight):
    mine = scene(name, 1e-6, **{"run.integrator": integrator})
    run = nrchain.simulate(verified(mine))
    reference = nrchain.simulate(scene(name, tight, **{"run.integrator": other}))
    for found, true in zip(
        (run.position_error, run.frame_error), errors(run, reference), strict=True
    ):
        assert found[0] == true[0] == 0.0
        assert true.max() / 3.0 < found.max() < 3.0 * true.max()


@pytest.mark.parametrize("name", SCENES)
def test_the_estimate_shrinks_with_the_tolerance(name):
    loose, tight = (nrchain.simulate(verified(scene(name, t))) for t in (1e-5, 1e-8))
    assert tight.position_error.max() < 0.1 * loose.position_error.max()
    assert tight.frame_error.max() < 0.1 * loose.frame_error.max()


@pytest.mark.parametrize("integrator", ["cvode", "radau", "scipy-bdf"])
def test_the_trajectory_is_that_of_a_run_that_is_not_verified(integrator):
    plain = scene("buckling", 1e-6, **{"run.integrator": integrator})
    alone, run = nrchain.simulate(plain), nrchain.simulate(verified(plain))
    assert np.array_equal(run.positions, alone.positions)
    assert np.array_equal(run.frames, alone.frames)
    assert run.counters["steps"] == alone.counters["steps"]
    assert alone.position_error is None
    assert alone.frame_error is None


def test_the_errors_of_a_file_are_those_in_memory(tmp_path):
    given = verified(scene("buckling", 1e-6))
    memory = nrchain.simulate(given)
    written = nrchain.simulate(given, output=tmp_path)
    read = nrchain.Trajectory.open(tmp_path)
    for one in (written, read):
        assert np.array_equal(one.position_error, memory.position_error)
        assert np.array_equal(one.frame_error, memory.frame_error)
    with h5py.File(tmp_path / "trajectory.h5") as file:
        group = file["observables/trajectory/position_error"]
        assert np.array_equal(group["time"][()], read.time)
        assert np.array_equal(group["value"][()], read.position_error)


def test_the_file_of_a_run_that_is_not_verified_has_no_errors(tmp_path):
    nrchain.simulate(scene("buckling", 1e-6), output=tmp_path)
    assert nrchain.Trajectory.open(tmp_path).position_error is None
    with h5py.File(tmp_path / "trajectory.h5") as file:
        assert "observables" not in file


def test_a_resumed_run_has_the_errors_of_a_whole_one(tmp_path):
    given = verified(scene("buckling", 1e-6))
    whole = nrchain.simulate(given)
    half = nrchain.load_scene(given, **{"run.max_steps": 2 * int(whole.counters["steps"]) // 3})
    stopped = nrchain.simulate(half, output=tmp_path)
    assert stopped.cause is Cause.BUDGET
    assert 1 < len(stopped.time) < 6
    resumed = nrchain.resume(tmp_path)
    assert np.array_equal(resumed.positions, whole.positions)
    assert np.array_equal(resumed.position_error, whole.position_error)
    assert np.array_equal(resumed.frame_error, whole.frame_error)


def test_the_error_is_not_known_where_a_run_stops():
    given = verified(scene("buckling", 1e-6, **{"run.max_steps": 40}))
    run = nrchain.simulate(given)
    assert run.cause is Cause.BUDGET
    assert np.isnan(run.position_error).tolist() == [False] * (len(run.time) - 1) + [True]
    assert np.array_equal(np.isnan(run.frame_error), np.isnan(run.position_error))


def test_the_error_is_not_known_after_a_stop_of_the_second_run(monkeypatch):
    given = verified(scene("buckling", 1e-6))
    tighter = second_run._tighter

    def short(scene):
        return nrchain.load_scene(tighter(scene), **{"run.max_steps": 30})

    monkeypatch.setattr(second_run, "_tighter", short)
    with pytest.warns(nrchain.SceneWarning, match="error is not known from t = .* stopped at t"):
        run = nrchain.simulate(given)
    assert run.status == "completed"
    assert run.position_error[0] == 0.0
    assert np.isnan(run.position_error[-1])


def test_a_second_run_that_fails_does_not_end_the_first(monkeypatch):
    def fail(*_):
        raise RuntimeError("no memory left")

    monkeypatch.setattr(second_run, "prepare", fail)
    with pytest.warns(nrchain.SceneWarning, match="failed: no memory left"):
        run = nrchain.simulate(verified(scene("buckling", 1e-6)))
    assert run.status == "completed"
    assert np.isnan(run.position_error[1:]).all()


@pytest.mark.parametrize("key", ["run.rtol", "run.atol"])
def test_a_tolerance_that_cannot_be_divided_is_refused(key):
    with pytest.raises(SceneError, match=r"at least 1e-13 with run\.verify") as caught:
        nrchain.load_scene("buckling", **{key: 5e-14, "run.verify": True})
    assert (caught.value.key, caught.value.value) == (key, 5e-14)
    nrchain.load_scene("buckling", **{key: 1e-13, "run.verify": True})


def test_no_thread_is_left_when_a_run_is_left():
    def leave(progress):
        if progress.snapshot == 2:
            raise KeyError

    before = set(threading.enumerate())
    with pytest.raises(KeyError):
        nrchain.simulate(verified(scene("buckling", 1e-6)), progress=leave)
    assert set(threading.enumerate()) == before


def test_members_of_an_ensemble_are_verified_alike():
    scenes = [verified(scene("buckling", 1e-6, **{"slip.2s": 50.0 + k})) for k in range(3)]
    members = nrchain.simulate_many(scenes, workers=2)
    for member in members:
        alone = nrchain.simulate(scenes[member.index])
        assert np.array_equal(member.result().position_error, alone.position_error)


def test_a_signal_before_the_second_run_has_begun_stops_the_run_at_its_start(monkeypatch):
    monkeypatch.setattr(second_run.SecondRun, "next", lambda self, interruption: None)
    run = nrchain.simulate(verified(scene("buckling", 1e-6)))
    assert run.cause is Cause.INTERRUPTED
    assert run.time[0] == 0.0
    assert run.position_error[0] == run.frame_error[0] == 0.0


PROGRAM = """
import sys
import nrchain
print("begins", flush=True)
nrchain.simulate(nrchain.load_scene({scene}, **{{"run.verify": True}}), output=sys.argv[1])
"""


def test_a_signal_ends_a_run_that_waits_for_its_second(tmp_path):
    command = [sys.executable, "-c", PROGRAM.format(scene=TUMBLING), tmp_path]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        try:
            assert running.stdout.readline() == b"begins\n"
            while running.poll() is None and not (tmp_path / "trajectory.h5").exists():
                time.sleep(0.1)
            time.sleep(1.0)
            running.send_signal(signal.SIGINT)
            _, messages = running.communicate(timeout=300.0)
        finally:
            running.kill()
    assert messages.splitlines()[-1].startswith(b"KeyboardInterrupt")
    assert nrchain.Trajectory.open(tmp_path).cause is Cause.INTERRUPTED
