"""What colours a chain: the quantity named, for spheres or for links."""

import numpy as np
import pytest
from support.films import growing

import nrchain
from nrchain.errors import SceneError
from nrchain.view.space.colouring import colouring


def test_strains_are_those_of_links():
    trajectory = growing()
    found = colouring(trajectory, "twist")
    assert found.of == "links"
    assert found.values.shape == (6, 5)
    bent = colouring(trajectory, "bend")
    assert np.all(bent.values == 0.0)
    assert bent.limits == (0.0, 1.0)


def test_the_bar_of_a_signed_quantity_is_symmetric():
    trajectory = growing()
    found = colouring(trajectory, "stretch")
    assert found.limits[0] == -found.limits[1] or found.values.min() >= 0.0
    assert found.limits[1] == np.abs(found.values).max()


def test_motions_are_the_contributions_of_spheres():
    trajectory = growing()
    last = nrchain.contributions(
        trajectory.scene, *(trajectory[-1].positions, trajectory[-1].frames)
    )
    speed = colouring(trajectory, "speed")
    assert speed.of == "spheres"
    assert speed.values[-1] == pytest.approx(np.linalg.norm(last.total.twist[:, :3], axis=1))
    spin = colouring(trajectory, "spin")
    assert spin.values[-1] == pytest.approx(np.linalg.norm(last.total.twist[:, 3:], axis=1))
    slip = colouring(trajectory, "effect:slip 2s")
    assert slip.values[-1] == pytest.approx(np.linalg.norm(last["slip 2s"].twist, axis=1))
    assert slip.label == "slip 2s, length/time"


def test_a_logarithmic_scale_shows_sizes_over_four_decades():
    trajectory = growing()
    linear, found = (colouring(trajectory, "stretch", s) for s in ("linear", "logarithmic"))
    assert found.logarithmic
    most = np.abs(linear.values).max()
    assert found.limits == pytest.approx((1e-4 * most, most))
    assert not found.signed
    assert found.values == pytest.approx(np.maximum(np.abs(linear.values), 1e-4 * most))
    with pytest.raises(SceneError, match="colour_scale = 'cubic': must be one of linear, log"):
        colouring(trajectory, "stretch", "cubic")


def test_plain_has_no_quantity():
    assert colouring(growing(), "plain") is None


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("speeed", "colour = 'speeed': must be one of plain, .*did you mean 'speed'"),
        ("effect:slip 4a", "the effects of this run are effect:stretch, .*effect:slip 2s"),
    ],
)
def test_other_colours_are_refused(name, message):
    with pytest.raises(SceneError, match=message):
        colouring(growing(), name)
