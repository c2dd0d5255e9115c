"""Waves of the rod of any material: the paper's equations, the exact lattice, the beam limit."""

from __future__ import annotations

import numpy as np
import pytest

from nrchain.errors import SceneError
from nrchain.scene.loading import load_scene
from nrchain.theory.eigenvalues import follow
from nrchain.theory.lattice import Branch, lattice_operator, lattice_rates
from nrchain.theory.rod import (
    MODES,
    Material,
    Rod,
    base_motion,
    beam_rates,
    continuum_operator,
    rod_symbol,
    rod_waves,
)

STRENGTHS = {"2s": 100.0, "3a": 5000.0, "3t": 1000.0, "4a": 10000.0}
MIXES = {mode: (mode,) for mode in MODES} | {"passive": (), "mix": MODES}
ACROSS = {"slip.2s": {"strength": 50.0, "axis": [0.0, 1.0, 1.0]}}
TILTED = {
    "slip.3t": {"strength": 1000.0, "axis": [1.0, 0.5, 0.0]},
    "slip.4a": {"strength": 1e4, "axis": [1.0, 0.0, 0.0]},
}
Q = np.linspace(0.002, 0.3, 60)


def scene(*modes, **changes):
    table = {"chain.particles": 12, "run.end": 1.0}
    return load_scene(table | {f"slip.{mode}": STRENGTHS[mode] for mode in modes} | changes)


def order(error_at, q=0.01):
    """The order in q of an error."""
    return np.log2(error_at(q) / error_at(q / 2))


@pytest.mark.parametrize("modes", MIXES.values(), ids=MIXES)
def test_the_symbol_is_that_of_the_paper(modes):
    """Tables cont_forces and cont_torques, written from the paper's text."""
    chain = scene(*modes)
    q = np.linspace(-0.3, 0.3, 13)
    expected = continuum_operator(Rod.of(chain), q)
    found = rod_symbol(Material.of(chain)).operator(q)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14 * np.abs(expected).max())


@pytest.mark.parametrize("frame", ["lab", "spinning"])
@pytest.mark.parametrize("modes", MIXES.values(), ids=MIXES)
def test_the_lattice_has_the_operator_of_the_rod_to_third_order(modes, frame):
    chain = scene(*modes)
    symbol = rod_symbol(Material.of(chain), frame=frame)

    def difference(q):
        return np.abs(symbol.operator(q) - lattice_operator(chain, q, frame=frame)).max()

    assert order(difference) > 2.99


@pytest.mark.parametrize("changes", [ACROSS, TILTED], ids=["across", "tilted"])
def test_anisotropic_chains_too(changes):
    """The full 3×3 blocks, also of a chain that spins and moves across itself."""
    chain = scene(**changes)
    material = Material.of(chain)
    symbol = rod_symbol(material, frame="spinning")

    def difference(q):
        return np.abs(symbol.operator(q) - lattice_operator(chain, q, frame="spinning")).max()

    assert order(difference) > 2.99
    rates = rod_waves(material, Q, frame="spinning").rates
    for found, operator in zip(rates, symbol.operator(Q), strict=True):
        expected = np.linalg.eigvals(operator)
        gaps = np.abs(found[:, None] - expected)
        assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("modes", MIXES.values(), ids=MIXES)
def test_branches_are_the_eigenvalues_of_the_symbol(modes):
    material = Material.of(scene(*modes))
    rates, operators = rod_waves(material, Q).rates, rod_symbol(material).operator(Q)
    for found, operator in zip(rates, operators, strict=True):
        expected = np.linalg.eigvals(operator)
        gaps = np.abs(found[:, None] - expected)
        assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) < 1e-12 * np.abs(expected).max()


BENDING = {"passive": 6, "2s": 4, "3a": 3, "3t": 3, "4a": 4}
"""Order in q of what the rod drops: (qd)² times the law, but for 3a the order of the law."""


