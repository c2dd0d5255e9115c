"""The study of continuum laws fails when a law, its next order or the simulation is off."""

from dataclasses import replace

import pytest

from nrchain.analysis.measure import Estimate
from nrchain.theory.rod import dispersion
from validation.continuum import run as continuum
from validation.continuum.runs import LONGITUDINAL, MODES, Series
from validation.report.recorder import Recorder

LENGTHS = (16, 28, 48, 80)


def held_against_all(series: Series, spoil=lambda point: point) -> Recorder:
    """The checks of one series at its largest strengths."""
    recorder = Recorder("continuum", quick=True)
    strengths = (series.strengths[0], series.strengths[-1])
    points = [spoil(series.run(v, n)) for v in strengths for n in LENGTHS]
    continuum._against_lattice(recorder, series, points)
    continuum._against_law(recorder, series, *continuum._active(series, points))
    return recorder


@pytest.mark.parametrize("series", [MODES["2s"], MODES["3a"], LONGITUDINAL], ids=lambda s: s.title)
def test_each_law_holds_to_its_own_order(series):
    assert not held_against_all(series).failed


@pytest.mark.parametrize("label", MODES)
def test_a_law_one_per_cent_off_is_seen(label, monkeypatch):
    law = dispersion.TRANSVERSE[label]
    wrong = law._replace(coefficient=1.01 * law.coefficient)
    monkeypatch.setitem(dispersion.TRANSVERSE, label, wrong)
    failed = [check.name for check in held_against_all(MODES[label]).failed]
    assert any("over the law" in name for name in failed)


def test_a_wrong_next_order_is_seen():
    wrong = replace(MODES["4a"], next=1.05 * MODES["4a"].next)
    names = [check.name for check in held_against_all(wrong).failed]
    assert any("coefficient of (qd)²" in name for name in names)


def test_a_simulation_off_by_a_thousandth_is_seen():
    def spoil(point):
        growth = Estimate(1.001 * point.rate.growth.value, point.rate.growth.error)
        return replace(point, rate=replace(point.rate, growth=growth))

    names = [check.name for check in held_against_all(MODES["2s"], spoil).failed]
    assert any("lattice" in name for name in names)
