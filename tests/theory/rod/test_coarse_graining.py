"""Moduli of chains: the paper's table, the exact lattice, helices, and the symmetry of the slip."""

from __future__ import annotations

import numpy as np
import pytest
from support.selection import few_of

import nrchain
from nrchain.errors import SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.slip_mode import SlipMode
from nrchain.motion.model import Model
from nrchain.scene.loading import load_scene
from nrchain.theory.lattice import lattice_operator, steady_rotation, steady_velocity
from nrchain.theory.rod import MODES, TABLE, Rod, measured_symmetry, slip_symmetry
from nrchain.theory.rod import moduli as table_moduli
from nrchain.theory.rod.constants import TURN, Constants, cross, parts_of
from nrchain.theory.straight_chain import StraightChain

STRENGTHS = {"2s": 100.0, "3a": 5000.0, "3t": 1000.0, "4a": 10000.0}
OWN_UNITS = {"chain.radius": 0.5, "chain.spacing": 3.0, "chain.viscosity": 2.0}
FLUID = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "bend", "twist")}
ALL = {"slip.neighbours": "all"}
EQUAL = {"C": (slice(0, 3), slice(0, 3)), "H": (slice(0, 6), slice(0, 3))}
"""Blocks on which both ways to assign forces to a cut agree, with H^{fτ}."""


def scene(*modes, **changes):
    table = {"chain.particles": 12, "run.end": 1.0}
    return load_scene(table | {f"slip.{mode}": STRENGTHS[mode] for mode in modes} | changes)


def rod_operator(constants, q):
    """w(q) (6, 6): wrench per length of the linearised rod on plane waves (u, φ)."""
    F, M = constants.prestress[:3], constants.prestress[3:]
    strain = np.zeros((6, 6), complex)
    strain[:3, :3] = strain[3:, 3:] = 1j * q * np.eye(3)
    strain[:3, 3:] = TURN
    stress, source = constants.C @ strain, constants.H @ strain
    stress[:, 3:] -= np.concatenate([cross(F), cross(M)])
    source[:, 3:] -= np.concatenate([cross(part) for part in np.split(constants.presource, 2)])
    wrench = 1j * q * stress + source
    wrench[3:] += TURN @ stress[:3]
    wrench[3:, :3] -= 1j * q * cross(F)
    return wrench


def gradients(operator, q):
    """The terms of zeroth, first and second order in q of an operator given as a function."""
    zero, plus, minus = operator(0.0), operator(q), operator(-q)
    return zero, (plus - minus) / (2j * q), (plus + minus - 2.0 * zero) / (-2.0 * q**2)


@pytest.mark.parametrize("changes", [{}, OWN_UNITS, FLUID], ids=["paper", "own units", "fluid"])
@pytest.mark.parametrize("mode", MODES)
def test_nearest_neighbours_give_the_table_of_the_paper(mode, changes):
    chain = scene(mode, **changes)
    found = nrchain.moduli(chain)
    values, bounds = found.active.symbols(), found.error.symbol_bounds()
    table = table_moduli(Rod.of(chain))
    for symbol, value in values.items():
        exact = table.get(symbol, 0.0)
        assert abs(value - exact) <= bounds[symbol] + 1e-14 * abs(exact), symbol
    for part, whole in zip(parts_of(found.active), parts_of(Constants.named(values)), strict=True):
        np.testing.assert_allclose(part, whole, atol=1e-13 * found.active.largest())


def test_elasticity_gives_its_moduli_alone():
    chain = scene(**{"elasticity.stretch": 5.0, "elasticity.shear": 3.0, "elasticity.bend": 2.0})
    found = nrchain.moduli(chain).elastic
    expected = Constants.named(
        {"C_par_F_eps": 50.0, "C_perp_F_eps": 30.0, "C_par_M_tau": 20.0, "C_perp_M_tau": 20.0}
    )
    assert (found - expected).largest() < 1e-12 * found.largest()


