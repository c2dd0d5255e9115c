"""From a scene to a trajectory: results of the paper, stops and resumption."""

import os
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.poses import random_chain
from support.selection import few_of

import nrchain
from nrchain.errors import SceneError, TrajectoryError
from nrchain.geometry import near_pairs
from nrchain.outcome import Cause, Stop
from nrchain.planning import checked_start
from nrchain.run import loop
from nrchain.run.recording import snapshot_times
from nrchain.watch.growth import GrowthWatch


def sides(trajectory):
    """Transverse displacement y + iz of every sphere from the x axis, (T, N)."""
    return trajectory.positions[..., 1] + 1j * trajectory.positions[..., 2]


def worst_frame(frames):
    gram = np.einsum("...ak,...bk->...ab", frames, frames)
    return np.abs(gram - np.eye(3)).max()


def wait_for_snapshots(child, path, count):
    """Until a child process has written so many, or has ended."""
    reached = 0
    while child.poll() is None and reached < count:
        time.sleep(0.02)
        if path.exists():
            try:
                reached = len(nrchain.Trajectory.open(path).time)
            except TrajectoryError:
                continue  # the file is being laid out


@pytest.fixture(scope="module")
def shipped():
    return {name: nrchain.simulate(nrchain.load_scene(name)) for name in nrchain.scene_names()}


def test_shipped_scenes_complete_with_orthonormal_frames(shipped):
    assert len(shipped) == 8
    for trajectory in shipped.values():
        assert trajectory.status == "completed"
        assert len(trajectory.time) == trajectory.scene.run.snapshots
        assert worst_frame(trajectory.frames) < 1e-13


def test_clamped_ends_do_not_move(shipped):
    for name in ("passive", "buckling", "stable", "helix-left", "helix-right"):
        trajectory = shipped[name]
        for end in (0, -1):
            assert np.array_equal(
                trajectory.positions[:, end], np.tile(trajectory.positions[0, end], (101, 1))
            )


def test_pushers_buckle_and_pullers_straighten(shipped):
    start = np.abs(sides(shipped["buckling"]))[0].max()
    assert np.abs(sides(shipped["buckling"]))[-1].max() > 50 * start
    assert np.abs(sides(shipped["stable"]))[-1].max() < 1e-3 * start
    assert np.abs(sides(shipped["passive"]))[-1].max() < 0.1 * start


@pytest.mark.parametrize(("name", "hand"), [("helix-left", -1), ("helix-right", 1)])
def test_the_sign_of_3a_sets_the_hand_of_the_coil(shipped, name, hand):
    shape = sides(shipped[name])[-1]
    turning = np.angle(shape[2:-1] / shape[1:-2])
    assert np.abs(shape).max() > 5
    # the phase of y + iz advances with x on a right-handed coil; skip where the coil tapers off
    assert np.median(np.sign(turning)) == hand


def test_mirror_images_stay_mirror_images(shipped):
    left, right = sides(shipped["spiral-left"]), sides(shipped["spiral-right"])
    assert np.abs(left - right.conj()).max() < 1e-9


def test_a_free_3t_chain_swims_at_its_share_of_v0():
    # V0 = 4a³V/5d³ holds where a sphere has two neighbours: the ends have one, and a chain of N
    # swims at (1 − 1/N) V0
    scene = nrchain.load_scene("wave", start={"shape": "straight"}, **{"elasticity.ratio": 1e12})
    trajectory = nrchain.simulate(scene)
    travelled = trajectory.positions[-1].mean(axis=0) - trajectory.positions[0].mean(axis=0)
    count = scene.chain.particles
    expected = (1 - 1 / count) * 4 / 5 * 1000 / 10**3 * trajectory.time[-1]
    assert travelled == pytest.approx([expected, 0, 0], rel=1e-4, abs=1e-9)


@pytest.mark.parametrize(("name", "sign"), [("spiral-left", -1), ("spiral-right", 1)])
@pytest.mark.parametrize(("shape", "error"), [("straight", 1e-4), ("helix", 0.04)])
def test_a_4a_chain_turns_at_omega0_through_many_turns(name, sign, shape, error):
    # Ω0 = −363a⁴V/5d⁵ of the straight chain, times (1 − 1/N) for the free ends; the helix of the
    # scene has slopes of 0.17 and differs by their square. The first half lets the twist settle
    # that the slower ends leave in the chain.
    start = "straight" if shape == "straight" else name.replace("spiral", "helix")
    changes = {"start.shape": start, "run.snapshots": 401, "run.end": 60.0}
    trajectory = nrchain.simulate(nrchain.load_scene(name, **changes))
    rate = 363 / 5 * 10000 / 10.0**5 * (1 - 1 / trajectory.scene.chain.particles)
    e2 = trajectory.frames[:, 10, 1]
    angle = np.unwrap(np.arctan2(e2[:, 2], e2[:, 1]))
    turned = (angle[-1] - angle[200]) / (trajectory.time[-1] - trajectory.time[200])
    assert turned == pytest.approx(sign * rate, rel=error)
    assert abs(angle[-1] - angle[0]) > 60 * 2 * np.pi


