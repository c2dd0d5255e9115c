"""The paper's linearised equations and moduli against the operator of the simulated lattice."""

from __future__ import annotations

import numpy as np
import pytest

from nrchain.errors import SceneError
from nrchain.scene.loading import load_scene
from nrchain.theory.lattice import lattice_operator, lattice_rates, steady_stress
from nrchain.theory.rod import (
    MISPRINTS,
    MODES,
    TABLE,
    Rod,
    beam_rates,
    continuum_operator,
    discrete_operator,
    moduli,
    steady_motion,
)
from nrchain.theory.rod.linear import differences

STRENGTHS = {"2s": 100.0, "3a": 5000.0, "3t": 1000.0, "4a": 10000.0}
RIGID = {"elasticity.twist": 0.0, "elasticity.bend": 0.0}
OWN_UNITS = {"chain.radius": 0.5, "chain.spacing": 3.0, "chain.viscosity": 2.0}
PHASES = np.array([0.02, 0.04, 0.08])


def scene(*modes, stiffness=0.0, **changes):
    table = {
        "chain.particles": 20,
        "run.end": 1.0,
        "elasticity.stretch": stiffness,
        "elasticity.shear": stiffness,
    }
    return load_scene(table | {f"slip.{mode}": STRENGTHS[mode] for mode in modes} | changes)


@pytest.mark.parametrize("mode", MODES)
def test_discrete_equations_are_the_lattice(mode):
    """Appendix C of the paper, term by term, is the linearisation of its pair laws."""
    q = np.linspace(0.01, 0.31, 7)
    for chain in (scene(mode, stiffness=50.0), scene(mode, **RIGID), scene(mode, **OWN_UNITS)):
        expected = lattice_operator(chain, q)
        operator = discrete_operator(Rod.of(chain), q)
        np.testing.assert_allclose(operator, expected, atol=2e-15 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("mode", "name", "rows", "columns"),
    [
        ("4a", "4a force", slice(0, 3), slice(3, 6)),
        ("4a", "4a torque", slice(3, 6), slice(3, 6)),
        ("2s", "differences", slice(0, 3), slice(0, 3)),
    ],
)
def test_misprints_of_the_discrete_equations_show(mode, name, rows, columns):
    """The printed cell, and no other part of a mode's force and torque, is off by a third."""
    chain = scene(mode, stiffness=50.0 if name == "differences" else 0.0, **RIGID)
    expected = lattice_operator(chain, [0.05])[0]
    off = np.abs(discrete_operator(Rod.of(chain), [0.05], misprints=[name])[0] - expected)
    assert off[rows, columns].max() > 0.3 * np.abs(expected[rows, columns]).max()
    if name != "differences":
        off[rows, columns] = 0.0
        assert off.max() < 1e-14 * np.abs(expected).max()


@pytest.mark.parametrize("mode", MODES)
def test_rod_equations_are_the_lattice_to_third_order(mode):
    """Second-order constitutive laws: what they miss of M(q) is of order (qd)³."""
    chain = scene(mode, **RIGID)
    q = PHASES / 10.0
    exact, rod = lattice_operator(chain, q), continuum_operator(Rod.of(chain), q)
    errors = np.abs(rod - exact).max(axis=(1, 2))
    slopes = np.diff(np.log(errors)) / np.log(2.0)
    assert slopes == pytest.approx(3.0, abs=0.05)
    assert errors[0] < 1e-5 * np.abs(exact).max()


@pytest.mark.parametrize(
    ("mode", "name", "order"),
    [("2s", "2s torque", 0), ("3a", "leading moduli", 1), ("4a", "leading moduli", 0)],
)
def test_misprints_of_the_rod_equations_show(mode, name, order):
    """As printed, the torque of the rod is wrong at an order that it claims to have."""
    chain = scene(mode, **RIGID)
    q = PHASES / 10.0
    exact = lattice_operator(chain, q)
    printed = continuum_operator(Rod.of(chain), q, misprints=[name])
    errors = np.abs(printed - exact).max(axis=(1, 2))
    assert np.diff(np.log(errors)) / np.log(2.0) == pytest.approx(order, abs=0.05)


def test_passive_rotation_decays_without_a_derivative():
    chain = scene(stiffness=50.0)
    q = PHASES / 10.0
    gap = 50.0 * 10.0**2 / chain.drag.rotation
    exact = lattice_operator(chain, q)[:, 4, 4]
    np.testing.assert_allclose(continuum_operator(Rod.of(chain), q)[:, 4, 4], exact, rtol=1e-3)
    np.testing.assert_allclose(exact.real, -gap, rtol=0.2)
    printed = continuum_operator(Rod.of(chain), q, misprints=["rotation"])[:, 4, 4]
    assert np.all(np.abs(printed - exact) > 0.9 * gap)


