"""The study of spectra: its rod, and a coefficient that is off by 1 %."""

from dataclasses import replace

import pytest
from support.selection import few_of

from nrchain import slip_modes
from validation.report.recorder import Recorder
from validation.spectrum import run
from validation.spectrum.cases import NEAR


def test_the_rod_has_the_closed_loads_and_rates():
    recorder = Recorder("spectrum", quick=True)
    run._rod(recorder)
    assert len(recorder.checks) == 3
    assert not recorder.failed


@pytest.mark.parametrize("case", few_of(NEAR[:2], NEAR[:1]), ids=lambda case: case.title)
def test_chains_tend_to_the_rod_and_a_mode_off_by_one_percent_does_not(case, monkeypatch):
    recorder = Recorder("spectrum", quick=True)
    run._against_the_rod(recorder, case, (40, 80))
    assert not recorder.failed
    mode = slip_modes.find(case.label)
    off = {key: [p * 101 / 100 for p in row] for key, row in mode.velocity.items()}
    monkeypatch.setitem(slip_modes._MODES, case.label, replace(mode, velocity=off))
    recorder = Recorder("spectrum", quick=True)
    run._against_the_rod(recorder, case, (40, 80))
    assert any("over that of the rod" in check.name for check in recorder.failed)


@pytest.mark.slow
@pytest.mark.parametrize("case", NEAR, ids=lambda case: case.title)
def test_thresholds_in_runs_are_those_of_the_spectrum(case):
    recorder = Recorder("spectrum", quick=True)
    run._against_runs(recorder, case, 20)
    assert recorder.checks
    assert not recorder.failed
