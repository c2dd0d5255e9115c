"""Uniform strain: energy of springs, balance and power of the simulated wrenches, closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import nrchain
from nrchain.errors import SceneError
from nrchain.scene.loading import load_scene
from nrchain.theory.rod import Rod, uniform_response
from nrchain.theory.rod.constants import cross
from nrchain.theory.rod.helix import Helix

STRENGTHS = {"2s": 100.0, "3a": 5000.0, "3t": 1000.0, "4a": 10000.0}
FLUID = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "bend", "twist")}
STRAIN = np.array([0.1, -0.05, 0.08, 0.02, -0.03, 0.015])
SPRINGS = {"stretch": 40.0, "shear": 25.0, "twist": 300.0, "bend": 500.0}


def scene(slip=STRENGTHS, **changes):
    table = {"chain.particles": 12, "run.end": 1.0} | FLUID
    return load_scene(table | {f"slip.{mode}": v for mode, v in slip.items()} | changes)


def helix(strain, places):
    """Poses by the matrix exponential of the motion along the rod."""
    motion = np.zeros((4, 4))
    motion[:3, :3], motion[:3, 3] = cross(strain[3:]), strain[:3] + np.eye(3)[0]
    matrices = np.array([expm(s * motion) for s in places])
    return matrices[:, :3, 3], matrices[:, :3, :3].swapaxes(1, 2).copy()


@pytest.mark.parametrize("size", np.geomspace(1e-9, 0.3, 8))
def test_poses_are_those_of_the_exponential_of_the_motion(size):
    strain = STRAIN * np.repeat([1.0, size / 0.04], 3)
    places = np.array([-7.0, 0.0, 0.3, 10.0, 25.0])
    for mine, exact in zip(Helix(strain).poses(places), helix(strain, places), strict=True):
        np.testing.assert_allclose(mine, exact, atol=1e-13)


@pytest.mark.parametrize("measure", ["paper", "isotropic"])
def test_the_stress_of_springs_is_the_slope_of_their_energy(measure):
    """F = ∂𝓔/∂ε, M = ∂𝓔/∂τ at a large strain, with 𝓔 the energy of one more link over d."""
    springs = {f"elasticity.{name}": value for name, value in SPRINGS.items()}
    chain = scene({}, **springs, **{"elasticity.measure": measure})

    def energy(strain):
        lengths = [
            nrchain.elastic_energy(
                *helix(strain, 10.0 * np.arange(n)), spacing=10.0, **SPRINGS, measure=measure
            )
            for n in (9, 10)
        ]
        return (lengths[1] - lengths[0]) / 10.0

    steps = np.diag(np.repeat([1e-3, 1e-4], 3))
    weights = ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))
    slope = [
        sum(w * (energy(STRAIN + n * step) - energy(STRAIN - n * step)) for n, w in weights)
        / step.sum()
        for step in steps
    ]
    found = uniform_response(chain, STRAIN)
    np.testing.assert_allclose(found.stress, slope, rtol=1e-8, atol=1e-8)
    assert not found.source.any()


@pytest.mark.parametrize("reach", [1, 3])
def test_stress_and_sources_balance_the_wrench_on_every_sphere(reach):
    """Wrench per length = (f, m) + (Π × F, Π × M + h × F), from the forces on a long helix."""
    chain = scene(**{"slip.neighbours": reach})
    positions, frames = helix(STRAIN, 10.0 * np.arange(-4, 5))
    wrenches = nrchain.active_wrenches(positions, frames, STRENGTHS, neighbours=reach)
    middle = np.concatenate([frames[4] @ part[4] for part in wrenches]) / 10.0
    found = uniform_response(chain, STRAIN)
    F, M = np.split(found.stress, 2)
    h, pi = STRAIN[:3] + np.eye(3)[0], STRAIN[3:]
    turned = np.concatenate([np.cross(pi, F), np.cross(pi, M) + np.cross(h, F)])
    np.testing.assert_allclose(
        found.source + turned, middle, rtol=1e-11, atol=1e-12 * np.abs(middle).max()
    )


def test_the_stress_has_the_power_of_the_chain():
    """−∮ of F·ε̇ + M·τ̇ is the power of (W_ij − W_ji)/2 in the relative motion of the pairs."""
    chain, count = scene(), 4
    rate, step = np.array([0.3, 0.2, -0.1, 0.02, 0.01, -0.03]), 1e-5
    places = 10.0 * np.arange(count)
    positions, frames = helix(STRAIN, places)
    after, before = (helix(STRAIN + sign * step * rate, places) for sign in (1, -1))
    velocities = (after[0] - before[0]) / (2 * step)
    turns = np.einsum("nka,nkb->nab", (after[1] - before[1]) / (2 * step), frames)
    spins = np.stack([turns[:, 2, 1], turns[:, 0, 2], turns[:, 1, 0]], axis=1)
    # twists and wrenches about the origin
    twists = np.concatenate([velocities - np.cross(spins, positions), spins], axis=1)
    power = 0.0
    for i in range(count - 1):
        pair = slice(i, i + 2)
        force, torque = nrchain.active_wrenches(positions[pair], frames[pair], STRENGTHS)
        wrench = np.concatenate([force, torque + np.cross(positions[pair], force)], axis=1)
        power += 0.5 * (wrench[0] - wrench[1]) @ (twists[i] - twists[i + 1])
    found = uniform_response(chain, STRAIN).stress
    assert power == pytest.approx(-30.0 * found @ rate, rel=1e-8)


def cut_table(rod):
    """Moduli of uniform strain where they differ from Table moduli, by hand: over Γ^T V.

    Nearest neighbours; ``r`` is Γ^R/Γ^T d².
    """
    a, d, r = rod.radius, rod.spacing, rod.Gamma_R / rod.Gamma_T / rod.spacing**2
    return {
        "2s": {"C_perp_M_tau": (-7 / 4 * r + 7 / 36) * a**2 * d},
        "3a": {
            "C_perp_F_tau": -13 / 24 * a**3 / d,
            "C_perp_M_eps": (-13 / 6 * r + 13 / 24) * a**3 / d,
            "H_odd_m_tau": (-13 / 12 * r + 13 / 24) * a**3 / d,
        },
        "3t": {
            "C_odd_F_tau": a**3 / (10 * d),
            "C_odd_M_eps": -(a**3) / (10 * d),
            "H_perp_m_tau": a**3 / (10 * d),
        },
        "4a": {"C_odd_M_tau": (-1089 / 40 * r + 363 / 40) * a**4 / d},
    }


@pytest.mark.parametrize("mode", STRENGTHS)
def test_moduli_of_uniform_strain_are_the_closed_forms(mode):
    """Half of the paper's for wrenches that depend on the axis of one sphere, and lever arms."""
    chain = scene({mode: STRENGTHS[mode]}, **{"chain.radius": 2.0, "chain.spacing": 7.0})
    found, linear = (nrchain.moduli(chain, stress) for stress in ("cut", "linear"))
    rod = Rod.of(chain)
    by_hand = {s: v * rod.Gamma_T * STRENGTHS[mode] for s, v in cut_table(rod)[mode].items()}
    expected = linear.active.symbols() | by_hand
    bounds = found.error.symbol_bounds()
    size = max(map(abs, expected.values()))
    for symbol, value in found.active.symbols().items():
        assert abs(value - expected[symbol]) <= bounds[symbol] + 1e-13 * size, symbol


