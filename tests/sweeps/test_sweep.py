"""``nrchain.sweep``: every point once, the same bits by any executor, and what is refused."""

import json
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneError, TrajectoryError
from nrchain.sweeps import task
from nrchain.sweeps.observables import NAMED

GRID = {"slip.2s": "-100:100:3", "chain.particles": "4,5"}


CHANGES = {"chain.particles": 5, "run.end": 2.0, "run.snapshots": 6, "elasticity.ratio": 1e8}


def scene(**changes):
    return nrchain.load_scene("buckling", **CHANGES | changes)


@cache
def expected():
    return nrchain.sweep(scene(), GRID, workers=1)


def run_count(monkeypatch):
    """The names of points that are run from here on."""
    names, run = [], task.run_point

    def counted(*arguments, interruption):
        names.append(arguments[-1])
        return run(*arguments, interruption=interruption)

    monkeypatch.setattr(task, "run_point", counted)
    return names


def test_each_point_is_the_run_of_its_scene():
    found = expected()
    assert [tuple(point.values.values()) for point in found.points] == [
        (strength, count) for strength in (-100.0, 0.0, 100.0) for count in (4, 5)
    ]
    for point in found.points:
        own = nrchain.load_scene(scene(), **point.values)
        assert found.scene_at(point) == own
        run = nrchain.simulate(own)
        assert point.outcome == "completed"
        assert point.observables["end.time"] == 2.0
        line = np.linalg.svd(run.positions[-1] - run.positions[-1].mean(axis=0))[1]
        size = np.sqrt((line[1:] ** 2).sum() / own.chain.particles)
        assert point.observables["end.size"] == pytest.approx(size, rel=1e-12)
        assert point.counters["evaluations"] == run.counters["evaluations"]
        assert point.seconds > 0.0


def test_order_and_threads_change_nothing():
    with ThreadPoolExecutor(3) as executor:
        assert nrchain.sweep(scene(), GRID, executor=executor) == expected()
    backwards = {"chain.particles": [5, 4], "slip.2s": [100.0, 0.0, -100.0]}
    again = nrchain.sweep(scene(), backwards, workers=2)
    assert {p.name: p.observables for p in again.points} == {
        p.name: p.observables for p in expected().points
    }


def test_finished_points_are_not_run_again_and_new_ones_are(tmp_path, monkeypatch):
    folder = tmp_path / "kept"
    assert nrchain.sweep(scene(), GRID, output=folder) == expected()
    lines = (folder / "results.jsonl").read_bytes().splitlines(keepends=True)
    # as a program leaves it that is killed while it writes the fifth result
    (folder / "results.jsonl").write_bytes(b"".join(lines[:4]) + lines[4][:20])
    assert len(nrchain.Sweep.open(folder)) == 4
    names = run_count(monkeypatch)
    assert nrchain.sweep(scene(), GRID, output=folder) == expected()
    assert len(names) == 2
    assert nrchain.sweep(scene(), GRID, output=folder) == nrchain.Sweep.open(folder) == expected()
    assert len(names) == 2
    more = nrchain.sweep(scene(), {"slip.2s": [0.0, 50.0]}, output=folder)
    assert len(more) == 7
    assert len(names) == 3


def test_a_new_observable_is_added_to_points_that_have_the_others(tmp_path, monkeypatch):
    values, folder = {"slip.2s": [0.0, 50.0]}, tmp_path / "s"
    first = nrchain.sweep(scene(), values, output=folder, keep=True)
    before = first.points[0].trajectory.stat().st_mtime_ns
    both = nrchain.sweep(scene(), values, output=folder, keep=True, observe=["end.energy"])
    assert both.observables == ("end.time", "end.size", "end.energy")
    assert both.column("end.size") == first.column("end.size")
    for point in both.points:
        run = nrchain.Trajectory.open(point.trajectory)
        moduli = run.scene.moduli._asdict()
        poses = run.positions[-1], run.frames[-1]
        energy = nrchain.elastic_energy(*poses, spacing=10.0, ends="clamped", **moduli)
        assert point.observables["end.energy"] == energy
    # measured on the trajectory that was kept
    assert first.points[0].trajectory.stat().st_mtime_ns == before