@pytest.mark.parametrize(
    ("modes", "changes"),
    [
        (("2s", "3a"), {"slip.neighbours": 5}),
        (("3t", "4a"), {"slip.neighbours": 5, "chain.radius": 2.0}),
        (("2s",), {"slip.neighbours": 3, "slip.finite_size": True, "chain.radius": 3.0}),
        (("2s",), ALL),
        (("3a",), ALL),
        (("3t",), ALL),
        (("4a",), ALL),
        (MODES, ALL | OWN_UNITS),
    ],
    ids=str,
)
def test_the_rod_has_the_gradients_of_the_exact_lattice(modes, changes):
    """Terms in u, u′, u″, φ, φ′, φ″ of any reach; logarithms of all pairs at their wavenumber."""
    chain = scene(*modes, **FLUID, **changes)
    q = 1e-3 / chain.chain.spacing
    found = nrchain.moduli(chain)
    constants = found.at(q) if "all" in changes.values() else found.total
    friction = np.linalg.inv(found.drag)
    spin = np.zeros((6, 6))
    spin[3:, 3:] = cross(steady_rotation(chain))

    def rod(wave):
        return friction @ rod_operator(constants, wave) + spin

    for mine, exact in zip(
        gradients(rod, q), gradients(lambda k: lattice_operator(chain, k), q), strict=True
    ):
        np.testing.assert_allclose(mine, exact, atol=2e-5 * np.abs(exact).max())
    np.testing.assert_allclose(friction @ found.total.presource, [
        *steady_velocity(chain), *steady_rotation(chain)
    ], rtol=1e-12, atol=1e-15)  # fmt: skip


@pytest.mark.parametrize(
    ("mode", "symbols"),
    [
        ("2s", {"F_pre": 1.0, "C_par_F_eps": 1.0, "C_perp_F_eps": 1.0, "C_perp_M_tau": 1.0}),
        ("3a", {"C_perp_F_tau": 1.0, "H_odd_m_tau": 1.0}),
        ("3t", {"C_odd_F_tau": 1.0, "H_perp_m_tau": 1.0}),
        ("4a", {}),
    ],
)
def test_all_pairs_leave_logarithms_with_the_coefficients_of_nearest_neighbours(mode, symbols):
    """Σ 1/m is that of the nearest alone, times 3/2 + ln(1/qd)."""
    near = nrchain.moduli(scene(mode)).active.symbols()
    found = nrchain.moduli(scene(mode, **ALL)).logarithm.symbols()
    if mode == "3a":  # the part of the torque decays faster, and has a sum
        near["H_odd_m_tau"] = -near["C_perp_F_tau"]
    for symbol, value in found.items():
        assert value == pytest.approx(symbols.get(symbol, 0.0) * near[symbol], abs=1e-9), symbol


def test_friction_between_neighbours_multiplies_wrenches_by_the_friction_of_the_chain():
    """μ(q) w(q) is the twist that slip gives a wave."""
    changes = {"friction": {"kind": "pairwise", "neighbours": 4}, "slip.neighbours": 2}
    chain = scene("2s", "3a", "3t", **FLUID, **changes)
    found, straight = nrchain.moduli(chain), StraightChain(chain)
    d, V0 = chain.chain.spacing, cross(steady_velocity(chain))
    moved = np.zeros((6, 6))
    moved[:3, 3:] = V0
    W0 = np.zeros((6, 6))
    W0[:3, 3:] = d * cross(found.total.presource[:3])

    def rod(wave):
        wrench = d * rod_operator(found.total, wave) + W0
        return straight.mobility(np.asarray(wave * d)) @ wrench - moved

    q = 1e-3 / d
    for mine, exact in zip(
        gradients(rod, q), gradients(lambda k: lattice_operator(chain, k), q), strict=True
    ):
        np.testing.assert_allclose(mine, exact, atol=2e-5 * np.abs(exact).max())
    np.testing.assert_allclose(found.drag, np.linalg.inv(straight.mobility(np.zeros(()))) / d)


@pytest.fixture
def own_modes():
    """A vortex ring of order 4, apolar and chiral, and a potential quadrupole, of a user."""
    chiral = SlipMode("5v", "vortices", 5, False, True, {("x", 5): (0, -3, 0, 7)})
    flow = {("n", 4): ("-3/2", 0, "15/2"), ("e", 4): (0, -3)}
    achiral = SlipMode("4p", "potential quadrupole", 4, False, False, flow)
    registered = [slip_modes.register(chiral), slip_modes.register(achiral)]
    yield [mode.label for mode in registered]
    for mode in registered:
        slip_modes.unregister(mode.label)


def random_mix(seed, labels):
    """Two to four modes with random strengths; two thirds of the mixes have axes off e₁."""
    rng = np.random.default_rng(seed)
    chosen = rng.choice(labels, size=rng.integers(1, 5), replace=False)
    slip = {}
    for label in chosen:
        axis = rng.choice([-1.0, 1.0]) * np.eye(3)[0] if seed % 3 else rng.normal(size=3)
        if seed % 9 == 3:
            axis = np.eye(3)[rng.integers(3)]
        slip[f"slip.{label}"] = {"strength": 10.0 * rng.normal(), "axis": axis.tolist()}
    return load_scene({"chain.particles": 6, "chain.spacing": 4.0, "run.end": 1.0} | slip | FLUID)


