"""The study of cost fails when a default is too loose, a level is off, or a formula is wrong."""

import pytest

from nrchain import load_scene
from nrchain.accuracy.timing import Measured
from nrchain.run.work import Work
from validation.cost import arcs, reach, resolution, stepping
from validation.cost.results import Map, Setting, marks
from validation.report.recorder import Recorder


def test_a_loose_default_is_seen(monkeypatch):
    monkeypatch.setattr(stepping, "scene_names", lambda: ("passive", "stable"))
    recorder = Recorder("cost", quick=True)
    stepping._defaults(recorder)
    assert not recorder.failed

    loose = Recorder("cost", quick=True)
    keys = {"run.rtol": 1e-1, "run.atol": 1e-1}
    monkeypatch.setattr(stepping, "load_scene", lambda name, **k: load_scene(name, **keys | k))
    stepping._defaults(loose)
    assert len(loose.failed) == 2


def test_the_cheapest_setting_and_its_marks():
    work = Work(1, 1, 1, 1)

    def setting(tolerance, error, seconds):
        return Setting("radau", tolerance, Measured(error, 0.0, work, (seconds,), 0.5, 1e-4))

    loose, default, tight = (
        setting(1e-3, 5e-3, 1.0),
        setting(1e-6, 5e-4, 0.5),
        setting(1e-9, 1e-7, 3.0),
    )
    one = Map("a scene", [loose, default, tight], 1e-10)
    assert one.cheapest(1e-2) is default
    assert one.cheapest(1e-8) is None
    assert marks(one, default) == "default, 1 %, 0.1 %"
    assert marks(one, tight) == "1e-6"
    assert marks(one, loose) == ""


def test_finite_size_helps_a_pair_and_not_a_chain():
    pair = arcs.pair_errors("2s", 10.0).errors
    chain = arcs.chain_errors("2s", 10.0).errors
    assert pair["finite size"] < 2e-3 * pair["leading order"]
    assert chain["finite size"] > 1.5 * chain["leading order"]
    assert 1e-3 < chain["leading order"] < 1e-2


def test_friction_between_spheres_is_worth_three_orders_at_twenty_radii():
    errors = arcs.driven_errors(20.0).errors
    assert errors["pairwise"] < 1e-2 * errors["each by itself"]


@pytest.mark.parametrize(("label", "error"), [("2s", 0.5), ("4a", 0.16)])
def test_rates_with_nearest_neighbours_are_far_off(label, error):
    full, near = (reach._rate(label, k) for k in ("all", 1))
    assert abs(near / full - 1) > error


def test_order_of_the_difference_formulas():
    coarse, fine = (abs(resolution.tilt_over_slope(x) - 1) for x in (0.4, 0.2))
    assert coarse / fine == pytest.approx(16, rel=0.05)
    assert fine == pytest.approx(3 / 160 * 0.2**4, rel=0.02)


def test_spheres_needed_are_the_least():
    n = resolution._needed("2s", 1e-2)
    assert resolution.law_error("2s", n) <= 1e-2 < resolution.law_error("2s", n - 1)
