"""The study of the rod holds, and a coefficient that is off by 1 % is found."""

from __future__ import annotations

import dataclasses

import pytest

from validation.report.recorder import Recorder
from validation.report.studies import run_study
from validation.rod import cases, run
from validation.rod.cases import CASES


@pytest.mark.slow
def test_the_study_holds():
    outcome = run_study("rod", quick=True)
    assert not outcome.error
    # ratios of times belong to a quiet machine
    assert {check.name for check in outcome.recorder.failed if check.kind != "shortfall"} == set()
    assert [picture.name for picture in outcome.recorder.pictures] == ["shapes"]


@pytest.mark.parametrize(
    "name", ["2s", *(pytest.param(name, marks=pytest.mark.slow) for name in CASES if name != "2s")]
)
def test_a_rod_off_by_one_percent_is_found(name, monkeypatch):
    exact = cases.rod_motion

    def wrong(case, scene, **options):
        groups = {label: 1.01 * group for label, group in case.groups.items()}
        stronger = cases.chain_of(dataclasses.replace(case, groups=groups), scene.chain.particles)
        return exact(case, stronger, **options)

    monkeypatch.setattr(cases, "rod_motion", wrong)
    recorder = Recorder("rod")
    run.compare(recorder, name, CASES[name], run.SPHERES)
    assert recorder.failed
