"""A plan's numbers are those of the laws, and there is one for every scene."""

import math

import pytest

import nrchain
from nrchain.errors import SceneError
from nrchain.plan import plan


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
