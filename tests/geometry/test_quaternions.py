"""Quaternions and frames are the same rotations, checked against SciPy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nrchain.geometry.quaternions import frames_of, quaternions_of

AXES = np.vstack([np.eye(3), -np.eye(3), np.random.default_rng(1).normal(size=(20, 3))])
AXES /= np.linalg.norm(AXES, axis=1, keepdims=True)
ANGLES = np.concatenate([np.logspace(-12, 0, 25), np.pi - np.logspace(-12, 0, 25), [0.0, np.pi]])


def turns():
    return Rotation.from_rotvec((ANGLES[:, None, None] * AXES).reshape(-1, 3))


def test_the_quaternion_turns_the_axes_of_the_lab_into_those_of_the_sphere():
    turn = turns()
    frames = np.swapaxes(turn.as_matrix(), 1, 2)
    found, expected = quaternions_of(frames), np.roll(turn.as_quat(), 1, axis=1)
    same = np.minimum(abs(found - expected).max(axis=1), abs(found + expected).max(axis=1))
    assert same.max() < 1e-15
    assert (found[:, 0] >= 0.0).all()


def test_frames_come_back():
    frames = np.swapaxes(turns().as_matrix(), 1, 2)
    assert frames_of(quaternions_of(frames)) == pytest.approx(frames, abs=1e-15)


def test_rounded_quaternions_still_give_rotations():
    frames = frames_of(quaternions_of(np.swapaxes(turns().as_matrix(), 1, 2)).astype(np.float32))
    gram = frames @ np.swapaxes(frames, 1, 2)
    assert abs(gram - np.eye(3)).max() < 16 * np.finfo(float).eps
    assert np.linalg.det(frames) == pytest.approx(1.0, abs=1e-14)


def test_any_number_of_leading_axes():
    assert quaternions_of(np.broadcast_to(np.eye(3), (2, 5, 3, 3))).shape == (2, 5, 4)
    assert frames_of(np.ones((2, 5, 4))).shape == (2, 5, 3, 3)
