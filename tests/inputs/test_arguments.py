"""What public functions are given: frames rounded to 32 bits, and ones that are no rotations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from support.poses import random_chain

import nrchain
from nrchain.errors import SceneError
from nrchain.inputs.arguments import ORTHONORMAL, SINGLE, rotations


def off(frames):
    return np.abs(frames @ frames.transpose(0, 2, 1) - np.eye(3)).max()


@given(st.integers(0, 10**6), st.integers(1, 40))
@settings(deadline=None)
def test_frames_of_32_bits_are_taken_as_the_nearest_rotations(seed, count):
    frames = Rotation.random(count, random_state=seed).as_matrix()
    rounded = frames.astype(np.float32)
    for single in (rounded, rounded.astype(float)):
        found = rotations(single, count)
        assert off(found) < 1e-12
        assert np.abs(found - frames).max() < 1e-6
        # the polar factor is the nearest: Higham, SIAM J. Sci. Stat. Comput. 7, 1160 (1986)
        left, _, right = np.linalg.svd(np.asarray(single, float))
        assert found == pytest.approx(left @ right, abs=1e-12)
    assert np.array_equal(rotations(frames, count), frames)


def test_frames_given_are_never_changed():
    frames = Rotation.random(3, random_state=1).as_matrix() * (1.0 + 1e-7)
    before = frames.copy()
    assert off(rotations(frames, 3)) < 1e-12
    assert np.array_equal(frames, before)


def test_a_run_starts_from_frames_of_32_bits():
    positions, frames = random_chain(4, spacing=10.0, bend=0.1, noise=0.1)
    scene = nrchain.load_scene({"chain.particles": 4, "run": {"end": 1.0, "snapshots": 2}})
    single = nrchain.simulate(
        scene, positions=positions.astype(np.float32), frames=frames.astype(np.float32)
    )
    double = nrchain.simulate(scene, positions=positions, frames=frames)
    assert off(single.frames[0]) < 1e-12
    assert single.positions[-1] == pytest.approx(double.positions[-1], abs=1e-4)
    energies = [
        nrchain.elastic_energy(
            positions, e, spacing=10.0, stretch=2.0, shear=2.0, twist=3.0, bend=3.0
        )
        for e in (frames, frames.astype(np.float32))
    ]
    assert energies[1] == pytest.approx(energies[0], rel=1e-5)


@pytest.mark.parametrize("size", [2.0 * SINGLE, 1e-3, 0.3])
def test_the_advice_for_frames_that_are_off_holds(size):
    rng = np.random.default_rng(0)
    frames = Rotation.random(5, random_state=3).as_matrix()
    frames[3] += size * (1.0 + rng.random((3, 3)))
    with pytest.raises(SceneError, match=r"^frames\[3\] = ") as caught:
        rotations(frames, 5)
    advice = caught.value.allowed.partition("; scipy.spatial.transform.")[2].split(" gives ")[0]
    mended = eval(advice, {"Rotation": Rotation, "frames": frames})  # the line as it is caught
    assert rotations(mended, 5) is not None
    assert mended[:3] == pytest.approx(frames[:3])


def test_a_stricter_bound_is_kept():
    frames = Rotation.random(2, random_state=3).as_matrix() * (1.0 + 1e-7)
    with pytest.raises(SceneError, match="1e-08"):
        rotations(frames, 2, to=ORTHONORMAL)


@pytest.mark.parametrize("frames", [np.full((2, 3, 3), 1e200), np.zeros((2, 3, 3))])
def test_what_is_far_from_a_rotation_is_refused(frames):
    with pytest.raises(SceneError, match="orthonormal"):
        rotations(frames, 2)
