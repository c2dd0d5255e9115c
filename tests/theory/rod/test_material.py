"""Materials: energy and its slope, oddness and work in cycles, sources, dissipation, errors."""

from __future__ import annotations

import numpy as np
import pytest

import nrchain
from nrchain import rod
from nrchain.errors import SceneError, UnknownNameError
from nrchain.scene.loading import load_scene
from nrchain.theory.rod import Material, cycle_work, strain_cycle, uniform_response

RNG = np.random.default_rng(5)
C = RNG.normal(size=(6, 6))
EVEN = C + C.T
X = RNG.normal(size=(3, 6))


def scene(**changes):
    return load_scene({"chain.particles": 12, "run.end": 1.0} | changes)


def test_stress_is_the_slope_of_the_energy():
    material = Material.from_numbers(C=EVEN, prestress=[1, 2, 3, 4, 5, 6])
    step = 1e-4 * np.eye(6)
    slope = [(material.energy(X + s) - material.energy(X - s)) / 2e-4 for s in step]
    np.testing.assert_allclose(material.stress(X), np.transpose(slope), rtol=1e-8)
    assert material.hyperelastic
    assert not material.sourced


def test_an_odd_material_has_no_energy():
    material = Material.from_numbers(C=C)
    assert material.odd
    with pytest.raises(SceneError, match="no energy"):
        material.energy(X)


def test_oddness_within_the_error_does_not_count():
    near = EVEN + 1e-15 * C
    assert Material.from_numbers(C=near).hyperelastic
    assert Material.from_numbers(C=EVEN + 1e-6 * C).odd


def test_errors_of_given_constants_are_those_of_their_block():
    """A stiff bend does not hide the oddness of a soft stretch."""
    soft = np.zeros((6, 6))
    soft[3:, 3:] = 1e12 * np.eye(3)
    soft[:2, :2] = [[1.0, 1e-6], [0.0, 1.0]]
    assert Material.from_numbers(C=soft).odd


def test_work_in_a_cycle_is_the_antisymmetric_part_times_the_area():
    """x₁ = cos φ, x₄ = 2 sin φ encloses 2π counterclockwise."""
    material = Material.from_numbers(C=C, prestress=[3, 0, 0, 1, 0, 0])
    cycle = strain_cycle(np.eye(6)[0], 2.0 * np.eye(6)[3])
    work = material.work(cycle)
    exact = 2 * np.pi * (C[0, 3] - C[3, 0])
    assert work.value == pytest.approx(exact, rel=1e-13)
    assert abs(work.value - exact) <= work.error < 1e-11
    assert material.work(cycle[::-1]).value == pytest.approx(-work.value, rel=1e-13)


def test_work_of_a_nonlinear_stress_converges_at_once():
    """F₁ = −x₂³ on the unit circle does ∮ x₂³ dx₁ = −3π/4."""
    for points in (16, 17, 64):
        cycle = strain_cycle(np.eye(6)[0], np.eye(6)[1], points)
        stresses = np.zeros_like(cycle)
        stresses[:, 0] = -(cycle[:, 1] ** 3)
        work = cycle_work(cycle, stresses)
        assert work.value == pytest.approx(-3 * np.pi / 4, rel=1e-13)
        assert abs(work.value + 3 * np.pi / 4) <= work.error < 1e-13


def test_the_error_of_work_is_that_of_its_points_and_of_its_stresses():
    """F₁ = −x₂¹¹ on eight points of the unit circle is not resolved."""
    cycle = strain_cycle(np.eye(6)[0], np.eye(6)[1], 8)
    stresses = np.zeros_like(cycle)
    stresses[:, 0] = -(cycle[:, 1] ** 11)
    exact = -2 * np.pi * 231 / 1024
    work = cycle_work(cycle, stresses)
    assert 1e-3 < abs(work.value - exact) <= work.error
    known = cycle_work(cycle, 0.0 * stresses, 0.1).error
    assert known == pytest.approx(0.1 * 2 * np.pi / 8 * np.sum(np.abs(cycle)))


def test_work_of_the_chain_is_that_of_its_moduli_to_fourth_order():
    chain = scene(**{"slip.3a": 2000.0, "slip.4a": 3000.0})
    material = Material.of(chain, "cut")
    first, second = X[:2] * np.repeat([0.02, 0.002], 3)
    apart = []
    for size in (1.0, 0.5):
        cycle = strain_cycle(size * first, size * second)
        response = uniform_response(chain, cycle)
        measured = cycle_work(cycle, response.stress, response.error)
        apart.append(measured.value - material.work(cycle).value)
    assert measured.error + material.work(cycle).error < 1e-6 * abs(measured.value)
    assert abs(apart[0]) < 0.05 * abs(material.work(strain_cycle(first, second)).value)
    assert np.log2(apart[0] / apart[1]) == pytest.approx(4.0, abs=0.02)