def test_shards_are_merged_by_the_same_call(tmp_path, monkeypatch):
    folder = tmp_path / "s"
    for part in ("2/3", "1/3", "3/3"):
        nrchain.sweep(scene(), GRID, output=folder, shard=part)
    assert len({*folder.glob("results-*-of-3.jsonl")}) == 3
    assert not (folder / "table.csv").exists()
    names = run_count(monkeypatch)
    assert nrchain.sweep(scene(), GRID, output=folder) == expected()
    assert names == []
    assert (folder / "table.csv").exists()


def test_a_shard_works_beside_another_and_the_whole_waits_for_it(tmp_path):
    folder, seen = tmp_path / "s", []

    def look(progress):
        if progress.done == 1 and not seen:
            seen.append(nrchain.sweep(scene(), GRID, output=folder, shard="2/2"))
            with pytest.raises(TrajectoryError, match=r"results-1-of-2.*is writing to it"):
                nrchain.sweep(scene(), GRID, output=folder)

    nrchain.sweep(scene(), GRID, output=folder, shard="1/2", progress=look)
    assert len(seen) == 1
    assert nrchain.Sweep.open(folder) == expected()


def test_a_run_that_fails_is_a_point_with_its_cause(tmp_path, monkeypatch):
    def fails(start, **options):
        if start.scene.slip.modes["2s"].strength == 0.0:
            raise RuntimeError("no room")
        return simulate(start, **options)

    from nrchain.sweeps import point_run

    simulate, folder = point_run.simulate_in_memory, tmp_path / "s"
    monkeypatch.setattr(point_run, "simulate_in_memory", fails)
    found = nrchain.sweep(scene(), GRID, output=folder)
    assert [point.reason for point in found.failed] == 2 * ["RuntimeError: no room"]
    assert [point.values["slip.2s"] for point in found.failed] == [0.0, 0.0]
    assert found.failed[0].observables == {}
    assert nrchain.Sweep.open(folder) == found
    monkeypatch.undo()
    assert nrchain.sweep(scene(), GRID, output=folder) == found
    assert nrchain.sweep(scene(), GRID, output=folder, retry=True) == expected()


def test_a_run_that_stops_keeps_its_cause_and_what_it_reached():
    found = nrchain.sweep(scene(), {"run.max_steps": [3]})
    (point,) = found.points
    assert (point.outcome, point.cause) == ("stopped", "budget-reached")
    assert 0.0 < point.observables["end.time"] < 2.0


def test_own_observables_are_functions_of_the_trajectory():
    def broken(run):
        raise ZeroDivisionError("nothing to divide")

    observe = {
        "tip": lambda run: run.positions[-1, -1, 0],
        "whole": lambda run: np.zeros(3),
        "broken": broken,
        "end.time": "end.time",
    }
    with pytest.warns(nrchain.SceneWarning) as warned:
        found = nrchain.sweep(scene(), {"slip.2s": [7.0]}, observe=observe)
    assert [str(one.message).partition(" at ")[0] for one in warned] == [
        "no value of whole",
        "no value of broken",
    ]
    (point,) = found.points
    run = nrchain.simulate(scene(**{"slip.2s": 7.0}))
    assert point.observables["tip"] == run.positions[-1, -1, 0]
    assert point.observables["broken"] is None
    assert point.unmeasured == {
        "whole": "gives ndarray, and must give one number or word",
        "broken": "ZeroDivisionError: nothing to divide",
    }


def test_the_most_frequent_cause_is_told_for_each_observable():
    def at_times(run):
        if run.time[-1] < 0.5:
            return None
        raise ValueError(f"late, t = {run.time[-1]}" if run.time[-1] > 1.0 else "early")

    grid = {"run.end": [0.25, 1.0, 1.5, 2.0]}
    with pytest.warns(nrchain.SceneWarning, match="no value of mine"):
        found = nrchain.sweep(scene(), grid, observe={"mine": at_times, "end.time": "end.time"})
    (one,) = found.without_value
    assert (one.name, one.points, one.total, one.cause) == (
        "mine",
        4,
        4,
        "ValueError: late, t = 1.5",
    )
    assert "no mine at 4" in repr(found)


