"""The bend of a chain, and which steps of a bent one need no look."""

import numpy as np
import pytest

from nrchain._compile import kernel
from nrchain.motion.bend import BENT, LARGEST, BendCheck, bend_of, is_bent

RADIUS, SPACING, COUNT = 1.3, 4.1, 7


@kernel
def passes(check, positions, frames, y):
    return is_bent(check, positions, frames, y)


def poses(size, periodic=False, seed=3):
    """A chain along x, or along an oblique line if it is open, with offsets and tilts."""
    rng = np.random.default_rng(seed)
    positions = np.outer(SPACING * np.arange(COUNT), [1.0, 0.0, 0.0])
    positions += size * rng.normal(size=(COUNT, 3))
    frames = np.tile(np.eye(3), (COUNT, 1, 1))
    frames[2, :2, :2] = [[np.cos(size), np.sin(size)], [-np.sin(size), np.cos(size)]]
    if periodic:
        return positions, frames
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    return positions @ turn.T, frames @ turn.T


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("size", [1e-5, 1e-3, 0.3])
def test_the_bend_is_the_largest_offset_and_the_largest_tilt_from_the_axis(periodic, size):
    positions, frames = poses(size, periodic)
    offsets = positions - positions[0]
    axis = np.array([1.0, 0.0, 0.0]) if periodic else offsets[-1] / np.linalg.norm(offsets[-1])
    farthest = np.linalg.norm(offsets - np.outer(offsets @ axis, axis), axis=1).max() / RADIUS
    tilt = np.sqrt(1.0 - (frames[:, 0] @ axis) ** 2).max()
    found = bend_of(positions, frames, RADIUS, periodic, np.inf)
    assert found == pytest.approx((farthest, tilt), rel=1e-5)
    early = bend_of(positions, frames, RADIUS, periodic, 0.5 * farthest)
    assert 0.5 * farthest <= max(early) <= max(found)


def test_a_bent_chain_is_checked_every_eighth_step_and_a_straight_one_is_looked_at():
    check = BendCheck.of(COUNT, RADIUS, 0.0)
    bent, straight = poses(0.3), poses(1e-4)
    step = np.linspace(-1.0, 1.0, 6 * COUNT)
    assert not passes(check, *straight, step)
    assert check.pause[0] == 0
    assert not check.farthest.any()
    assert passes(check, *bent, step)
    # no bend is computed in the pause: this one would be too small
    for _ in range(BENT - 1):
        assert passes(check, *straight, 5.0 * step)
    assert not passes(check, *straight, step)
    assert passes(check, *bent, 0.5 * step[::-1])
    assert np.array_equal(check.farthest, np.abs(step))


def test_a_chain_whose_ends_meet_is_bent():
    positions, frames = poses(0.0)
    positions[-1] = positions[0]
    assert bend_of(positions, frames, RADIUS, False, LARGEST) == (LARGEST, LARGEST)
