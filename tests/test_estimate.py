"""What is estimated of an effect before a run is what runs with and without it show."""

import itertools
import math
import time

import numpy as np
import pytest

import nrchain
from nrchain.estimate import carry_on, estimate_effects
from nrchain.plan_effects import COLUMNS, plan_effects
from nrchain.scene_changes import changes_of

SHORT = {"run.end": 30.0, "run.snapshots": 3, "chain.particles": 12}


def test_estimates_are_the_differences_of_whole_runs():
    scene = nrchain.load_scene("wave", **SHORT)
    run = nrchain.simulate(scene)
    told = estimate_effects(scene).estimates
    assert {(one.change.effect, one.change.kind) for one in told} >= {
        ("bend", "drop"),
        ("slip 3t", "drop"),
        ("slip of all pairs", "add"),
        ("friction between spheres", "add"),
    }
    assert all(one.source == "probe" for one in told)
    for one in told:
        if one.change.effect in ("slip 3t", "slip of all pairs", "friction between spheres"):
            other = nrchain.simulate(one.change.scene)
            apart = np.linalg.norm(run.positions[-1] - other.positions[-1], axis=1).max()
            assert one.displacement == pytest.approx(apart, rel=0.05)


def test_effects_are_named_with_the_scene_that_lacks_or_has_them():
    scene = nrchain.load_scene(
        "buckling", **{"slip.neighbours": 4, "slip.finite_size": True, "friction": "pairwise"}
    )
    found = {change.effect: change for change in changes_of(scene)}
    assert found["reach"].scene.slip.neighbours == 1
    assert found["slip of all pairs"].scene.slip.neighbours == "all"
    assert found["finite size"].kind == "drop"
    assert found["friction between spheres"].scene.friction.kind == "one-body"
    without = found["shear"].scene.moduli
    assert without == scene.moduli._replace(shear=0.0)
    assert not found["slip 2s"].scene.slip.modes


def test_the_growth_of_an_effect_is_that_of_the_lattice():
    scene = nrchain.load_scene("buckling", **SHORT)
    told = estimate_effects(scene, budget=1e-6)
    one = next(e for e in told.estimates if e.change.effect == "slip 2s")
    rates = (
        nrchain.lattice_rates(s, [told.wave])[0, nrchain.Branch.BEND_PLUS].real
        for s in (scene, one.change.scene)
    )
    assert one.growth == pytest.approx(np.subtract(*rates), rel=1e-9)


def test_a_difference_is_carried_on_by_its_own_law():
    times = np.linspace(0.0, 10.0, 41)
    growing = 1e-3 * np.exp(0.5 * times)
    assert carry_on(times, growing, 20.0, 1.0, 1e9) == pytest.approx(1e-3 * math.exp(10.0))
    assert carry_on(times, growing, 20.0, 1.0, 2.0) == 2.0
    assert carry_on(times, growing, 20.0, 0.1, 1e9) == pytest.approx(growing[-1] * math.exp(1.0))
    assert carry_on(times, 0.3 * times, 20.0, 1.0, 1e9) == pytest.approx(6.0)
    assert carry_on(times, np.exp(-times), 20.0, 1.0, 1e9) == math.exp(-10.0)


def test_a_table_of_effects_has_a_cell_for_every_column():
    effects = plan_effects(nrchain.load_scene("passive", **{"run.end": 1.0}))
    assert all(len(row) == len(COLUMNS) for row in effects.rows())
    assert {row[0] for row in effects.rows()} > {"stretch", "+ friction between spheres"}
    assert any("tolerance 3e-05" in note for note in effects.notes())


def test_a_plan_does_not_depend_on_the_clock(monkeypatch):
    """A machine on which every look at the clock takes an hour foretells the same."""
    scene = nrchain.load_scene("passive", **{"run.end": 1.0, "chain.particles": 6})
    quick = plan_effects(scene)
    hours = itertools.count(step=3600.0)
    for name in ("perf_counter", "process_time", "monotonic", "time"):
        monkeypatch.setattr(time, name, lambda: next(hours))
    slow = plan_effects(scene)
    assert slow.seconds > 3600.0
    assert slow.estimates == quick.estimates
    assert slow.probe == quick.probe
    assert [row[:-1] for row in slow.rows()] == [row[:-1] for row in quick.rows()]
