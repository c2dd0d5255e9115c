"""Periodic chains whose spheres are given in other images are the chains that they were."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.poses import random_chain

import nrchain
from nrchain import measure
from nrchain.analysis.measure import MeasurementError
from nrchain.effects.registry import effects
from nrchain.errors import SceneError
from nrchain.planning.checked_start import starting_poses
from nrchain.scene.unwrapping import CLEAR, unwrapped

D, A = 7.0, 1.5
MODULI = {"stretch": 30.0, "shear": 20.0, "twist": 50.0, "bend": 70.0}


def scene_of(count=8, **changes):
    return nrchain.load_scene(
        {
            "chain": {"particles": count, "spacing": D, "radius": A, "ends": "periodic"},
            "elasticity": MODULI,
            "slip": {"2s": 20.0, "4a": 30.0},
            "run": {"end": 2.0, "snapshots": 5},
        },
        **changes,
    )


def wrapped(positions, images, spacing=D):
    """Every sphere moved by so many periods, those of each snapshot alike."""
    moved = np.array(positions)
    moved[..., 0] += np.asarray(images) * positions.shape[-2] * spacing
    return moved


chains = st.integers(2, 12).flatmap(
    lambda count: st.tuples(
        st.integers(0, 10**6), st.lists(st.integers(-50, 50), min_size=count, max_size=count)
    )
)


def a_chain(seed, count):
    return random_chain(count, spacing=D, bend=0.3, noise=0.05 * D, seed=seed)


@settings(deadline=None)
@given(chains)
def test_energy_and_wrenches_do_not_see_images(given_chain):
    seed, images = given_chain
    positions, frames = a_chain(seed, len(images))
    elastic = {"spacing": D, "ends": "periodic", **MODULI}
    plain = nrchain.elastic_energy(positions, frames, **elastic)
    moved = wrapped(positions, images)
    assert nrchain.elastic_energy(moved, frames, **elastic) == pytest.approx(plain, rel=1e-9)
    for found, expected in zip(
        nrchain.elastic_wrenches(moved, frames, **elastic),
        nrchain.elastic_wrenches(positions, frames, **elastic),
        strict=True,
    ):
        assert found == pytest.approx(expected, rel=1e-8, abs=1e-8)


@settings(deadline=None)
@given(chains)
def test_the_image_most_spheres_are_in_is_kept(given_chain):
    seed, images = given_chain
    positions, _ = a_chain(seed, len(images))
    moved = unwrapped(wrapped(positions, images), D)
    shift = (moved - positions)[:, 0] / (len(images) * D)
    assert shift == pytest.approx(np.full(len(images), shift[0]), abs=1e-12)
    assert shift[0] in [pytest.approx(image, abs=1e-12) for image in images]
    assert images.count(round(shift[0])) == max(images.count(image) for image in images)
    assert np.array_equal(moved[:, 1:], positions[:, 1:])


def test_positions_that_are_not_wrapped_are_returned_as_they_are():
    positions, _ = a_chain(1, 8)
    assert unwrapped(positions, D) is positions


@pytest.mark.parametrize("name", ["one-body", "pairwise"])
def test_what_effects_contribute_does_not_see_images(name):
    steric = {"kind": "wca", "strength": 2.0, "range": D}
    scene = scene_of(friction=name, steric=steric, **{"slip.neighbours": 3})
    positions, frames = a_chain(3, 8)
    images = [0, 0, 2, -1, 0, 0, 5, 0]
    found, expected = (
        nrchain.contributions(scene, r, frames) for r in (wrapped(positions, images), positions)
    )
    assert set(found) == set(expected)
    for effect in expected:
        for part in ("wrench", "twist"):
            one, other = getattr(found[effect], part), getattr(expected[effect], part)
            assert one == pytest.approx(other, rel=1e-9, abs=1e-9), effect


def test_a_run_from_a_wrapped_start_is_that_of_the_unwrapped_one():
    scene = scene_of(**{"run.rtol": 1e-10, "run.atol": 1e-10})
    positions, frames = a_chain(2, 8)
    plain = nrchain.simulate(scene, positions=positions, frames=frames)
    moved = nrchain.simulate(
        scene, positions=wrapped(positions, [0, 1, 0, 0, -3, 0, 0, 0]), frames=frames
    )
    assert plain.status == moved.status == "completed"
    assert moved.positions == pytest.approx(plain.positions, abs=1e-7)
    assert moved.frames == pytest.approx(plain.frames, abs=1e-7)


def test_estimates_and_choices_from_a_wrapped_start_are_those_of_the_unwrapped_one():
    scene = scene_of()
    positions, frames = a_chain(2, 8)
    found = starting_poses(scene, wrapped(positions, [0, 1, 0, 0, -3, 0, 0, 0]), frames)
    assert found[0] == pytest.approx(positions, abs=1e-12)


def test_an_effect_is_checked_on_the_unwrapped_chain():
    stretch = next(effect for effect in effects() if effect.name == "stretch")
    positions, frames = a_chain(4, 8)
    for images in ([0] * 8, [0, 0, 1, 0, 0, -2, 0, 0]):
        errors = nrchain.check_effect(
            stretch, scene_of(), positions=wrapped(positions, images), frames=frames
        )
        assert max(errors.values()) < 1e-6


@pytest.fixture(scope="module")
def boxed():
    """A run, and the same with its spheres put back into the box [0, P) at every snapshot."""
    scene = scene_of(12, **{"start": {"shape": "helix-right", "amplitude": 0.5}})
    run = nrchain.simulate(nrchain.load_scene(scene, **{"slip.3t": 400.0, "run.end": 20.0}))
    inside = run.positions.copy()
    inside[..., 0] %= 12 * D
    assert not np.array_equal(inside, run.positions)
    return run, nrchain.Trajectory(run.time, inside, run.frames, run.scene)


@pytest.mark.parametrize(
    "measured",
    [
        lambda run: measure.wave(run, kind="right").amplitude,
        lambda run: measure.wave(run, kind="x").amplitude,
        lambda run: measure.handedness(run).size,
        lambda run: measure.handedness(run).error,
        measure.straightness,
        measure.turned_angle,
        lambda run: nrchain.contribution_sizes(run)["stretch"],
        lambda run: nrchain.contribution_sizes(run)["total"],
    ],
)
def test_measures_do_not_see_images(boxed, measured):
    run, inside = boxed
    assert measured(inside) == pytest.approx(measured(run), rel=1e-6, abs=1e-9)


def test_the_translation_of_a_wrapped_chain_is_refused(boxed):
    run, inside = boxed
    assert measure.translation(run)[0].value > 0.1
    with pytest.raises(MeasurementError, match=r"^positions\[\d+\]: the chain is wrapped"):
        measure.translation(inside)


@pytest.mark.parametrize("count", [2, 3, 4, 10])
@pytest.mark.parametrize("off", [0.45, 0.5, 0.55, 1.5, -0.45, -3.5])
def test_a_sphere_half_a_period_off_is_refused_by_name(count, off):
    positions = D * np.arange(count)[:, None] * [1.0, 0.0, 0.0]
    frames = np.tile(np.eye(3), (count, 1, 1))
    positions[1, 0] += off * count * D
    elastic = {"spacing": D, "ends": "periodic", **MODULI}
    refused = pytest.raises(SceneError, match=r"^positions = 'sphere [0-9]+': is wrapped")
    with refused as caught:
        nrchain.elastic_energy(positions, frames, **elastic)
    # of the two links of a sphere that is off, either names one of its ends
    assert f"'sphere {1}'" in str(caught.value) or f"'sphere {2 % count}'" in str(caught.value)
    scene = scene_of(count)
    for call in (
        lambda: nrchain.contributions(scene, positions, frames),
        lambda: nrchain.simulate(scene, positions=positions, frames=frames),
    ):
        with pytest.raises(SceneError, match="wrapped"):
            call()
    run = nrchain.Trajectory(
        np.arange(2.0), np.stack([positions] * 2), np.stack([frames] * 2), scene
    )
    with pytest.raises(MeasurementError, match=r"^positions\[0\] = 'sphere"):
        measure.straightness(run)


@pytest.mark.parametrize("off", [-0.9 * CLEAR, 0.9 * CLEAR])
def test_links_strained_by_less_are_taken_as_they_are(off):
    positions = D * np.arange(6)[:, None] * [1.0, 0.0, 0.0]
    positions[3, 0] += off * 6 * D
    assert unwrapped(positions, D) is positions
    assert unwrapped(wrapped(positions, [0, 0, 0, 7, 0, 0]), D) == pytest.approx(positions)


def test_links_that_close_over_no_period_are_refused():
    """All spheres within half a period: whether the chain goes around is not clear."""
    positions = 0.2 * D * np.arange(12)[:, None] * [1.0, 0.0, 0.0]
    with pytest.raises(SceneError, match="wrapped"):
        unwrapped(positions, D)


@pytest.mark.parametrize("far", [1e18, 1e300, -1e18])
def test_images_so_far_that_rounding_shows_are_refused(far):
    positions = D * np.arange(6)[:, None] * [1.0, 0.0, 0.0]
    positions[3, 0] = far
    with pytest.raises(SceneError, match=r"'sphere [34]': is wrapped(, at x = | or torn off)"):
        unwrapped(positions, D)


def test_spheres_without_links_are_taken_as_they_are_given():
    """Free spheres drift apart by any distance: half a period is nothing to refuse."""
    loose = {"stretch": 0.0, "shear": 0.0, "twist": 50.0, "bend": 70.0}
    positions, frames = a_chain(3, 8)
    for off in (0.5, 1.5):
        positions[4] += [off * 8 * D, 2.0 * D, 0.0]
        found = starting_poses(scene_of(elasticity=loose), positions, frames)
        assert np.array_equal(found[0], positions)
        energy = nrchain.elastic_energy(positions, frames, spacing=D, ends="periodic", **loose)
        assert math.isfinite(energy)


def test_the_seam_is_put_together_too():
    """A chain that begins anywhere in its box: the first spheres wrapped, or the last."""
    positions, frames = a_chain(5, 9)
    elastic = {"spacing": D, "ends": "periodic", **MODULI}
    plain = nrchain.elastic_energy(positions, frames, **elastic)
    for shift in np.linspace(0.0, 9 * D, 7):
        inside = positions.copy()
        inside[:, 0] = (inside[:, 0] + shift) % (9 * D)
        assert nrchain.elastic_energy(inside, frames, **elastic) == pytest.approx(plain, rel=1e-9)