def test_moduli_of_the_steady_state():
    """Prestress, pre-moment, pre-force and pre-torque are those of the simulated chain."""
    chain = scene(*MODES)
    rod, values = Rod.of(chain), moduli(Rod.of(chain))
    velocity, spin = steady_motion(rod)
    assert values["f_pre"] == pytest.approx(rod.Gamma_T * velocity, rel=1e-14)
    assert values["m_pre"] == pytest.approx(rod.Gamma_R * spin, rel=1e-14)
    assert values["F_pre"] == pytest.approx(steady_stress(scene("2s"))[0], rel=1e-14)
    moment = steady_stress(scene("3a"))[3]
    assert values["M_pre"] == pytest.approx(moment, rel=1e-14)
    assert moduli(rod, printed=True)["M_pre"] == pytest.approx(-moment, rel=1e-14)


def test_printed_rows_differ_where_they_say():
    rod = Rod.of(scene(*MODES))
    now, printed = moduli(rod), moduli(rod, printed=True)
    differing = {symbol for symbol in now if now[symbol] != printed[symbol]}
    assert differing == {row.symbol for row in TABLE if row.printed is not None}
    assert all(row.note for row in TABLE if row.printed is not None)
    assert len(now) == len(TABLE) == 28


@pytest.mark.parametrize("mode", MODES)
def test_beam_limit_of_the_chain(mode):
    """Rates of the lattice tend to the beam limit as 1/λ, for either hand and any phase."""
    q = np.array([0.05, 0.15, 0.29])
    limit = beam_rates(Rod.of(scene(mode)), q)
    errors = np.array(
        [
            np.abs(lattice_rates(scene(mode, stiffness=stiffness), q)[:, :2] - limit).max()
            for stiffness in (1e5, 1e6, 1e7)
        ]
    )
    assert errors[1:] / errors[:-1] == pytest.approx(0.1, rel=0.05)
    assert errors[-1] < 3e-5 * np.abs(limit).max()


def effective_bending(mode, coefficient):
    """What the active torque adds to the coefficient of q⁴, over γ_R/γ_T a^p/d^n V."""
    rod = Rod.of(scene(mode, **RIGID))
    q = np.array([0.005])
    theta = q * 10.0
    friction = rod.gamma_R / rod.gamma_T
    force = coefficient(theta) * STRENGTHS[mode]
    inertia = 1.0 + friction * (theta / 10.0) ** 2
    torque = beam_rates(rod, q)[:, 0] * inertia - force
    return complex((torque / (friction * STRENGTHS[mode] * q**4))[0])


@pytest.mark.parametrize("row", TABLE, ids=lambda row: row.symbol)
@pytest.mark.parametrize("printed", [False, True])
def test_every_modulus_has_its_dimension(row, printed):
    """F a force, M times and f over a length; ε a number, τ over a length: lengths are scaled.

    At fixed η and V forces grow as lengths do.
    """
    lengths = ({"chain.radius": 1.3 * k, "chain.spacing": 7.0 * k} for k in (1.0, 2.0))
    own, scaled = (row.value(Rod.of(scene(row.mode, **each)), printed=printed) for each in lengths)
    *_, load, strain = ("", *row.symbol.split("_")[-2:])
    power = 1 + {"F": 0, "M": 1, "f": -1, "m": 0}[load] + {"eps": 0, "tau": 1, "pre": 0}[strain]
    assert scaled == pytest.approx(2.0**power * own, rel=1e-12)


def test_active_bending_moduli_of_the_beam_limit():
    """7/3 for 2s and 121/5 for 4a, where the moduli alone, C_⊥^{Mτ} and C_↺^{Mτ}, give 7/2 and
    1089/20: as for 3a, third derivatives of u in the discrete torque count at this order."""
    d = 10.0
    bending = effective_bending("2s", lambda t: 7 / (3 * d**3) * 2 * (1 - np.cos(t)))
    assert bending * d == pytest.approx(7 / 3, rel=5e-3)

    def odd_force(t):
        first, mean = differences(t)
        return 363j / (5 * d**5) * (first.imag / mean * np.sin(t) - (1 - np.cos(t)))

    odd = effective_bending("4a", odd_force)
    assert odd * d**3 == pytest.approx(121j / 5, rel=5e-3)


def test_scenes_the_theory_does_not_cover_are_refused():
    with pytest.raises(SceneError, match=r"slip\.2s\.axis"):
        Rod.of(scene(**{"slip.2s": {"strength": 1.0, "axis": [0.0, 1.0, 0.0]}}))
    with pytest.raises(SceneError, match=r"slip\.2s"):
        Rod.of(scene(**{"slip.2s": list(range(20))}))
    with pytest.raises(SceneError, match="strengths"):
        Rod(strengths={"5x": 1.0})
    with pytest.raises(SceneError, match=next(iter(MISPRINTS))):
        discrete_operator(Rod(), [0.1], misprints=["no such"])
    flipped = scene(**{"slip.4a": {"strength": 2.0, "axis": [-1.0, 0.0, 0.0]}})
    assert Rod.of(flipped).strengths == {"4a": -2.0}
