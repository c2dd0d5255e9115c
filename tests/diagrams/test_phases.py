"""Phase diagrams of short chains: what they find, keep, refuse and repeat."""

import os
import shutil
import signal
import subprocess
import sys
import time
import warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest
from support.selection import few_of

import nrchain
from nrchain.diagrams import trials
from nrchain.errors import SceneError, TrajectoryError
from nrchain.jobs import crew

X, Y = ("slip.2s", 0.0, 1500.0, 3), ("elasticity.bend", 1500.0, 2500.0, 3)


def scene():
    changes = {"chain.particles": 6, "elasticity.measure": "isotropic", "start.amplitude": 0.5}
    return nrchain.load_scene("buckling", **changes)


def small(**options):
    return nrchain.phases(scene(), X, Y, "random", **{"levels": 1} | options)


@cache
def kept():
    return small(workers=1)


@pytest.fixture(scope="module")
def kept_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("phases") / "kept"
    assert small(output=folder) == kept()
    return folder


def test_pushers_are_straight_below_the_threshold_and_buckle_above():
    found = kept()
    assert found.is_complete
    assert set(found.kinds) == {"straight", "buckled"}
    (curve,) = found.curves
    assert not curve.flutters
    for point in found.points:
        threshold = np.interp(point.y, curve.y, curve.x)
        assert point.kind == ("straight" if point.x < threshold else "buckled")


def test_the_threshold_is_that_of_critical_strength():
    (curve,) = kept().curves
    for x, y in zip(curve.x, curve.y, strict=True):
        there = nrchain.load_scene(scene(), **{"elasticity.bend": float(y)})
        expected = nrchain.critical_strength(there, "slip.2s", (500.0, 1200.0))
        assert x == pytest.approx(expected.value, rel=1e-8)


def test_points_are_added_only_where_neighbours_differ():
    """On the first grid the boundary lies left of x = 750 in the lowest row only."""
    found = kept()
    new = {(point.x, point.y) for point in found.points[9:]}
    assert {(375.0, 1750.0), (1125.0, 2250.0)} <= new
    assert not {(0.0, 2250.0), (375.0, 2250.0), (375.0, 2500.0)} & new


def test_each_region_has_a_verified_run_and_a_stable_state():
    for region in kept().regions:
        assert region.agrees
        (verified,) = region.verified
        point = kept().points[region.inner]
        assert (verified.x, verified.y) == (point.x, point.y)
        assert verified.error < 1e-4
        there = nrchain.load_scene(scene(), **{X[0]: point.x, Y[0]: point.y})
        nudge = 0.0 if region.kind == "straight" else 0.5
        state = nrchain.find_state(there, nudge=nudge)
        assert state.is_stable
        assert verified.growth == pytest.approx(state.spectrum.leading.growth, rel=1e-3)


def test_threads_and_processes_give_the_same_bits():
    alone = small(levels=0, workers=1)
    assert small(levels=0, workers=3) == alone
    with ThreadPoolExecutor(2) as threads:
        assert small(levels=0, executor=threads) == alone
    with warnings.catch_warnings():
        # from Python 3.12 on a fork beside threads, such as those of BLAS, warns
        warnings.simplefilter("ignore", DeprecationWarning)
        with ProcessPoolExecutor(1) as processes:
            assert small(levels=0, executor=processes) == alone


def test_every_start_is_run_at_every_point():
    """3t is absent from the scene, and 0 at one end of its axis."""
    found = nrchain.phases(
        scene(),
        ("slip.2s", 0.0, 10.0, 2),
        ("slip.3t", 0.0, 1.0, 2),
        ("random", "planar:3"),
        levels=0,
    )
    assert found.starts == ("random", "planar:3")
    assert all(len(point.trials) == 2 for point in found.points)


def test_a_folder_is_opened_and_goes_on_where_it_was_left(kept_folder, tmp_path, monkeypatch):
    folder = shutil.copytree(kept_folder, tmp_path / "kept")
    assert nrchain.PhaseDiagram.open(folder) == kept()
    lines = (folder / "results.jsonl").read_bytes().splitlines(keepends=True)
    # a kill in the middle: some lines, and a part of the next
    (folder / "results.jsonl").write_bytes(b"".join(lines[:20]) + lines[20][:15])
    partial = nrchain.PhaseDiagram.open(folder)
    assert not partial.is_complete
    done = []
    monkeypatch.setattr(crew, "attempt", counted(done))
    assert small(output=folder) == kept()
    assert len(done) == len(lines) - 20


@pytest.mark.parametrize("count", few_of([0, 3, 9, 12, -1], {0, 9}))
def test_a_diagram_of_which_little_is_finished_can_be_read_and_drawn(count, kept_folder, tmp_path):
    folder = shutil.copytree(kept_folder, tmp_path / "partial")
    lines = (folder / "results.jsonl").read_bytes().splitlines(keepends=True)
    (folder / "results.jsonl").write_bytes(b"".join(lines[:count]))
    partial = nrchain.PhaseDiagram.open(folder)
    assert not partial.is_complete
    assert len(partial.points) == len(list(partial.rows())) <= len(kept().points)
    nrchain.phase_plots.save_phases(partial, tmp_path / "d.png")


def counted(done):
    attempt = crew.attempt

    def count(function, arguments, interruption):
        done.append((function, repr(arguments)))
        return attempt(function, arguments, interruption)

    return count


