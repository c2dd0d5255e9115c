"""The camera sees every sphere, and stands as near as that allows."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrchain.errors import SceneError
from nrchain.view.space.camera import ANGLE, VIEWS, Window, direction, fit


def project(camera, points):
    """Where points (M, 3) are in the picture: half its height is 1."""
    to_camera = camera.position - camera.focus
    to_camera = to_camera / np.linalg.norm(to_camera)
    right = np.cross(camera.up, to_camera)
    seen = (points - camera.position) @ np.array([right, camera.up, -to_camera]).T
    assert np.all(seen[:, 2] > 0.0)
    return seen[:, :2] / seen[:, 2:] / math.tan(math.radians(ANGLE / 2))


@given(
    seed=st.integers(0, 1000),
    sizes=st.tuples(*3 * [st.floats(-2, 3)]),
    azimuth=st.floats(-180, 180),
    elevation=st.floats(-90, 90),
    aspect=st.floats(0.5, 2.5),
)
def test_every_sphere_is_in_the_window(seed, sizes, azimuth, elevation, aspect):
    generator = np.random.default_rng(seed)
    centres = generator.normal(size=(6, 3)) * 10.0 ** np.array(sizes) + 50.0
    window = Window.within(aspect, 0.02, 0.1, 0.16)
    camera = fit(centres, 1.0, (azimuth, elevation), window)
    shell = generator.normal(size=(1000, 3))
    shell /= np.linalg.norm(shell, axis=1, keepdims=True)
    x, y = project(camera, (centres[:, None] + shell).reshape(-1, 3)).T
    low, high = -1 + 2 * 0.16, 1 - 2 * 0.1
    side = aspect * (1 - 2 * 0.02)
    assert np.abs(x).max() < side + 1e-9
    assert low - 1e-9 < y.min()
    assert y.max() < high + 1e-9
    # as near as that allows: two opposite edges are touched, as well as so many points show
    assert max(np.ptp(x) / (2 * side), np.ptp(y) / (high - low)) > 0.9


@pytest.mark.parametrize(("view", "right", "up"), [("x", 1, 2), ("y", 0, 2), ("z", 0, 1)])
def test_named_views_show_planes(view, right, up):
    camera = fit(np.zeros((1, 3)), 1.0, view, Window.within(1.0, 0.0, 0.0, 0.0))
    assert camera.up == pytest.approx(np.eye(3)[up], abs=1e-12)
    across = np.cross(camera.up, camera.position - camera.focus)
    assert across / np.linalg.norm(across) == pytest.approx(np.eye(3)[right], abs=1e-12)


def test_a_view_is_a_name_or_two_angles():
    assert direction("slant") == VIEWS["slant"]
    assert direction("-30,10") == direction((-30, 10)) == (-30.0, 10.0)


@pytest.mark.parametrize("view", ["top", "1,2,3", "0,91", "nan,0", (1.0,), None, 3])
def test_other_views_are_refused(view):
    with pytest.raises(SceneError, match=r"view = .*must be one of slant, x, y, z, or azimuth"):
        direction(view)