@pytest.mark.parametrize(
    ("integrator", "ratio", "evaluations"),
    [("cvode", 1e7, 320), ("cvode", 1e12, 650), ("radau", 1e7, 500), ("radau", 1e12, 900)],
)
def test_stiff_chains_need_no_more_than_some_hundred_evaluations(integrator, ratio, evaluations):
    """A tenth more than they take where steps err by 1e-7, and by 1e-6 with Radau."""
    keys = {"cvode": {"run.rtol": 2e-6, "run.atol": 2e-6}, "radau": {}}[integrator]
    keys |= {"elasticity.ratio": ratio, "run.end": 400, "run.integrator": integrator}
    scene = nrchain.load_scene("buckling", **keys)
    trajectory = nrchain.simulate(scene)
    assert trajectory.status == "completed"
    assert trajectory.counters["evaluations"] < evaluations
    assert trajectory.counters["jacobians"] < 100


@pytest.mark.parametrize("neighbours", [4, "all"])
def test_a_longer_reach_takes_fewer_than_three_times_the_evaluations(neighbours):
    scene = nrchain.load_scene("buckling", **{"elasticity.ratio": 1e12, "run.end": 400})
    near = nrchain.simulate(scene).counters["evaluations"]
    far = nrchain.load_scene(scene, **{"slip.neighbours": neighbours})
    assert nrchain.simulate(far).counters["evaluations"] < 3 * near


def test_tighter_tolerances_converge():
    def end(rtol):
        scene = nrchain.load_scene("buckling", run={"rtol": rtol, "atol": rtol, "end": 600.0})
        return nrchain.simulate(scene).positions[-1]

    reference = end(1e-10)
    errors = [np.abs(end(rtol) - reference).max() for rtol in (1e-4, 1e-6, 1e-8)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-5


def test_pystokes_backend_gives_the_same_trajectory():
    scene = nrchain.load_scene("buckling", **{"run.end": 3, "chain.particles": 8})
    native = nrchain.simulate(scene)
    other = nrchain.simulate(nrchain.load_scene(scene, **{"slip.backend": "pystokes"}))
    assert np.abs(native.positions - other.positions).max() < 1e-7


def test_a_start_of_ones_own():
    scene = nrchain.load_scene("passive", **{"run.end": 1e-6, "chain.ends": "free"})
    positions, frames = random_chain(20, spacing=10.0, bend=0.1)
    trajectory = nrchain.simulate(scene, positions=positions, frames=frames)
    assert np.array_equal(trajectory.positions[0], positions)


def half_turned(angle=3.0):
    """Frames of 20 spheres with a twist of ``angle`` between the halves of the chain."""
    frames = np.tile(np.eye(3), (20, 1, 1))
    frames[10:, 1:, 1:] = [
        [np.cos(angle), np.sin(angle)],
        [-np.sin(angle), np.cos(angle)],
    ]
    return frames


def test_any_turn_is_fine_without_springs_against_it():
    scene = nrchain.load_scene(
        "passive", elasticity={"twist": 0.0, "bend": 0.0}, **{"chain.ends": "free", "run.end": 0.1}
    )
    assert nrchain.simulate(scene, frames=half_turned()).status == "completed"


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        ({"positions": np.zeros((3, 3))}, r"positions = \(3, 3\): the shape must be \(20, 3\)"),
        ({"positions": np.zeros((20, 3))}, "^positions = spheres 0 and 1: overlap"),
        ({"positions": np.full((20, 3), np.nan)}, "finite"),
        ({"positions": [["a"] * 3] * 20}, "must be numbers of shape"),
        (
            {"positions": 1e200 * np.arange(60.0).reshape(20, 3)},
            r"must be at most 1e\+100",
        ),
        ({"frames": half_turned()}, r"^frames = link 9: turned by 3 rad"),
        ({"frames": np.zeros((20, 3, 3))}, r"^frames\[0\] = .* orthonormal .* off by 1;"),
        ({"frames": -np.broadcast_to(np.eye(3), (20, 3, 3))}, "are left-handed"),
    ],
)
def test_bad_starts_are_refused(poses, message):
    with pytest.raises(SceneError, match=message):
        nrchain.simulate(nrchain.load_scene("passive"), **poses)