@pytest.mark.parametrize("name", BENDING)
def test_bending_rates_meet_those_of_the_lattice(name):
    chain = scene(*MIXES[name])
    material = Material.of(chain)

    def full(q):
        return abs(rod_waves(material, [q]).rates[0, 0] - lattice_rates(chain, q)[0])

    def beam(q):
        rates = rod_waves(material, [q], beam=True).rates
        return abs(rates[0, 0] - beam_rates(Rod.of(chain), [q])[0, 0])

    for error_at in (full, beam):
        assert order(error_at) == pytest.approx(BENDING[name], abs=0.06)


@pytest.mark.parametrize("branch", Branch)
def test_columns_are_those_of_the_lattice(branch):
    chain = scene(*MODES)
    rates = rod_waves(Material.of(chain), [0.004]).column(branch)[0]
    lattice = lattice_rates(chain, 0.004)
    assert np.argmin(np.abs(lattice - rates)) == branch


@pytest.mark.parametrize("changes", [{}, ACROSS], ids=["isotropic", "anisotropic"])
def test_the_beam_limit_is_that_of_stiff_rods(changes):
    """Rates approach those of the beam limit as 1/λ."""
    errors = []
    for ratio in (1e9, 1e10):
        material = Material.of(
            scene("2s" if not changes else "3t", **changes, **{"elasticity.ratio": ratio})
        )
        full = rod_waves(material, [0.02]).rates[0]
        beam = rod_waves(material, [0.02], beam=True).rates[0, :2]
        errors.append(np.abs(full[:, None] - beam).min(axis=0).max())
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.01)


@pytest.mark.parametrize("beam", [False, True])
@pytest.mark.parametrize("changes", [{}, ACROSS], ids=["isotropic", "anisotropic"])
def test_the_group_velocity_is_the_slope_of_the_frequency(changes, beam):
    modes = ("3a", "3t") if changes else MODES
    material = Material.of(scene(*modes, **changes))
    q, step = np.array([0.03, 0.1]), 1e-5
    for k in q:
        waves = rod_waves(material, [k - step, k, k + step], beam=beam)
        slope = (waves.frequency[2] - waves.frequency[0]) / (2 * step)
        scale = np.abs(waves.rates).max() / k
        np.testing.assert_allclose(waves.velocities[1], slope, atol=1e-7 * scale)


def test_packets_of_source_dipoles_travel_backwards_along_the_chain():
    """3t: Λ = i(4a³/5d⁴) V qd, so dω/dq = −4a³V/5d³ = −V⁰ (Eqs. 3t_trans_ac_disp and 3t_vel)."""
    chain = scene("3t")
    material = Material.of(chain)
    velocity = rod_waves(material, [1e-3], beam=True).velocities[0, 0]
    assert base_motion(material)[0] == pytest.approx(0.8)
    assert velocity == pytest.approx(-0.8, rel=1e-4)


def test_branches_that_cross_are_followed():
    """±(q − 1/2) cross; sorted values would turn back."""

    def values(q):
        return np.sort_complex(np.array([q - 0.5, 0.5 - q]))

    found = follow(values, np.linspace(0.0, 1.0, 8).astype(complex))
    np.testing.assert_allclose(found[:, 0], np.linspace(-0.5, 0.5, 8), atol=1e-15)


def test_what_has_no_waves_is_refused():
    with pytest.raises(SceneError, match="must be positive definite"):
        rod_waves(Material.from_numbers(C=np.eye(6)), [0.1])
    bent = Material.from_numbers(presource=[0, 0, 0, 0, 1, 0], drag=np.eye(6))
    with pytest.raises(SceneError, match="no straight base state"):
        rod_waves(bent, [0.1])
    with pytest.raises(SceneError, match="frame='spinning'"):
        rod_waves(Material.of(scene(**TILTED)), [0.1])
    with pytest.raises(SceneError, match="wavenumbers"):
        rod_waves(Material.of(scene()), [[0.1]])