def test_reasons_stay_when_an_observable_is_added(tmp_path):
    nrchain.sweep(scene(), {"slip.2s": [7.0]}, observe="end.error", output=tmp_path)
    found = nrchain.sweep(scene(), {"slip.2s": [7.0]}, observe="end.size", output=tmp_path)
    assert found.points[0].unmeasured.keys() == {"end.error"}


def test_there_is_an_observable_for_each_measurement():
    functions = {name for name in nrchain.measure.__all__ if name[0].islower()}
    assert {f"measure.{name}" for name in functions} <= set(NAMED)
    (point,) = nrchain.sweep(
        scene(**{"run.snapshots": 45}), {"slip.2s": [100.0]}, observe=NAMED.keys()
    ).points
    run = nrchain.simulate(scene(**{"run.snapshots": 45, "slip.2s": 100.0}))
    rate = nrchain.measure.rate(nrchain.measure.wave(run))
    assert point.observables["measure.rate"] == rate.growth.value
    assert point.observables["measure.spin"] == nrchain.measure.spin(run).value
    assert point.observables["measure.attractor"] == nrchain.measure.attractor(run).kind
    assert set(point.unmeasured) <= {"end.error"} | {n for n in NAMED if "fit_shape" in n}


def test_another_scene_is_refused_with_what_differs(tmp_path):
    nrchain.sweep(scene(), {"slip.2s": [0.0]}, output=tmp_path)
    with pytest.raises(TrajectoryError, match=r"another sweep: run.end is 2.0 there and 3.0 here"):
        nrchain.sweep(scene(**{"run.end": 3.0}), {"slip.2s": [0.0]}, output=tmp_path)
    replaced = nrchain.sweep(
        scene(**{"run.end": 3.0}), {"slip.2s": [0.0]}, output=tmp_path, overwrite=True
    )
    assert replaced.column("end.time") == [3.0]
    assert json.loads((tmp_path / "request.json").read_text())["run.end"] == 3.0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"grid": {"chain.particles": [1, 5]}}, r"chain.particles = 1: .*1 of 2 points"),
        ({"grid": {"slip.9z": [1.0]}}, "9z"),
        ({"grid": {"slip.2s": []}}, "must have a value"),
        ({"grid": {}}, "must name keys"),
        ({}, "must name keys"),
        ({"points": []}, "must be a list of changes"),
        ({"random": {"slip.2s": (0.0, 0.0)}, "samples": 1}, "two different finite numbers"),
        ({"random": {"slip.2s": (0.0, 1.0, "log")}, "samples": 1}, "above 0"),
        ({"random": {"slip.2s": (0.0, 1.0)}}, "samples"),
        ({"grid": {"slip.2s": [1]}, "points": [{"slip.2s": 2}]}, "varied twice"),
        ({"grid": {"slip.2s": [1]}, "observe": "end.sise"}, "did you mean 'end.size'"),
        ({"grid": {"slip.2s": [1]}, "keep": True}, "needs a folder"),
        ({"grid": {"slip.2s": [1]}, "shard": "1/2"}, "needs a folder"),
        ({"grid": {"slip.2s": [1]}, "shard": "3/2"}, 'as "2/8"'),
        ({"grid": {"slip.2s": [1]}, "workers": 0}, "workers = 0"),
        ({"grid": {"slip.2s": [1]}, "observe": []}, "must have at least one name"),
        ({"grid": {"slip.2s": [1]}, "workers": 1, "processes": 1}, "give one of them"),
        ({"grid": {"slip.2s": [1]}, "executor": 3}, "executor of concurrent.futures"),
        ({"adaptive": {"slip.2s": (0, 1)}, "samples": 2, "grid": {}}, "goes without adaptive"),
        ({"adaptive": {"chain.particles": (4, 9)}, "samples": 2}, "whole numbers"),
        ({"adaptive": {"slip.2s": (0, 1)}, "samples": 2, "target": "end.hand"}, "must be observed"),
    ],
)
def test_bad_input_is_refused_before_any_run(given, words, monkeypatch):
    names = run_count(monkeypatch)
    with pytest.raises(SceneError, match=words):
        nrchain.sweep(scene(), **given)
    assert names == []


def test_a_function_that_processes_cannot_get_is_refused():
    with pytest.raises(SceneError, match="top of a module"):
        nrchain.sweep(scene(), {"slip.2s": [1.0]}, processes=1, observe={"mine": lambda run: 1.0})
