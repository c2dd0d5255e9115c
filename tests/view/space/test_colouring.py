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
