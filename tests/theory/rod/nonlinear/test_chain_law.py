"""The rod of a scene: its law against the exact lattice, and its motion against the chain."""

import math

import numpy as np
import pytest

import nrchain
from nrchain import Rod, SceneError, rod
from nrchain.theory.rod.nonlinear.chain_law import chain_law

BASE = {
    "chain": {"particles": 10, "radius": 0.8, "spacing": 7.0, "viscosity": 1.3},
    "elasticity": {"stretch": 1e14, "shear": 1e14},
    "run": {"end": 1.0},
}
STRENGTHS = {"2s": 100.0, "3a": 5000.0, "3t": 1000.0, "4a": 10000.0}


@pytest.mark.parametrize("label", STRENGTHS)
def test_bending_waves_are_those_of_the_lattice_to_relative_order_two(label):
    """Also for 3a, of which linear moduli have 3/2 of the rate."""
    scene = nrchain.load_scene(BASE, **{f"slip.{label}": STRENGTHS[label], "slip.neighbours": 1})
    material, _ = chain_law(scene)
    errors = []
    for q in (0.01, 0.005):
        expected = rod.beam_rates(Rod.of(scene), [q])[0, 0]
        found = rod.rod_waves(material, [q], beam=True).rates[0, :2]
        errors.append(float(np.abs(found - expected).min() / abs(expected)))
    assert errors[0] < 3e-3
    assert math.log2(errors[0] / errors[1]) > 1.85


@pytest.mark.parametrize("shear", [1e4, 100.0])
def test_rods_of_3a_that_shear_have_the_bending_waves_of_the_lattice(shear):
    """Stress and source of the strain gradient enter apart; without one the error would be 1/q²."""
    soft = {"stretch": shear, "shear": shear, "bend": 0.0, "twist": 100.0}
    scene = nrchain.load_scene(BASE, **{"elasticity": soft, "slip.3a": 5000.0})
    material, _ = chain_law(scene)
    for q in (0.01, 0.005):
        lattice = nrchain.lattice_rates(scene, [q])[0, :2]
        found = rod.rod_waves(material, [q]).rates[0]
        for expected in lattice:
            assert np.abs(found - expected).min() < 12.0 * q**2 * abs(expected)


def test_second_order_is_the_curvature_of_the_uniform_response():
    scene = nrchain.load_scene(
        BASE,
        **{f"slip.{k}": v for k, v in STRENGTHS.items()},
        **{"slip.neighbours": 1, "elasticity.stretch": 30.0, "elasticity.shear": 40.0},
    )
    from nrchain.theory.rod.nonlinear.chain_law import second_order
    from nrchain.theory.rod.uniform_chain import UniformChain

    quadratic = second_order(scene, UniformChain(scene))
    x = np.array([0.3, -0.2, 0.4, 0.02, -0.03, 0.01])
    residuals = []
    for size in (0.02, 0.01):
        states = size * np.array([x, -x, 0 * x])
        found = rod.uniform_response(scene, states)
        both = np.hstack([found.stress, found.source])
        even = 0.5 * (both[0] + both[1]) - both[2]
        model = np.einsum("rab,a,b->r", quadratic, states[0], states[0])
        residuals.append(np.abs(even - model) / np.abs(even).max())
    assert residuals[0].max() < 2e-3
    assert math.log2(residuals[0].max() / residuals[1].max()) > 1.8


def test_nodes_lie_between_the_spheres():
    scene = nrchain.load_scene(BASE, **{"slip.neighbours": 1, "chain.particles": 20})
    shape = rod.rod_of(scene)
    strain = np.array([0.01, 0.0, 0.0, 0.002, 0.0, 0.004])
    from nrchain.theory.rod.helix import Helix

    spheres = Helix(strain).poses(7.0 * np.arange(20))
    for found, expected in zip(rod.node_poses(shape, *spheres), shape.bent(strain), strict=True):
        assert np.abs(found - expected).max() < 1e-9


def test_a_scene_without_uniform_strain_is_refused():
    with pytest.raises(SceneError, match=r"friction\.kind"):
        nrchain.rod_of(nrchain.load_scene(BASE, **{"friction.kind": "pairs"}))


def test_chain_approaches_its_rod():
    """A free arc of all four modes: the distance over L falls as (d/L)²."""
    from validation.rod.cases import CASES, distance

    far, near = (distance(CASES["mix"], spheres, tolerance=1e-6) for spheres in (25, 49))
    assert 1.6 < math.log2(far / near) < 2.4
