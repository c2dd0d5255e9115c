"""Frames of a start follow its curve."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nrchain.scene.poses import frames_along

X = np.array([1.0, 0.0, 0.0])
ANGLES = st.floats(-15.0, np.log10(3.0)).map(lambda exponent: 10.0**exponent)
"""Between the tangent and x, in rad."""


@given(angle=ANGLES, direction=st.floats(0.0, 2.0 * np.pi))
def test_frames_are_the_lab_axes_turned_about_the_normal_of_x_and_the_tangent(angle, direction):
    """Rodrigues' formula by SciPy, for angles over fifteen decades and up to 3 rad."""
    axis = np.array([0.0, np.cos(direction), np.sin(direction)])
    rotation = Rotation.from_rotvec(angle * axis).as_matrix()
    tangent = rotation @ X
    (frame,) = frames_along(tangent[None])
    assert frame == pytest.approx(rotation.T, abs=1e-13)


def test_frames_along_x_are_the_lab_axes():
    assert (frames_along(np.array([X, X])) == np.eye(3)).all()
