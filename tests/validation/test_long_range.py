"""The study of long range fails if a sum, a friction or a scene is slightly off."""

from __future__ import annotations

import numpy as np
import pytest

from nrchain import rod
from validation.long_range import friction, scenes, settling
from validation.long_range import run as long_range
from validation.long_range.runs import simulated_rate
from validation.report.recorder import Recorder


def checks(*parts) -> Recorder:
    recorder = Recorder("long_range", quick=True)
    for part in parts:
        part(recorder)
    return recorder


def test_lattice_sums_hold_and_are_seen_when_one_percent_off(monkeypatch):
    assert not checks(long_range._closed_forms, long_range._limits).failed
    true = rod.reach_ratio
    monkeypatch.setattr(rod, "reach_ratio", lambda *of: 1.01 * true(*of))
    recorder = checks(long_range._closed_forms)
    assert len(recorder.failed) == len(recorder.checks)


def test_a_simulated_chain_has_the_rates_of_the_lattice():
    run = simulated_rate("2s", 16)
    assert run.all == pytest.approx(run.lattice_all, rel=1e-4)
    assert run.ratio == pytest.approx(run.lattice_ratio, rel=1e-4)
    assert run.active == pytest.approx(
        long_range._paper_rate(run) * rod.reach_ratio("2s", run.phase), rel=4e-3
    )


def test_friction_on_the_lattice_holds_and_is_seen_when_one_percent_off(monkeypatch):
    parts = (friction._on_the_lattice, friction._beside_slip)
    assert not checks(*parts).failed
    true = friction.factor
    monkeypatch.setattr(friction, "factor", lambda *of: 1.01 * true(*of))
    recorder = checks(friction._on_the_lattice)
    assert len(recorder.failed) == len(recorder.checks)


def test_two_spheres_know_their_limits(monkeypatch):
    assert settling.along(1e4) - 1 == pytest.approx(1.5e-4, rel=1e-3)
    assert settling.along(1e4, in_step=False) - 1 == pytest.approx(-1.5e-4, rel=1e-3)
    assert not checks(settling._exact, settling._far).failed
    true = settling.rotne_prager_yamakawa
    monkeypatch.setattr(
        settling, "rotne_prager_yamakawa", lambda r, case: 1.01 * (true(r, case) - 1) + 1
    )
    assert len(checks(settling._far).failed) == 2


def test_scenes_that_speed_up_too_little_are_found():
    values = {
        ("buckling", "growth rate"): [1.0, 5.0, 5.0],
        ("helix-left", "growth rate"): [1.0, 1.5, 5.0],
        ("helix-left", "hand"): [-1.0, 1.0, -1.0],
        ("wave", "speed"): [1.0, 1.25, 1.25],
        ("spiral-left", "spin"): [1.0, 1.034, 1.1],
    }
    recorder = checks(lambda recorder: scenes._checks(recorder, values))
    assert [check.name.split(":")[0] for check in recorder.failed] == [
        "torque dipoles",
        "torque dipoles",
        "torque dipoles",
        "wave",
        "spiral-left",
    ]


def test_growth_is_read_between_the_least_height_and_one_radius():
    class Growing:
        time = np.linspace(0, 100, 101)
        positions = np.zeros((101, 3, 3))

    amplitude = 0.05 * np.exp(-Growing.time) + 0.01 * np.exp(0.06 * Growing.time)
    Growing.positions[:, 1, 1] = amplitude
    rate = scenes.growth_rate(Growing)
    assert rate == pytest.approx(0.06, rel=0.02)
