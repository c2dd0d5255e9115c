"""Distances and angles between poses, over all scales of the angle."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nrchain.geometry.distances import pose_distances


@pytest.mark.parametrize("angle", [0.0, *np.geomspace(1e-12, np.pi, 25)])
def test_the_angle_of_a_rotation_is_found_at_every_scale(angle):
    random = np.random.default_rng(5)
    axes = random.standard_normal((7, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    frames = Rotation.random(7, random_state=3).as_matrix()
    turned = frames @ Rotation.from_rotvec(angle * axes).as_matrix()
    positions = random.standard_normal((7, 3))
    apart, turns = pose_distances((positions, frames), (positions + 2.0 * axes, turned))
    assert apart == pytest.approx(2.0)
    assert turns == pytest.approx(angle, rel=1e-6, abs=1e-15 if angle < 1e-6 else 1e-14)


def test_leading_axes_are_kept():
    frames = np.broadcast_to(np.eye(3), (4, 5, 3, 3))
    apart, turns = pose_distances((np.ones((4, 5, 3)), frames), (np.zeros((4, 5, 3)), frames))
    assert apart.shape == turns.shape == (4, 5)
    assert apart == pytest.approx(np.sqrt(3.0))
    assert not turns.any()
