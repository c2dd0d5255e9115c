"""Estimates of an effect agree with runs with and without it."""

import itertools
import time
from dataclasses import replace

import numpy as np
import pytest

import nrchain
from nrchain import work
from nrchain.accuracy.effect_cells import COLUMNS
from nrchain.accuracy.plan_effects import plan_effects
from nrchain.planning.effect_changes import possible_changes
from nrchain.planning.estimate import estimate_effects
from nrchain.planning.shared_steps import largest_distance

SHORT = {"run.end": 30.0, "run.snapshots": 3, "chain.particles": 12}


@pytest.mark.slow
def test_estimates_are_the_differences_of_whole_runs():
    scene = nrchain.load_scene("wave", **SHORT)
    run = nrchain.simulate(scene)
    estimated = estimate_effects(scene).estimates
    assert {(one.change.effect, one.change.kind) for one in estimated} >= {
        ("bend", "drop"),
        ("slip 3t", "drop"),
        ("slip of all pairs", "add"),
        ("friction between spheres", "add"),
    }
    assert all(one.ends and not one.stops for one in estimated)
    for one in estimated:
        if one.change.effect in ("slip 3t", "slip of all pairs", "friction between spheres"):
            other = nrchain.simulate(one.change.scene)
            apart = np.linalg.norm(run.positions[-1] - other.positions[-1], axis=1).max()
            assert one.displacement == pytest.approx(apart, rel=0.05)


def test_effects_are_named_with_the_scene_that_lacks_or_has_them():
    scene = nrchain.load_scene(
        "buckling", **{"slip.neighbours": 4, "slip.finite_size": True, "friction": "pairwise"}
    )
    found = {change.effect: change for change in possible_changes(scene)}
    assert found["reach"].scene.slip.neighbours == 1
    assert found["slip of all pairs"].scene.slip.neighbours == "all"
    assert found["finite size"].kind == "drop"
    assert found["friction between spheres"].scene.friction.kind == "one-body"
    without = found["shear"].scene.moduli
    assert without == scene.moduli._replace(shear=0.0)
    assert not found["slip 2s"].scene.slip.modes


def test_the_growth_of_an_effect_is_that_of_the_lattice():
    scene = nrchain.load_scene("buckling", **SHORT)
    estimated = estimate_effects(scene, budget=1e-6)
    one = next(e for e in estimated.estimates if e.change.effect == "slip 2s")
    rates = (
        nrchain.lattice_rates(s, [estimated.wave])[0, nrchain.Branch.BEND_PLUS].real
        for s in (scene, one.change.scene)
    )
    assert one.growth == pytest.approx(np.subtract(*rates), rel=1e-9)


def test_a_change_that_is_costly_holds_up_no_other():
    """Without shear this chain slides along its own bonds, at ten times the steps."""
    scene = nrchain.load_scene("helix-left")
    changes = [c for c in possible_changes(scene) if c.effect in ("shear", "slip 3a")]
    estimated = {e.change.effect: e for e in estimate_effects(scene, changes, budget=0.5).estimates}
    assert estimated["slip 3a"].ends
    assert estimated["slip 3a"].until == scene.run.end
    assert not estimated["shear"].ends
    assert 0.0 < estimated["shear"].until < scene.run.end
    assert estimated["shear"].displacement > 0.0


def test_where_a_run_stops_the_difference_is_that_of_its_stop():
    scene = nrchain.load_scene("spiral-left")
    changes = [c for c in possible_changes(scene) if c.effect == "twist"]
    one = estimate_effects(scene, changes).estimates[0]
    assert one.ends
    assert "the run without it stops: link-turned" in one.stops
    early = {"run.end": 0.999 * one.until, "run.snapshots": 2}
    runs = [nrchain.simulate(nrchain.load_scene(s, **early)) for s in (scene, one.change.scene)]
    found = largest_distance(
        *((run.positions[-1], run.frames[-1]) for run in runs), scene.chain.radius
    )
    assert (one.displacement, one.turn) == pytest.approx(found, rel=0.05)


def test_what_the_probe_does_not_reach_is_marked_and_what_it_cannot_see_is_unknown():
    scene = nrchain.load_scene("buckling", **SHORT)
    found = plan_effects(scene, estimate_effects(scene, budget=0.02))
    assert all("*" in row[3] and "*" in row[4] for row in found.rows())
    assert all("the end is not known" in remark for remark in found.remarks())
    none = plan_effects(scene, estimate_effects(scene, budget=0.0))
    assert all(row[3:5] == ("?", "?") for row in none.rows())


