"""A plan's numbers are those of the laws, and there is one for every scene."""

import math

import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneError
from nrchain.estimate import carry_on, estimate_effects
from nrchain.plan import plan
from nrchain.plan_effects import COLUMNS, plan_effects
from nrchain.scene_changes import changes_of


def lines(name, **changes):
    return {line.quantity: line for line in plan(nrchain.load_scene(name, **changes)).lines}


@pytest.mark.parametrize("name", nrchain.scene_names())
def test_shipped_scenes_have_a_plan_without_warnings(name):
    told = plan(nrchain.load_scene(name))
    assert not told.warnings
    assert {"closest approach", "rates", "growth", "rounding"} <= {x.quantity for x in told.lines}


def test_motion_is_that_of_the_paper():
    spin = lines("spiral-left", **{"run.end": 100.0})["spins"]
    assert "-7.26" in spin.value
    assert f"{-7.26 * 100 / (2 * math.pi):.4g} turns" in spin.meaning
    assert lines("wave")["swims"].value == "V₀ = 0.8"


def test_growth_is_the_largest_rate_of_the_lattice():
    told = lines("buckling")["growth"]
    rate = float(told.value.split()[0])
    wave = float(told.value.split()[-1]) / 10.0
    rates = nrchain.lattice_rates(nrchain.load_scene("buckling"), [wave]).real
    assert rate == pytest.approx(rates.max(), rel=1e-2)
    assert lines("stable")["growth"].value == "none"


def test_the_beam_limit_is_told_with_its_numbers():
    told = lines("buckling", **{"chain.particles": 64})["stretch"]
    assert "-44/1.6 = 28" in told.value


def test_what_the_reach_leaves_out_vanishes_with_it():
    near, far = (
        float(lines("buckling", **{"slip.neighbours": k})["reach"].value.split()[0]) for k in (1, 8)
    )
    assert far < 0.5 * near
    assert "reach" not in lines("buckling", **{"slip.neighbours": "all"})


def test_chains_without_plane_waves_say_so():
    told = lines("buckling", **{"slip.2s": [100.0] * 10 + [-100.0] * 10})
    assert "one number for all" in told["straight chain"].meaning


def test_a_start_that_a_run_would_refuse_is_refused():
    with pytest.raises(SceneError, match="turned by"):
        plan(nrchain.load_scene("buckling", **{"start.amplitude": 50.0}))


def test_tolerances_below_rounding_are_announced_with_a_floor():
    scene = nrchain.load_scene(
        "buckling", **{"elasticity.ratio": 1e12, "chain.particles": 64, "run.atol": 1e-13}
    )
    told = [text for text in plan(scene).warnings if "rounding" in text]
    assert len(told) == 1
    floor = float(told[0].split()[-1])
    looser = nrchain.load_scene(scene, **{"run.atol": 2 * floor})
    assert not plan(looser).warnings


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
    assert found["slip beyond nearest"].scene.slip.neighbours == 1
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
    assert {row[0] for row in effects.rows()} > {"stretch", "friction between spheres"}
    assert any("tolerance 3e-05" in note for note in effects.notes())
