"""Pictures of the flow: its plane, its window, its spheres and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest
from support.pictures import assert_looks_like
from support.selection import few_of

import nrchain
from nrchain.errors import SceneError
from nrchain.view.flow_plots import draw_flow, save_flow


def scene(**changes):
    base = {
        "chain.particles": 4,
        "chain.radius": 2.0,
        "chain.spacing": 10.0,
        "slip.2s": 10.0,
        "start.shape": "sine",
        "start.amplitude": 3.0,
        "run.end": 0.2,
        "run.snapshots": 3,
    }
    return nrchain.load_scene("passive", **{**base, **changes})


def circles(axes):
    from matplotlib.collections import EllipseCollection

    (found,) = [part for part in axes.collections if isinstance(part, EllipseCollection)]
    return found.get_offsets(), found.get_widths()


def test_spheres_are_drawn_as_the_plane_cuts_them_to_scale():
    given = scene()
    positions = nrchain.simulate(given).positions[0]
    offsets, _ = circles(draw_flow(given, plane="xy"))
    assert np.allclose(offsets, positions[:, :2] / 2.0)
    at = float(positions[1, 1]) + 1.2
    offsets, widths = circles(draw_flow(given, plane="xz", at=at))
    cut = np.abs(positions[:, 1] - at) < 2.0
    assert np.allclose(offsets, positions[cut][:, [0, 2]] / 2.0)
    # a section at the distance h has the diameter 2 √(a² − h²), here in radii
    assert np.allclose(widths, np.sqrt(4 - (positions[cut, 1] - at) ** 2))


def test_the_magnitude_is_that_of_the_flow():
    given = scene()
    axes = draw_flow(given, plane="yz", at=35.0, window=(-5, 5, -4, 4), parts=["slip"])
    (image,) = axes.images
    shown = image.get_array()
    y, z = np.linspace(-5, 5, shown.shape[1]), np.linspace(-4, 4, shown.shape[0])
    row, column = shown.shape[0] // 3, shown.shape[1] // 5
    point = [35.0, 2 * y[column], 2 * z[row]]
    expected = nrchain.flow(given, point, parts=["slip"]).speed
    assert shown[row, column] == pytest.approx(expected, rel=1e-12)
    assert axes.get_xlim() == (-5, 5)
    assert axes.get_ylim() == (-4, 4)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("y/a", "z/a")


def test_axes_given_are_drawn_on_and_returned():
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    assert draw_flow(scene(), axes, bar=False) is axes
    assert len(axes.figure.axes) == 1


def test_a_fluid_at_rest_is_drawn():
    still = scene(**{"slip.2s": 0.0, "start.shape": "straight"})
    assert len(draw_flow(still).collections) == 1


def test_images_of_a_periodic_chain_are_drawn():
    given = scene(**{"chain.ends": "periodic", "start.shape": "straight"})
    offsets, _ = circles(draw_flow(given))
    assert np.allclose(np.sort(offsets[:, 0]), 5.0 * np.arange(-4, 8))


@pytest.mark.parametrize("ending", few_of(["png", "svg"], {"svg"}))
def test_a_picture_is_saved(tmp_path, ending):
    trajectory = nrchain.simulate(scene(title="100 $ [red]"))
    path = save_flow(trajectory, tmp_path / f"a.{ending}", plane="xz", frame=1)
    assert path.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"plane": "zx"}, "xy, xz, yz"),
        ({"at": np.inf}, "at = inf"),
        ({"window": (1, 1, 0, 2)}, "left < right"),
        ({"window": (1, 2)}, "window"),
        ({"density": 0.0}, "density"),
        ({"axes": "flow.png"}, "axes of matplotlib"),
    ],
)
def test_bad_options_are_refused(changes, message):
    with pytest.raises(SceneError, match=message):
        draw_flow(scene(), **changes)


def test_the_picture_looks_as_it_did(tmp_path):
    trajectory = nrchain.simulate(scene(**{"slip.3a": 30.0}))
    path = save_flow(trajectory, tmp_path / "a.png", frame=0, title=False)
    assert_looks_like(path, "flow")
