"""Waves of the modes of finite chains: the bulk equation, a ring, hands, ends and refusals."""

from __future__ import annotations

import numpy as np
import pytest

import nrchain
from nrchain.comoving.relative import RelativeChain
from nrchain.errors import SceneError
from nrchain.states.search import state_near

OTHER = {"chain.radius": 1.3, "chain.spacing": 7.0, "chain.viscosity": 1.7, "elasticity.ratio": 1e7}


def scene(name, **changes):
    return nrchain.load_scene(name, **OTHER | changes)


def bulk_operator(chain):
    """z ↦ Σ_m B_m z^m (6, 6), from the derivative of the simulation at the middle sphere."""
    state = state_near(chain, None)
    model = RelativeChain(chain, state.poses).at(state.poses).chain.model
    blocks = np.empty((model.count, 2 * model.reach + 1, 6, 6))
    model.linearise(*state.poses, blocks)
    middle, reach = blocks[model.count // 2], model.reach
    return lambda z: sum(middle[reach + m] * z**m for m in range(-reach, reach + 1))


@pytest.mark.parametrize(
    ("name", "count", "cap"), [("buckling", 24, 1e-3), ("helix-left", 40, 1e-3)]
)
def test_main_waves_solve_the_bulk_equation(name, count, cap):
    """det(M(q) − Λ) = 0 at the complex q of a mode, whatever the ends do."""
    chain = scene(name, **{"chain.particles": count})
    found = nrchain.mode_waves(nrchain.dispersion(chain))
    operator = bulk_operator(chain)
    assert len(found.rates) > 0.95 * 6 * (count - 2)
    errors = [
        np.abs(np.linalg.eigvals(operator(np.exp(1j * q * chain.chain.spacing))) / rate - 1.0).min()
        for rate, q in zip(found.rates, found.wavenumbers, strict=True)
    ]
    assert np.quantile(errors, 0.95) < cap


@pytest.mark.parametrize(("name", "free"), [("buckling", 18), ("stable", 18), ("spiral-left", 19)])
def test_modes_along_a_chain_are_as_many_as_its_free_spheres(name, free):
    """Stretch and twist have one each, bending and shear two."""
    found = nrchain.mode_waves(nrchain.dispersion(nrchain.load_scene(name)))
    counts = np.bincount(found.branches, minlength=len(nrchain.Branch))
    assert counts[[nrchain.Branch.STRETCH, nrchain.Branch.TWIST]].sum() == 2 * free
    assert counts.sum() == 6 * free


@pytest.mark.parametrize("name", ["buckling", "wave", "spiral-left"])
def test_modes_of_a_ring_are_waves_of_the_lattice(name):
    """q = 2πk/(Nd), and Λ of the branch at that q, in the lab also where the chain spins."""
    chain = scene(name, **{"chain.particles": 17, "chain.ends": "periodic"})
    found = nrchain.mode_waves(nrchain.dispersion(chain))
    turns = found.wavenumbers * 17 * chain.chain.spacing / (2.0 * np.pi)
    assert np.abs(turns - np.round(turns.real)).max() < 1e-9
    rates = nrchain.lattice_rates(chain, found.wavenumbers.real)
    nearest = np.abs(rates - found.rates[:, None]).min(axis=1)
    assert nearest.max() < 1e-12 * np.abs(rates).max()


def test_modes_of_polar_chains_pile_up_at_an_end():
    """Im q changes its sign with the strength of 3t, and is 0 without it."""
    ends = []
    for strength in (50.0, -50.0, 0.0):
        chain = scene("wave", **{"slip.3t": strength})
        found = nrchain.mode_waves(nrchain.dispersion(chain))
        bending = found.branches == nrchain.Branch.BEND_PLUS
        slow = np.argsort(-found.rates.real[bending])[:4]
        ends.append(found.wavenumbers.imag[bending][slow])
    # opposite strengths pull and push the links: the waves are not quite mirror images
    assert np.all(ends[0] * ends[1] < 0.0)
    assert np.abs(ends[:2]).min() > 1e-3
    assert np.abs(ends[2]).max() < 0.1 * np.abs(ends[:2]).min()


@pytest.mark.parametrize("count", [15, 201])
def test_chains_of_few_or_many_spheres_are_refused(count):
    found = nrchain.dispersion(scene("buckling", **{"chain.particles": count}))
    with pytest.raises(SceneError, match=rf"chain.particles = {count}.* from 16 to 200"):
        nrchain.mode_waves(found)