def test_all_pairs_are_those_of_the_spheres_of_the_scene():
    every, eleven = (
        uniform_response(scene(**{"slip.neighbours": reach}), 0.02 * STRAIN).stress
        for reach in ("all", 11)
    )
    np.testing.assert_array_equal(every, eleven)


def test_a_long_chain_of_all_pairs_has_moduli():
    """The bends of the differences stay far from a closed circle; C_perp_F_eps is a sum of 1/m."""
    count = 700
    chain = scene({"2s": 1.0}, **{"slip.neighbours": "all", "chain.particles": count})
    found = nrchain.moduli(chain, "cut").active.symbols()["C_perp_F_eps"]
    near = nrchain.moduli(scene({"2s": 1.0}), "cut").active.symbols()["C_perp_F_eps"]
    assert found / near == pytest.approx(np.sum(1.0 / np.arange(1, count)), rel=1e-9)


def test_strains_keep_their_shape():
    found = uniform_response(scene(), np.zeros((2, 3, 6)))
    assert found.stress.shape == found.source.shape == (2, 3, 6)


@pytest.mark.parametrize(
    ("changes", "strain", "said"),
    [
        ({}, [-0.85, 0, 0, 0, 0, 0], r"strains = .*distance of 1\.5: it must stay above 2"),
        ({"slip.neighbours": 3}, [0, 0, 0, 0, 0, 0.2], r"strains = .*distance"),
        ({"friction": "pairwise"}, [0] * 6, r"friction\.kind = 'pairwise'.*'one-body'"),
        ({}, [0, 0, 0], r"strains = .*\(\.\.\., 6\)"),
        ({"field.force": [0, 0, 1]}, [0] * 6, r"field = .*direction"),
    ],
)
def test_what_has_no_uniform_state_is_refused(changes, strain, said):
    with pytest.raises(SceneError, match=said):
        uniform_response(scene(**changes), strain)
