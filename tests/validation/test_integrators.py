"""The study of integrators: its scenes and classes, its ratios, and a bad integrator is found."""

import numpy as np
import pytest

import nrchain
from validation.integrators import promise
from validation.integrators import run as integrators
from validation.integrators.runs import INTEGRATORS, TOLERANCES, Mapped, Run, map_scene, shorten
from validation.integrators.scenes import CLASSES, NEAR, QUICK, classes, scenes
from validation.report.recorder import Recorder


def power_law(name, factors, seconds=None, floor=0.0):
    """A scene in which the error of each integrator is its factor times the tolerance."""
    runs = tuple(
        Run(one, t, "completed", factors[one] * t, 0.0, 1, 1, 1, (seconds or {}).get(one, 1.0) / t)
        for one in INTEGRATORS
        for t in TOLERANCES
    )
    return Mapped(name, 1.0, (CLASSES[0], NEAR), 0.0, floor, floor, runs)


def test_the_map_has_shipped_scenes_gallery_and_forty_random_scenes():
    found = scenes()
    assert set(nrchain.scene_names()) <= set(found)
    assert sum(name.startswith("random ") for name in found) == 40
    assert len(found) > 60
    assert set(QUICK) <= set(found)
    groups = [set(classes(scene)) for scene in found.values()]
    assert set().union(*groups) == set(CLASSES)
    assert all("all scenes" in group for group in groups)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, {"near neighbours", "free", "one-body friction"}),
        ({"chain.ends": "periodic"}, {"near neighbours", "periodic", "one-body friction"}),
        ({"slip.2s": 1.0, "slip.neighbours": 3}, {"near neighbours", "free", "one-body friction"}),
        ({"slip.2s": 1.0, "slip.neighbours": "all"}, {"all pairs", "free", "one-body friction"}),
        ({"friction": "pairwise"}, {"all pairs", "free", "pairwise friction"}),
    ],
)
def test_classes_follow_from_reach_ends_and_friction(changes, expected):
    table = {"chain": {"particles": 12}, "run": {"end": 1.0}}
    scene = nrchain.load_scene(nrchain.load_scene(table), **changes)
    assert set(classes(scene)) == expected | {"all scenes"}


def test_a_scene_that_stops_is_run_to_a_time_before_it():
    changes = {"chain.particles": 64, "run.end": 200.0, "chain.ends": "free"}
    torn = nrchain.load_scene("buckling", **changes)
    stop = nrchain.simulate(torn).time[-1]
    end = shorten(torn).run.end
    assert 0.5 * stop < end < stop
    assert nrchain.simulate(nrchain.load_scene(torn, **{"run.end": end})).status == "completed"


def test_errors_of_a_real_scene_fall_with_the_tolerance():
    changes = {"chain.particles": 6, "run.end": 5.0, "run.snapshots": 5}
    one = map_scene("passive", nrchain.load_scene("passive", **changes), (1e-3, 1e-6), 1)
    assert one.apart < 1e-9
    for integrator in INTEGRATORS:
        loose, tight = one.completed(integrator)
        assert one.floor < tight.error < 0.05 * loose.error < 1e-3
        assert 0 < loose.steps < tight.steps


def test_ratios_leave_out_runs_finer_than_their_reference():
    one = power_law("a", {"cvode": 30.0, "radau": 0.3, "scipy-bdf": 3.0}, floor=1e-7)
    found = promise.ratios([one], "cvode")
    assert found == pytest.approx([30.0] * 3)  # 1e-3, 1e-4, 1e-5
    assert promise.below(found) == 0.0
    assert promise.within(promise.ratios([one], "radau")) == 1.0


def test_a_calibration_divides_the_error_over_tolerance():
    spread = np.geomspace(1.0, 1e3, 101)
    found = [
        power_law(str(k), dict.fromkeys(INTEGRATORS, factor)) for k, factor in enumerate(spread)
    ]
    largest = promise.largest_calibration(found, "cvode")
    exact = promise.FACTOR / np.quantile(spread, promise.PART)
    assert exact / 10 ** (1 / promise.GRID) < largest.factor <= exact
    assert largest.below >= promise.PART
    closest = promise.closest_calibration(found, "cvode")
    assert closest.within == pytest.approx(2.0 / 3.0, abs=0.02)  # two of three decades


def test_times_at_equal_error_are_interpolated_on_a_power_law():
    factors = {"cvode": 10.0, "radau": 0.1, "scipy-bdf": 10.0}
    one = power_law("a", factors, {"scipy-bdf": 7.0})
    ratio, count = promise.speed([one], "scipy-bdf", "cvode", 3e-5)
    assert (ratio, count) == (pytest.approx(7.0), 1)
    ratio, _ = promise.speed([one], "radau", "cvode", 3e-5)
    assert ratio == pytest.approx(0.01)  # the same error at a tolerance 100 times as large
    assert np.isnan(promise.seconds_at(one.completed("cvode"), 1e-9))
    assert promise.seconds_at(one.completed("cvode"), 1.0) == pytest.approx(1e3)


@pytest.mark.parametrize("factor", [1.0, 5000.0])
def test_an_integrator_whose_errors_are_too_large_is_found(factor, monkeypatch):
    found = [power_law("a", {"cvode": 5.0, "radau": factor, "scipy-bdf": 5.0})]
    monkeypatch.setattr(integrators, "_map", lambda recorder: (found, {}))
    recorder = Recorder("integrators", quick=True)
    integrators.study(recorder)
    failed = [check.name for check in recorder.failed]
    assert all("radau" in name for name in failed)
    assert bool(failed) == (factor > 1000.0)