def test_another_request_in_the_same_place_is_refused_with_what_differs(tmp_path):
    small(output=tmp_path / "a", levels=0)
    with pytest.raises(TrajectoryError, match=r"levels is 0 there and 1 here; choose another"):
        small(output=tmp_path / "a", levels=1)
    other = nrchain.load_scene(scene(), **{"start.amplitude": 0.4})
    with pytest.raises(TrajectoryError, match=r"start\.amplitude is 0\.5 there and 0\.4 here"):
        nrchain.phases(other, X, Y, "random", levels=0, output=tmp_path / "a")
    nrchain.phases(other, X, Y, "random", levels=0, output=tmp_path / "a", overwrite=True)
    with pytest.raises(TrajectoryError, match="there is no phase diagram"):
        nrchain.PhaseDiagram.open(tmp_path / "b")


def test_a_run_that_fails_is_recorded_with_its_cause(monkeypatch):
    simulated = trials.simulated

    def broken(scene, *arguments, **options):
        if scene.slip.modes["2s"].strength == 1500.0:
            raise ZeroDivisionError("on purpose")
        return simulated(scene, *arguments, **options)

    monkeypatch.setattr(trials, "simulated", broken)
    found = small(levels=0)
    failed = [point for point in found.points if point.kind == "failed"]
    assert {point.x for point in failed} == {1500.0}
    assert failed[0].trials[0].why == "ZeroDivisionError: on purpose"
    assert any("3 of 9 runs failed" in note for note in found.notes)


PROGRAM = """
import sys, time
import nrchain
from nrchain.diagrams import trials
changes = {"chain.particles": 6, "elasticity.measure": "isotropic", "start.amplitude": 0.5}
scene = nrchain.load_scene("buckling", **changes)
simulated = trials.simulated
def slow(*arguments, **options):
    time.sleep(0.2)
    return simulated(*arguments, **options)
trials.simulated = slow
x, y = ("slip.2s", 0.0, 1500.0, 3), ("elasticity.bend", 1500.0, 2500.0, 3)
try:
    nrchain.phases(scene, x, y, "random", levels=1, workers=1, output=sys.argv[1])
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.parametrize("number", few_of([signal.SIGINT, signal.SIGKILL], {signal.SIGKILL}))
def test_what_is_finished_survives_an_end_in_the_middle(number, tmp_path):
    program = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, tmp_path / "d"], stdout=subprocess.PIPE, text=True
    )
    results = tmp_path / "d" / "results.jsonl"
    end = time.monotonic() + 120.0
    while time.monotonic() < end and not (results.exists() and b'"run ' in results.read_bytes()):
        time.sleep(0.05)
    os.kill(program.pid, number)
    shown = program.communicate(timeout=60)[0]
    assert shown == ("interrupted\n" if number == signal.SIGINT else "")
    partial = nrchain.PhaseDiagram.open(tmp_path / "d")
    assert not partial.is_complete
    assert 0 < len(partial.points) < len(kept().points)
    finished = results.read_bytes()
    whole = small(output=tmp_path / "d")
    assert results.read_bytes().startswith(finished[: finished.rindex(b"\n") + 1])
    # another process may have compiled its kernels, and differ in rounding
    assert [point.kinds for point in whole.points] == [point.kinds for point in kept().points]
    assert [region.points for region in whole.regions] == [r.points for r in kept().regions]
    assert whole.is_complete


def test_keys_that_are_no_numbers_of_the_scene_are_refused():
    for key in ("chain.particles", "slip.9z", "start.amplitude", "run.end"):
        with pytest.raises(SceneError, match=rf"y = '{key}': must be a number on which .*slip\.4a"):
            nrchain.phases(scene(), X, (key, 0.0, 1.0))
    with pytest.raises(SceneError, match="another key than x"):
        nrchain.phases(scene(), X, X)


@pytest.mark.parametrize(
    ("axis", "part"),
    [
        (("slip.2s", 1.0, 1.0), "must go from a number to a larger one"),
        (("slip.2s", 0.0, float("inf")), "must go from a number to a larger one"),
        (("slip.2s", 0.0, 1.0, 1), "at least 2 points"),
        (("slip.2s", 0.0), r"\(key, low, high\)"),
        ("slip.2s", r"\(key, low, high\)"),
    ],
)
def test_axes_without_a_range_are_refused(axis, part):
    with pytest.raises(SceneError, match=part):
        nrchain.phases(scene(), axis, Y)


def test_what_has_no_diagram_is_refused_before_a_folder_is_made(tmp_path):
    field = nrchain.load_scene(scene(), **{"field.force": [0.0, 0.0, -1.0]})
    with pytest.raises(SceneError, match=r"field = .*does not move and rotate with the chain"):
        nrchain.phases(field, X, Y, output=tmp_path / "no")
    with pytest.raises(SceneError, match=r"starts = 'wavy': must be among random"):
        nrchain.phases(scene(), X, Y, "wavy", output=tmp_path / "no")
    with pytest.raises(SceneError, match="several different"):
        nrchain.phases(scene(), X, Y, ("random", "random"), output=tmp_path / "no")
    with pytest.raises(SceneError, match="levels = 9"):
        small(levels=9, output=tmp_path / "no")
    with pytest.raises(SceneError, match="most = 8: must be a whole number of at least 9"):
        small(most=8, output=tmp_path / "no")
    with pytest.raises(SceneError, match="longest = -1"):
        small(longest=-1.0, output=tmp_path / "no")
    assert not (tmp_path / "no").exists()


def test_the_corners_of_the_plane_must_be_scenes():
    with pytest.raises(SceneError, match=r"chain\.spacing = 1\.0: must exceed two radii"):
        nrchain.phases(scene(), ("chain.spacing", 1.0, 10.0), Y)