@pytest.mark.parametrize("stress", ["linear", "cut"])
@pytest.mark.parametrize("seed", few_of(range(12), {0, 1, 3}))
def test_measured_moduli_have_the_symmetry_of_the_slip(seed, stress, own_modes):
    chain = random_mix(seed, [*MODES, *own_modes])
    found, predicted = nrchain.moduli(chain, stress), slip_symmetry(chain)
    assert found.symmetry.symbols() == predicted.symbols()
    bounds = found.error + Constants.of().map(lambda part: part + 1e-12 * found.total.largest())
    for value, mask, bound in zip(
        *map(parts_of, (found.total, predicted.allowed(), bounds)), strict=True
    ):
        assert (np.abs(value) <= bound)[~mask].all()
    measured = measured_symmetry(found.total, bounds)
    for name in ("isotropic", "apolar", "achiral", "centred"):
        assert getattr(measured, name) >= getattr(predicted, name), name


@pytest.mark.parametrize("seed", few_of(range(0, 24, 3), {0, 3}))
def test_moduli_of_any_axes_are_the_gradients_of_the_simulated_wrenches(seed, own_modes):
    """Blocks of the middle sphere of an open chain, summed over waves; axes off e₁."""
    reach = 1 + seed % 2
    chain = load_scene(random_mix(seed, [*MODES, *own_modes]), **{"slip.neighbours": reach})
    count, d = 2 * reach + 1, chain.chain.spacing
    model = Model(load_scene(chain, **{"chain.particles": count}))
    blocks = np.zeros((count, 2 * model.reach + 1, 6, 6))
    positions = d * np.arange(count)[:, None] * np.eye(3)[0]
    model.linearise(positions, np.tile(np.eye(3), (count, 1, 1)), blocks)
    row = blocks[reach, model.reach - reach : model.reach + reach + 1]
    offsets, friction = d * np.arange(-reach, reach + 1), np.repeat(chain.drag, 3) / d

    def simulated(q):
        return friction[:, None] * np.einsum("m,mij->ij", np.exp(1j * q * offsets), row)

    constants, q = nrchain.moduli(chain).total, 1e-3 / d
    for mine, exact in zip(
        gradients(lambda k: rod_operator(constants, k), q), gradients(simulated, q), strict=True
    ):
        np.testing.assert_allclose(mine, exact, atol=2e-5 * np.abs(exact).max())


@pytest.mark.parametrize("seed", few_of(range(12), {0, 1, 3}))
def test_both_stresses_agree_where_linear_response_fixes_them(seed, own_modes):
    """C^{Fε}, H^{fε}, H^{fτ}, H^{mε}, F̃ and the pre-sources: helices against Jacobian blocks."""
    chain = random_mix(seed, [*MODES, *own_modes])
    linear, cut = (nrchain.moduli(chain, stress) for stress in ("linear", "cut"))
    bound = 1e-12 * linear.total.largest() + cut.error.largest()
    difference = (linear.total - cut.total).map(np.abs)
    for name, index in EQUAL.items():
        assert getattr(difference, name)[index].max() <= bound
    assert difference.H[:3].max() <= bound
    assert difference.prestress[:3].max() <= bound
    assert difference.presource.max() <= bound


def test_a_field_along_the_axes_of_the_spheres_is_a_presource():
    field = {"field": {"body_force": [1.0, 2.0, 3.0], "body_torque": [0.0, 0.0, 4.0]}}
    for stress in ("linear", "cut"):
        given = nrchain.moduli(scene("2s", **field), stress).total.presource
        assert given == pytest.approx([0.1, 0.2, 0.3, 0.0, 0.0, 0.4])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"slip.2s": [1.0] * 11 + [2.0]}, r"slip\.2s = .*varies from sphere to sphere"),
        ({"field.force": [0, 0, 1]}, r"field = .*varies along a strained chain with its direction"),
        ({"flow.gradient": [[0, 1, 0], [0, 0, 0], [0, 0, 0]]}, r"^flow.*(varies|not part)"),
        ({"friction": "pairwise"}, r"friction\.neighbours = 'all'.*no limit"),
    ],
)
def test_scenes_without_uniform_states_are_refused_with_what_varies(changes, said):
    with pytest.raises(SceneError, match=said):
        nrchain.moduli(scene(**changes))


def test_an_unknown_stress_is_refused():
    with pytest.raises(SceneError, match="stress = 'cauchy'"):
        nrchain.moduli(scene("2s"), "cauchy")


def test_a_table_entry_off_by_one_percent_is_found():
    for row in TABLE:
        if row.terms:
            chain = scene(row.mode)
            value = nrchain.moduli(chain).active.symbols()[row.symbol]
            assert abs(value / (1.01 * row.value(Rod.of(chain))) - 1.0) > 5e-3
