"""The study of the solid holds, and a coefficient that is off by 1 % is found."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from support.selection import few_of

import nrchain
from nrchain import Material, slip_modes
from nrchain.theory.rod import helix, linear_response, symmetry
from validation.report.recorder import Recorder
from validation.report.studies import run_study
from validation.report.uniform_chains import STRENGTHS, uniform_chain
from validation.solid import moduli, waves, work
from validation.solid import symmetry as symmetry_study


@pytest.fixture
def recorder():
    return Recorder("solid", quick=True)


def failed(recorder):
    return {check.name for check in recorder.failed}


@pytest.mark.slow
def test_the_study_holds():
    outcome = run_study("solid", quick=True)
    assert not outcome.error
    assert failed(outcome.recorder) == set()
    assert [picture.name for picture in outcome.recorder.pictures] == [
        *("pinch", "response", "work")
    ]


@pytest.mark.parametrize("label", few_of(STRENGTHS, {"2s", "4a"}))
def test_a_mode_off_by_one_percent_is_found_in_every_modulus(label, monkeypatch, recorder):
    mode = slip_modes.find(label)
    off = {key: [p * 101 / 100 for p in row] for key, row in mode.velocity.items()}
    monkeypatch.setitem(slip_modes._MODES, label, dataclasses.replace(mode, velocity=off))
    moduli._table(recorder, "a/d = 0.1", {})
    moduli._cut(recorder, "a/d = 0.1", {})
    own = [check for check in recorder.checks if check.name.startswith(label)]
    assert len(own) > 6
    assert failed(recorder) == {check.name for check in own}


def test_sums_over_neighbours_off_by_one_percent_are_found(monkeypatch, recorder):
    exact = linear_response._sum

    def wrong(power, reach):
        factor = 1.0 if reach == 1 else 1.01
        return tuple(factor * part for part in exact(power, reach))

    monkeypatch.setattr(linear_response, "_sum", wrong)
    moduli._reaches(recorder)
    moduli._logarithms(recorder)
    lattice = {check.name for check in recorder.checks if "of the lattice" in check.name}
    assert len(lattice) == 5
    assert failed(recorder) == {check.name for check in recorder.checks} - lattice


def test_lever_arms_off_by_one_percent_are_found(monkeypatch, recorder):
    """3t then does work, and the prestress of 2s bends the chain otherwise."""
    carry = helix.Helix.carry

    def wrong(self, wrenches, places):
        carried, free = carry(self, wrenches, places), np.array(wrenches)
        free[..., :3] = 0.0
        own = carry(self, free, places)[:, 3:]
        carried[:, 3:] = own + 1.01 * (carried[:, 3:] - own)
        return carried

    monkeypatch.setattr(helix.Helix, "carry", wrong)
    work._source_dipole(recorder)
    moduli._cut(recorder, "a/d = 0.1", {})
    names = " ".join(failed(recorder))
    assert "3t: work of the chain at finite strain" in names
    assert "2s, uniform strain: C_perp_M_tau" in names


def test_work_off_by_one_percent_is_found(monkeypatch, recorder):
    measured = work.measured
    monkeypatch.setattr(work, "measured", lambda scene, cycle: 1.01 * measured(scene, cycle))
    for name in ("3a", "4a", "mix"):
        work._general(recorder, name)
    work._planes(recorder)
    assert len(failed(recorder)) == len(recorder.checks) == 8


def test_oddness_of_one_percent_of_a_modulus_is_found(monkeypatch, recorder):
    """2s and 3t do no work to second order; one off-diagonal entry too large changes that."""

    def odd(scene, cycle):
        C = np.zeros((6, 6))
        C[1, 0] = 0.01 * np.abs(Material.of(scene, "cut").constants.C).max()
        return Material.from_numbers(C=C).work(cycle).value

    measured = work.measured
    monkeypatch.setattr(work, "measured", lambda s, cycle: measured(s, cycle) + odd(s, cycle))
    for name in ("2s", "3t"):
        work._general(recorder, name)
    zeros = {check.name for check in recorder.checks if check.predicted == 0}
    assert len(zeros) == 2
    assert zeros <= failed(recorder)


def test_a_wrong_sign_of_one_vector_is_found(monkeypatch, recorder):
    kind = symmetry.Kind(True, True)
    monkeypatch.setattr(symmetry, "SOURCES", (kind, symmetry.SOURCES[1]))
    symmetry_study._classes(recorder)
    assert sum("H_" in name or "f_pre" in name for name in failed(recorder)) == 7


def test_a_forbidden_entry_of_one_percent_is_found():
    found = nrchain.moduli(uniform_chain({"2s": 100.0}, {}))
    assert symmetry_study.forbidden(found) < 1.0
    entry = nrchain.rod.Constants.named({"C_odd_F_eps": 0.01 * found.active.largest()})
    assert symmetry_study.forbidden(dataclasses.replace(found, active=found.active + entry)) > 1e6


@pytest.mark.parametrize("label", STRENGTHS)
def test_a_mode_off_by_one_percent_is_found_in_the_symbol(label, monkeypatch, recorder):
    mode = slip_modes.find(label)
    off = {key: [p * 101 / 100 for p in row] for key, row in mode.velocity.items()}
    monkeypatch.setitem(slip_modes._MODES, label, dataclasses.replace(mode, velocity=off))
    waves._symbol(recorder, label, uniform_chain({label: STRENGTHS[label]}, {}))
    assert f"{label}: largest difference of the symbol" in " ".join(failed(recorder))


def test_a_pinch_off_by_one_percent_is_found(monkeypatch, recorder):
    exact = waves.rod.rod_instability

    def wrong(material, **options):
        found = exact(material, **options)
        return dataclasses.replace(found, rate=1.01 * found.rate)

    monkeypatch.setattr(waves.rod, "rod_instability", wrong)
    waves._pushes(recorder, 800.0)
    assert len(recorder.failed) == 1