def test_overlapping_start_of_a_scene_is_refused():
    # a sine in the y direction brings no spheres together, random offsets of 1 a at 2.001 a do
    crowded = nrchain.load_scene("buckling", chain={"spacing": 2.001})
    positions = checked_start.starting_poses(crowded)[0]
    with pytest.raises(SceneError, match=r"spheres .* overlap"):
        nrchain.simulate(crowded, positions=1.999 / 2.001 * positions)


@pytest.mark.filterwarnings("ignore::nrchain.errors.SceneWarning")
def test_spheres_that_touch_stop_the_run():
    # two spheres pulled together by a spring much shorter than their distance
    scene = nrchain.load_scene(
        {
            "chain": {"particles": 2, "spacing": 2.001},
            "elasticity": {"stretch": 1.0, "shear": 1.0},
            "slip": {"2s": -50.0},
            "run": {"end": 1e3},
        }
    )
    trajectory = nrchain.simulate(scene)
    assert (trajectory.status, trajectory.cause) == ("stopped", Cause.TOUCH)
    assert "spheres 0 and 1 touch (distance 2 a)" in trajectory.reason
    # the last snapshot is the contact itself, at a time of its own
    assert f"t = {trajectory.time[-1]:.6g}" in trajectory.reason
    assert trajectory.time[-1] not in snapshot_times(scene)
    gap = np.linalg.norm(np.diff(trajectory.positions[-1], axis=0)) - 2.0
    assert abs(gap) < 1e-12


def test_a_budget_of_steps_is_kept_and_spent_anew_by_resuming(tmp_path):
    run = {"end": 60.0, "snapshots": 31, "integrator": "cvode", "rtol": 2e-6, "atol": 2e-6}
    scene = nrchain.load_scene("spiral-left", run=run)
    whole = nrchain.simulate(scene, output=tmp_path / "whole.h5")
    steps = whole.counters["steps"] // 3 + 1
    limited = nrchain.load_scene(scene, **{"run.max_steps": steps})
    pieces = nrchain.simulate(limited, output=tmp_path)
    assert pieces.cause is Cause.BUDGET
    assert pieces.counters["steps"] == steps
    assert f"{steps} steps are used up" in pieces.reason
    for _ in range(9):
        if pieces.status == "completed":
            break
        assert (np.diff(pieces.time) > 0).all()
        pieces = nrchain.resume(tmp_path)
    assert pieces.status == "completed"
    assert np.array_equal(pieces.positions, whole.positions)
    assert pieces.counters["restarts"] > 0
    recorded = []
    for path in (whole.path, pieces.path):
        with h5py.File(path) as file:
            recorded.append(file["particles/trajectory/position/step"][()].tolist())
    assert recorded[0] == recorded[1]


def test_steps_at_snapshots_are_those_of_the_uninterrupted_run_after_the_second_checkpoint(
    tmp_path, monkeypatch
):
    """Also at snapshots that compiled steps sample."""
    monkeypatch.setattr(loop, "RESTART_STEPS", 20)
    run = {"end": 10.0, "snapshots": 51, "integrator": "radau"}
    scene = nrchain.load_scene("spiral-left", run=run)
    whole = nrchain.simulate(scene, output=tmp_path / "whole.h5")
    limited = nrchain.load_scene(scene, **{"run.max_steps": 30})
    pieces = nrchain.simulate(limited, output=tmp_path)
    assert pieces.latest_checkpoint().counters["steps"] == 20
    for _ in range(20):
        if pieces.status == "completed":
            break
        pieces = nrchain.resume(tmp_path)
    assert pieces.status == "completed"
    recorded = []
    for path in (whole.path, pieces.path):
        with h5py.File(path) as file:
            recorded.append(file["particles/trajectory/position/step"][()].tolist())
    assert recorded[0] == recorded[1]


@pytest.mark.parametrize("late", [0.0, 0.25])
def test_a_stop_on_a_snapshot_is_that_snapshot_and_one_after_it_comes_last(
    tmp_path, monkeypatch, late
):
    # cvode, whose steps are all looked at
    changes = {"run.end": 8.0, "run.snapshots": 5, "run.integrator": "cvode"}
    scene = nrchain.load_scene("stable", **changes)
    until = snapshot_times(scene)[2] + late

    def watch(self, start, end, *rest):
        return Stop(Cause.GROWTH, until, "told to") if start < until <= end else None

    monkeypatch.setattr(GrowthWatch, "watch", watch)
    for output in (None, tmp_path):
        stopped = nrchain.simulate(scene, output=output)
        assert stopped.cause is Cause.GROWTH
        assert stopped.time.tolist() == [0.0, 2.0, 4.0] + [until] * (late > 0.0)
    with h5py.File(tmp_path / "trajectory.h5") as file:
        assert len(file["particles/trajectory/position/value"]) == 3 + (late > 0.0)