@pytest.mark.parametrize("budget", [0.0, 0.02, 3.0])
@pytest.mark.parametrize("name", ["buckling", "wave"])
def test_what_is_said_below_a_table_explains_the_marks_in_it_and_no_others(name, budget):
    scene = nrchain.load_scene(name, **SHORT)
    found = plan_effects(scene, estimate_effects(scene, budget=budget))
    shown = " ".join(cell for row in found.rows() for cell in row)
    below = " ".join([*found.remarks(), *found.notes()])
    for mark, meaning in (("*", "* is at t"), ("?", "? is not"), ("+ ", "+ marks effects")):
        assert (mark in shown) == (meaning in below), (mark, shown, below)
    assert ("times the work of the run" in below) == (found.estimates.probed > 0.0)
    assert f"the run: {found.cost.words()}" in below


def test_without_effects_to_add_no_sign_for_them_is_explained():
    everything = {"slip.neighbours": "all", "slip.finite_size": True, "friction": "pairwise"}
    scene = nrchain.load_scene("buckling", **SHORT, **everything)
    effects = plan_effects(scene, estimate_effects(scene, budget=0.0))
    assert not any(row[0].startswith("+") for row in effects.rows())
    assert not any("+ marks" in note for note in effects.notes())


def test_velocities_that_look_alike_are_shown_once():
    scene = nrchain.load_scene("wave", **SHORT)
    shown = [row[1] for row in plan_effects(scene).rows()]
    assert any("–" in cell for cell in shown)
    for cell in shown:
        least, sign, most = cell.partition("–")
        assert not sign or least != most


def test_a_table_of_effects_has_a_cell_for_every_column():
    effects = plan_effects(nrchain.load_scene("passive", **{"run.end": 1.0}))
    assert all(len(row) == len(COLUMNS) for row in effects.rows())
    assert {row[0] for row in effects.rows()} > {"stretch", "+ friction between spheres"}
    assert any("tolerance 3e-06" in note for note in effects.notes())


def test_a_plan_does_not_depend_on_the_clock(monkeypatch):
    """A clock that advances by an hour at every reading gives the same plan."""
    scene = nrchain.load_scene("passive", **{"run.end": 1.0, "chain.particles": 6})
    quick = plan_effects(scene)
    hours = itertools.count(step=3600.0)
    for name in ("perf_counter", "process_time", "monotonic", "time", "thread_time"):
        monkeypatch.setattr(time, name, lambda: next(hours))
    monkeypatch.setattr(work, "clock", lambda: next(hours))
    slow = plan_effects(scene)
    assert slow.cost.seconds > 3600.0
    assert slow.cost.work == quick.cost.work
    assert slow.estimates == quick.estimates
    assert slow.probe == quick.probe
    assert [row[:-1] for row in slow.rows()] == [row[:-1] for row in quick.rows()]


def test_a_change_that_the_scene_does_not_allow_has_a_row_with_the_reason():
    """A net force on a periodic chain has no sum of its flows."""
    pulled = {"chain.ends": "periodic", "field.force": [0.0, 0.0, -1.0]}
    effects = plan_effects(nrchain.load_scene("passive", **SHORT, **pulled))
    refused = [row for row in effects.rows() if "not possible" in row]
    assert [row[0] for row in refused] == ["+ friction between spheres"]
    assert len(refused[0]) == len(COLUMNS)
    assert any("has a net force" in remark for remark in effects.remarks())


def test_the_time_of_an_effect_is_what_it_takes_or_would_add():
    scene = nrchain.load_scene("passive", **SHORT)
    plan = plan_effects(scene, estimate_effects(scene, budget=0.0))
    for own, dropped, added, taken, brought in (
        (4.0, 3.0, 5.0, "+25 %", "+25 %"),
        (4.0, 5.0, 3.0, "-25 %", "-25 %"),
        (0.0, 1.0, 1.0, "+0 %", "+0 %"),
    ):
        kinds = [one.change.kind for one in plan.estimates.estimates]
        assert set(kinds) == {"drop", "add"}
        times = [dropped if kind == "drop" else added for kind in kinds]
        rows = replace(plan, own=own, others=times).rows()
        for kind, row in zip(kinds, rows, strict=False):
            assert row[COLUMNS.index("cost")] == (taken if kind == "drop" else brought)


def test_the_reach_of_a_disturbed_flow_is_a_change():
    sheared = {"flow.gradient": [[0.0, 0.01, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}
    near = sheared | {"flow.neighbours": 2}
    for name, flow, expected in (
        ("passive", sheared, {"finite size of strain"}),
        ("passive", near, {"finite size of strain", "strain of all pairs"}),
        ("buckling", sheared, {"finite size", "finite size of strain", "slip of all pairs"}),
    ):
        changes = possible_changes(nrchain.load_scene(name, **SHORT, **flow))
        added = {c.effect: c.scene for c in changes if c.kind == "add"}
        assert set(added) == expected | {"friction between spheres"}
        assert added["finite size of strain"].flow.finite_size
        assert "strain of all pairs" not in added or (
            added["strain of all pairs"].flow.neighbours == "all"
        )
