"""The repulsion: gradient, derivative, symmetry, and pairs found wherever they are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.poses import dense, pose_derivative, random_chain

import nrchain
from nrchain.geometry.near_pairs import closest_pair
from nrchain.motion.model import Model
from nrchain.outcome import Cause
from nrchain.potential.repulsion import Repulsion

PERIODS = [0.0, 14.0]
KINDS = ["wca", "harmonic"]


def crowd(count=7, seed=0):
    """Spheres about 2 apart, so that most of them repel others along the chain and across."""
    return random_chain(count, spacing=2.0, noise=0.3, seed=seed)


def forces(kind, positions, period=0.0, reach=2.6):
    wrenches = np.zeros((len(positions), 6))
    energy = Repulsion(kind, 3.0, reach, period).add_wrenches(positions, wrenches)
    return energy, wrenches


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("kind", KINDS)
def test_forces_are_minus_the_gradient_of_the_energy(kind, period):
    positions, frames = crowd()
    slope = pose_derivative(lambda r, e: forces(kind, r, period)[0], positions, frames)
    assert forces(kind, positions, period)[1] == pytest.approx(-slope, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("kind", KINDS)
def test_derivative_against_differences_and_symmetric(kind, period):
    positions, frames = crowd()
    repulsion = Repulsion(kind, 3.0, 2.6, period)
    repulsion.linearise(positions)
    products = np.zeros((7, 6, 7, 6))
    for sphere in range(7):
        for component in range(6):
            unit, out = np.zeros((7, 6)), np.zeros((7, 6))
            unit[sphere, component] = 1.0
            repulsion.add_product(unit, out)
            products[:, :, sphere, component] = out
    numeric = pose_derivative(lambda r, e: forces(kind, r, period)[1], positions, frames)
    assert products == pytest.approx(numeric, rel=1e-6, abs=1e-5)
    assert products == pytest.approx(products.transpose(2, 3, 0, 1), rel=1e-12, abs=1e-12)
    blocks = np.zeros((7, 7, 6, 6))
    repulsion.add_blocks(blocks)
    if period:
        assert dense(blocks, True) == pytest.approx(products)


def energy_over_images(kind, positions, period, strength=3.0, reach=2.6):
    """Σ φ(|r_i − r_j + p P x|) over pairs and all images p near enough, by the formulas."""
    total, sigma = 0.0, reach / 2 ** (1 / 6)
    away = int(np.ceil(np.ptp(positions[:, 0]) / period)) + 1
    for i in range(len(positions)):
        for j in range(i):
            for p in range(-away, away + 1):
                r = np.linalg.norm(positions[i] - positions[j] + [p * period, 0.0, 0.0])
                if r >= reach:
                    continue
                if kind == "wca":
                    total += 4 * strength * ((sigma / r) ** 12 - (sigma / r) ** 6 + 0.25)
                else:
                    total += strength / 2 * (1 - r / reach) ** 2
    return total


@pytest.mark.parametrize("kind", KINDS)
@given(st.integers(0, 10**6), st.lists(st.integers(-3, 3), min_size=7, max_size=7))
def test_spheres_repel_the_nearest_image_of_each_other(kind, seed, images):
    """Whatever image of itself a sphere is in: a sum over all images has the same energy."""
    positions = crowd(7, seed)[0]
    expected = energy_over_images(kind, positions, 14.0)
    moved = positions + np.outer(images, [14.0, 0.0, 0.0])
    assert energy_over_images(kind, moved, 14.0) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    for there in (positions, moved):
        energy, wrenches = forces(kind, there, 14.0)
        assert energy == pytest.approx(expected, rel=1e-9, abs=1e-12)
        assert wrenches == pytest.approx(forces(kind, positions, 14.0)[1], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_the_force_over_the_seam_is_minus_the_slope_of_the_sum_over_images(kind):
    positions = np.array([[0.2, 0.1, 0.0], [7.0, 0.0, 0.3], [12.1, -0.2, 0.1]])
    _, wrenches = forces(kind, positions, 14.0)
    assert wrenches[0, 0] > 0.0 > wrenches[2, 0]
    step = 1e-6
    for sphere in (0, 2):
        for k in range(3):
            ahead, behind = positions.copy(), positions.copy()
            ahead[sphere, k] += step
            behind[sphere, k] -= step
            slope = energy_over_images(kind, ahead, 14.0) - energy_over_images(kind, behind, 14.0)
            assert wrenches[sphere, k] == pytest.approx(-slope / (2 * step), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_it_begins_smoothly_at_its_range_and_pushes_apart_below(kind):
    for distance, pushed in ((2.6 + 1e-9, 0.0), (2.6 - 1e-9, 1e-6), (2.2, None), (1.9, None)):
        energy, wrenches = forces(kind, np.array([[0.0, 0, 0], [distance, 0, 0]]))
        assert wrenches[0, 0] == -wrenches[1, 0]
        assert not wrenches[:, 1:].any()
        if pushed is None:
            assert energy > 0
            assert wrenches[1, 0] > 0
        else:
            assert 0 <= wrenches[1, 0] <= pushed


def test_wca_at_sigma_is_its_strength():
    sigma = 2.6 / 2 ** (1 / 6)
    energy, wrenches = forces("wca", np.array([[0.0, 0, 0], [0, sigma, 0]]))
    assert energy == pytest.approx(3.0)
    assert wrenches[1, 1] == pytest.approx(24 * 3.0 / sigma)


@given(st.integers(0, 10**6), st.lists(st.floats(0.0, 0.5), min_size=1, max_size=5))
def test_the_age_of_the_list_of_pairs_does_not_show(seed, moves):
    positions = crowd(12, seed)[0]
    old = Repulsion("wca", 3.0, 2.6)
    rng = np.random.default_rng(seed)
    for move in moves:
        positions = positions + move * rng.standard_normal(positions.shape)
        kept, fresh = np.zeros((12, 6)), np.zeros((12, 6))
        old.add_wrenches(positions, kept)
        Repulsion("wca", 3.0, 2.6).add_wrenches(positions, fresh)
        assert np.array_equal(kept, fresh)


@pytest.mark.parametrize("ends", ["free", "clamped", "periodic"])
@pytest.mark.parametrize("friction", ["one-body", "pairwise"])
def test_it_enters_the_model_with_its_derivative(ends, friction):
    scene = nrchain.load_scene(
        {
            "chain": {"particles": 7, "spacing": 2.6, "ends": ends},
            "friction": friction,
            "steric": {"kind": "wca", "strength": 3.0, "range": 2.6},
            "run.end": 1.0,
        }
    )
    positions, frames = random_chain(7, spacing=2.4, noise=0.2)
    model = Model(scene)
    assert not model.is_banded
    assert model.is_near == (friction == "one-body")
    blocks = np.empty((7, 2 * model.reach + 1, 6, 6))
    model.linearise(positions, frames, blocks)
    numeric = pose_derivative(lambda r, e: model.twists(r, e), positions, frames)
    rng = np.random.default_rng(1)
    poses, product = rng.standard_normal((7, 6)), np.zeros((7, 6))
    poses[model.held] = 0.0
    model.add_product(poses, product)
    expected = np.einsum("npmq,mq->np", numeric, poses)
    free = ~model.held
    assert product[free] == pytest.approx(expected[free], rel=1e-5, abs=1e-4)


def test_touching_chains_go_on():
    scene = nrchain.load_scene(
        "buckling", chain={"particles": 24, "ends": "free"}, **{"elasticity.ratio": 1e5}
    )
    bare = nrchain.simulate(scene)
    assert bare.cause is Cause.TOUCH
    soft = {"steric.kind": "harmonic", "steric.strength": 1e4, "steric.range": 2.5}
    # as many snapshots as show every approach, also one that is soon over
    run = {"run.end": 1.2 * bare.time[-1], "run.snapshots": 1001}
    kept = nrchain.simulate(nrchain.load_scene(scene, **soft, **run))
    assert kept.status == "completed"
    assert 1.9 < min(closest_pair(r)[0] for r in kept.positions) < 2.5