def test_a_budget_of_seconds_is_kept():
    # its kernels may have to be compiled first
    nrchain.simulate(nrchain.load_scene("spiral-left", **{"run.max_steps": 1}))
    scene = nrchain.load_scene("spiral-left", **{"run.end": 1e6, "run.max_seconds": 0.3})
    began = time.perf_counter()
    stopped = nrchain.simulate(scene)
    assert stopped.cause is Cause.BUDGET
    assert time.perf_counter() - began < 5


@pytest.mark.parametrize(
    ("number", "name"),
    few_of([(signal.SIGINT, "SIGINT"), (signal.SIGTERM, "SIGTERM")], {(signal.SIGINT, "SIGINT")}),
)
def test_a_signal_leaves_a_file_to_go_on_from(tmp_path, whole, number, name):
    arguments = ["run", "spiral-left", "-o", tmp_path]
    for key in ("end", "snapshots", "integrator", "rtol", "atol"):
        arguments += ["--set", f"run.{key}={getattr(whole.scene.run, key)}"]
    program = "from nrchain.cli.app import main; main()"
    child = subprocess.Popen(
        [sys.executable, "-c", program, *map(str, arguments)], stderr=subprocess.PIPE, text=True
    )
    wait_for_snapshots(child, tmp_path / "trajectory.h5", 5)
    child.send_signal(number)
    message = child.communicate()[1]
    assert child.returncode == 130
    assert "nrchain resume" in message
    assert "Traceback" not in message
    stopped = nrchain.Trajectory.open(tmp_path)
    assert (stopped.status, stopped.cause) == ("stopped", Cause.INTERRUPTED)
    assert f"interrupted by {name}" in stopped.reason
    assert 5 <= len(stopped.time) < 41
    assert np.array_equal(resumed_apart(tmp_path).positions, whole.positions)


@pytest.mark.parametrize("integrator", ["cvode", "radau", "scipy-bdf"])
def test_velocities_that_overflow_stop_the_run(integrator):
    scene = nrchain.load_scene(
        "buckling", **{"slip.2s": 1e300, "run.integrator": integrator, "run.max_seconds": 20}
    )
    stopped = nrchain.simulate(scene)
    assert stopped.cause in (Cause.NOT_FINITE, Cause.STEP, Cause.TOUCH)
    assert np.isfinite(stopped.positions).all()


def test_two_clamped_spheres_stay():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 2})
    trajectory = nrchain.simulate(scene)
    assert trajectory.status == "completed"
    assert np.array_equal(trajectory.positions[-1], trajectory.positions[0])


def long_spin(end=600.0):
    """A run of some seconds with many fresh charts: a bent 4a chain with the paper's terms."""
    keys = {"run.integrator": "cvode", "run.rtol": 2e-6, "run.atol": 2e-6}
    return nrchain.load_scene("spiral-left", run={"end": end, "snapshots": 41}, **keys)


def test_memory_and_file_hold_the_same(tmp_path):
    scene = long_spin(30.0)
    in_memory = nrchain.simulate(scene)
    on_disk = nrchain.simulate(scene, output=tmp_path)
    assert np.array_equal(in_memory.positions, on_disk.positions)
    assert np.array_equal(in_memory.frames, on_disk.frames)
    assert on_disk.counters["restarts"] >= 1
    with pytest.raises(TrajectoryError, match="overwrite"):
        nrchain.simulate(scene, output=tmp_path)
    nrchain.simulate(scene, output=tmp_path, overwrite=True)


SIMULATE = (
    "import sys, nrchain\n"
    "scene = nrchain.Scene.from_toml(open(sys.argv[1]).read())\n"
    "nrchain.simulate(scene, output=sys.argv[2], overwrite=True)\n"
)


