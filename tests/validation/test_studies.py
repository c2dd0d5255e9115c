"""The registry, the first studies run quickly, and a law that is off by 1 % is found."""

import importlib
from dataclasses import replace

import pytest

from nrchain import slip_modes
from validation.pair_laws import figures
from validation.report import paper
from validation.report.recorder import Recorder
from validation.report.studies import STUDIES, run_study
from validation.rest import run as rest
from validation.rest.measures import RESTING


@pytest.mark.parametrize("name", STUDIES)
def test_every_registered_study_states_its_question(name):
    module = importlib.import_module(STUDIES[name].module)
    assert callable(module.study)
    assert "?" in module.__doc__.splitlines()[0]


def test_pair_laws_hold(monkeypatch):
    monkeypatch.setattr(figures, "draw", lambda recorder, axis: None)
    outcome = run_study("pair_laws", quick=True)
    assert not outcome.error
    assert [check.name for check in outcome.recorder.failed] == []
    assert {check.kind for check in outcome.recorder.checks} == {"check", "difference"}


@pytest.mark.slow
def test_pair_laws_are_drawn():
    outcome = run_study("pair_laws", quick=True)
    assert [picture.name for picture in outcome.recorder.pictures] == [
        "ratios",
        "R3a",
        "finite size",
    ]


@pytest.mark.parametrize("label", paper.LABELS)
def test_a_pair_law_off_by_one_percent_is_found(label, monkeypatch):
    true = paper.velocity
    monkeypatch.setattr(figures, "draw", lambda recorder, axis: None)
    monkeypatch.setattr(
        paper,
        "velocity",
        lambda mode, *where: true(mode, *where) * (1.01 if mode == label else 1.0),
    )
    outcome = run_study("pair_laws", quick=True)
    assert any(label in check.name for check in outcome.recorder.failed)


@pytest.mark.parametrize("label", paper.LABELS)
def test_a_chain_with_a_mode_off_by_one_percent_is_found(label, monkeypatch):
    mode = slip_modes.find(label)
    off = {key: [p * 101 / 100 for p in row] for key, row in mode.velocity.items()}
    monkeypatch.setitem(slip_modes._MODES, label, replace(mode, velocity=off))
    recorder = Recorder("rest", quick=True)
    rest._nearest(recorder, label, RESTING[label])
    assert len(recorder.failed) == len(recorder.checks) == 2
    assert recorder.failed[0].error == pytest.approx(0.01)


@pytest.mark.slow
def test_the_chain_at_rest_holds():
    outcome = run_study("rest", quick=True)
    assert not outcome.error
    assert [check.name for check in outcome.recorder.failed] == []