def test_symbols_of_the_paper_make_the_blocks_they_name():
    """m⋆ = H_↺ e₁ × ε and F = C_⊥ ε_⊥."""
    material = Material.from_symbols(
        Gamma_T=2.0, Gamma_R=3.0, H_odd_m_eps=5.0, C_perp_F_eps=7.0, f_pre=1.0
    )
    shear = [0, 0.1, 0, 0, 0, 0]
    np.testing.assert_allclose(material.stress(shear), [0, 0.7, 0, 0, 0, 0])
    np.testing.assert_allclose(material.source(shear), [1, 0, 0, 0, 0, 0.5])
    np.testing.assert_allclose(material.source(shear, np.ones(6)), [-1, -2, -2, -3, -3, -2.5])
    assert material.dissipation([1, 0, 0, 0, 2, 0]) == pytest.approx(2 + 12)
    assert material.sourced
    assert str(material.symmetry) == "transversely isotropic, polar, achiral"
    with pytest.raises(UnknownNameError, match="H_odd_m_eps"):
        Material.from_symbols(H_odd_m_ep=1.0)


@pytest.mark.parametrize(
    ("slip", "odd", "sourced", "symmetry"),
    [
        ({}, False, False, "apolar, achiral"),
        ({"slip.2s": 50.0}, False, True, "apolar, achiral"),
        ({"slip.3a": 50.0}, True, True, "apolar, chiral"),
        ({"slip.3t": 50.0}, False, True, "polar, achiral"),
        ({"slip.4a": 50.0}, True, True, "polar, chiral, unchanged by a mirror across e₁"),
    ],
)
def test_what_the_modes_make_of_a_chain(slip, odd, sourced, symmetry):
    """In uniform strain; the stress of 3t has an energy, as its flow has a potential."""
    material = Material.of(scene(**slip), "cut")
    assert (material.odd, material.sourced) == (odd, sourced)
    assert str(material.symmetry) == f"transversely isotropic, {symmetry}"


def test_constants_that_depend_on_the_wavelength_need_it():
    chain = scene(**{"slip.2s": 50.0, "slip.neighbours": "all"})
    with pytest.raises(SceneError, match="wavenumber"):
        Material.of(chain)
    near, far = (Material.of(chain, wavenumber=q).constants.symbols() for q in (0.01, 0.001))
    alone = Material.of(scene(**{"slip.2s": 50.0})).constants.symbols()
    assert far["F_pre"] - near["F_pre"] == pytest.approx(np.log(10.0) * alone["F_pre"])
    with pytest.raises(SceneError, match="wavenumber = 0"):
        Material.of(chain, wavenumber=0.0)


def test_a_cycle_and_its_stresses_match():
    with pytest.raises(SceneError, match="stresses"):
        cycle_work(np.zeros((4, 6)), np.zeros((3, 6)))


@pytest.mark.parametrize(
    "numbers",
    [{"C_par_F_eps": np.nan}, {"C_par_F_eps": "a"}, {"Gamma_T": -1.0}, {"Gamma_R": np.inf}],
)
def test_symbols_are_finite_and_drags_are_not_negative(numbers):
    (name,) = numbers
    with pytest.raises(SceneError, match=f"{name} = .*finite number"):
        Material.from_symbols(**numbers)


def test_strains_have_six_numbers():
    with pytest.raises(SceneError, match=r"strains = \(2,\).*six numbers"):
        Material.from_symbols(C_par_F_eps=1.0).stress([1.0, 2.0])


@pytest.mark.parametrize(
    ("mode", "axis", "strength"),
    [
        ("2s", [0.0, 1.0, 0.0], 500.0),
        ("4a", [0.0, 1.0, 0.0], 500.0),
        ("3t", [1.0, 1.0, 0.0], 500.0),
        ("4a", [0.0, 0.8, 0.6], 1e-4),
    ],
)
def test_moduli_have_the_symmetry_of_the_slip(mode, axis, strength):
    """Axes off e₁: entries that vanish by symmetry stay 0 within the rounding of an angle."""
    scene = nrchain.load_scene("passive", **{f"slip.{mode}": {"strength": strength, "axis": axis}})
    assert str(Material.of(scene).symmetry) == str(rod.slip_symmetry(scene))


def test_effects_that_are_still_to_be_chosen_have_no_moduli():
    scene = nrchain.load_scene("buckling", **{"effects": "auto", "tolerance": 0.01})
    for refuses in (nrchain.moduli, nrchain.dispersion):
        with pytest.raises(SceneError, match=r"effects = 'auto'.*must be chosen first"):
            refuses(scene)