def start_apart(scene, path):
    """A process of its own that simulates a scene."""
    toml = path.with_suffix(".toml")
    toml.write_text(scene.to_toml())
    return subprocess.Popen([sys.executable, "-c", SIMULATE, str(toml), str(path)])


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A long spin to its end, by a process of its own, with kernels that were on disk before.

    Bits are the same between processes that load their kernels: one that compiles them calls
    functions that the others have inlined, and differs in rounding.
    """
    nrchain.simulate(long_spin(0.1))  # may compile kernels, and keeps them on disk
    path = tmp_path_factory.mktemp("whole") / "whole.h5"
    assert start_apart(long_spin(), path).wait() == 0
    return nrchain.Trajectory.open(path)


def resumed_apart(path):
    """The run at ``path`` to its end, by a process of its own."""
    program = "import sys, nrchain; nrchain.resume(sys.argv[1])"
    subprocess.run([sys.executable, "-c", program, str(path)], check=True)
    return nrchain.Trajectory.open(path)


def test_a_killed_run_goes_on_bit_for_bit(tmp_path, whole):
    path = tmp_path / "trajectory.h5"
    child = start_apart(whole.scene, path)
    wait_for_snapshots(child, path, 15)
    os.kill(child.pid, signal.SIGKILL)
    child.wait()
    killed = nrchain.Trajectory.open(path)
    assert killed.status == "running"
    assert 15 <= len(killed.time) < 41
    resumed = resumed_apart(path)
    assert whole.counters["restarts"] >= 5
    assert resumed.status == "completed"
    assert np.array_equal(resumed.time, whole.time)
    assert np.array_equal(resumed.positions, whole.positions)
    assert np.array_equal(resumed.frames, whole.frames)


def test_a_name_without_an_ending_is_a_directory(tmp_path):
    place = tmp_path / "runs" / "mine"
    scene = nrchain.load_scene("stable", **{"run.end": 1.0})
    assert nrchain.simulate(scene, output=place).path == place / "trajectory.h5"
    (tmp_path / "taken").write_text("")
    with pytest.raises(TrajectoryError, match="cannot be made"):
        nrchain.simulate(scene, output=tmp_path / "taken")


def test_a_finished_run_has_nothing_to_resume(tmp_path):
    done = nrchain.simulate(nrchain.load_scene("stable"), output=tmp_path)
    again = nrchain.resume(tmp_path)
    assert again.counters == done.counters


@pytest.mark.slow
def test_threads_do_not_change_the_result():
    script = (
        "import hashlib, sys, nrchain\n"
        "scene = nrchain.load_scene('buckling', **{'chain.particles': 160,"
        " 'elasticity.ratio': 1e12, 'slip.neighbours': 'all', 'run.end': float(sys.argv[1])})\n"
        "print(hashlib.sha256(nrchain.simulate(scene).positions.tobytes()).hexdigest())\n"
    )
    digests = [
        subprocess.run(
            [sys.executable, "-c", script, end],
            env=os.environ | {"NUMBA_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        # the first process may have to compile the kernels, the others load them
        for threads, end in (("1", "0.1"), ("1", "50.0"), ("2", "50.0"))
    ]
    assert digests[1] == digests[2]


def test_progress_is_reported_at_every_snapshot():
    seen = []
    nrchain.simulate(nrchain.load_scene("stable"), progress=seen.append)
    assert [p.snapshot for p in seen] == list(range(1, 102))
    assert seen[-1].time == seen[-1].end
    assert seen[-1].counters["steps"] > 0


@pytest.mark.parametrize("search", [0, 1024])
@pytest.mark.parametrize("period", [0.0, 40.0])
@given(st.integers(0, 10**6), st.lists(st.integers(-4, 4), min_size=16, max_size=16))
def test_the_closest_pair_is_that_of_all_images(period, search, seed, images):
    positions = random_chain(16, spacing=2.5, noise=0.8, seed=seed)[0]
    moved = positions + np.outer(images, [period, 0.0, 0.0])
    i, j = np.triu_indices(16, 1)
    shifts = period * np.arange(-10.0, 11.0)[:, None, None] * [1.0, 0.0, 0.0]
    distances = np.linalg.norm(moved[i] - moved[j] + shifts, axis=-1).min(axis=0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(near_pairs, "DIRECT_SEARCH", search)
        distance, first, second = near_pairs.closest_pair(moved, period)
    assert distance == pytest.approx(distances.min())
    assert {first, second} == {i[np.argmin(distances)], j[np.argmin(distances)]}


@pytest.mark.parametrize("name", ["", "mine.h5"])
def test_a_place_that_is_taken_is_refused_before_effects_are_chosen(tmp_path, monkeypatch, name):
    chosen = {"effects": "auto", "tolerance": 0.01, "run.end": 1.0}
    scene = nrchain.load_scene("stable", **chosen)
    place = tmp_path / name if name else tmp_path
    (tmp_path / (name or "trajectory.h5")).write_bytes(b"dear")
    monkeypatch.setattr("nrchain.planning.auto.choose", lambda *_: pytest.fail("time is spent"))
    with pytest.raises(TrajectoryError, match="replaced only with overwrite"):
        nrchain.simulate(scene, output=place)
