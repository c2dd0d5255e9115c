"""The study of linear response holds, and fails if a coefficient is 1 % off."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.selection import few_of

from nrchain import slip_modes
from nrchain.theory.rod import dispersion, linear
from validation.linear_response import laws, misprints
from validation.linear_response import run as linear_response
from validation.report.recorder import Recorder
from validation.report.studies import run_study
from validation.report.uniform_chains import STRENGTHS


def failed(*parts) -> list[str]:
    recorder = Recorder("linear_response", quick=True)
    for part in parts:
        part(recorder)
    return [check.name for check in recorder.failed]


def test_the_study_holds():
    outcome = run_study("linear_response", quick=True)
    assert not outcome.error
    assert [check.name for check in outcome.recorder.failed] == []
    assert [picture.name for picture in outcome.recorder.pictures] == ["order", "dispersion"]


@pytest.mark.parametrize("label", few_of(STRENGTHS, {"4a"}))
def test_a_mode_off_by_one_percent_is_found(label, monkeypatch):
    mode = slip_modes.find(label)
    off = {key: [p * 101 / 100 for p in row] for key, row in mode.velocity.items()}
    monkeypatch.setitem(slip_modes._MODES, label, replace(mode, velocity=off))
    names = failed(linear_response._discrete_equations, laws._laws)
    assert {f"{label}: linearised force, all components"} <= set(names)
    assert any(name.startswith(f"{label}: law less lattice") for name in names)
    assert all(name.startswith(label) for name in names)


@pytest.mark.parametrize("label", STRENGTHS)
def test_a_law_off_by_one_percent_is_found(label, monkeypatch):
    law = dispersion.TRANSVERSE[label]
    wrong = law._replace(coefficient=1.01 * law.coefficient)
    monkeypatch.setitem(dispersion.TRANSVERSE, label, wrong)
    names = failed(laws._laws)
    assert names
    assert all(name.startswith(label) for name in names)


def test_a_misprint_that_is_gone_is_found(monkeypatch):
    monkeypatch.setattr(linear, "_PRINTED_TERMS", {})
    names = failed(misprints.differences)
    assert [name[:16] for name in names] == ["4a force of φ, p", "4a torque of φ, "]
