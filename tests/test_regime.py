"""Scenes out of the beam limit are announced; those in it are not."""

import pytest

import nrchain
from nrchain.regime import warnings


@pytest.mark.parametrize(
    "name", ["passive", "buckling", "stable", "helix-left", "wave", "spiral-left"]
)
def test_shipped_scenes_are_in_the_beam_limit(name):
    assert warnings(nrchain.load_scene(name)) == []


def test_a_chain_that_tears_is_announced_with_a_remedy():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 64, "chain.ends": "free"})
    text = " ".join(warnings(scene))
    # λd = 1.6 against a prestress of −44 (physics of the paper's Eq. 2s_prestress)
    assert "prestress 44 is 28 of λ∥d = 1.6" in text
    assert "come" in text
    assert nrchain.simulate(nrchain.load_scene(scene, **{"run.end": 200})).status == "stopped"


def test_the_remedies_remove_the_warning():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 64, "chain.ends": "free"})
    stiffer = nrchain.load_scene(scene, **{"elasticity.ratio": 9.3e8})
    shorter = nrchain.load_scene(scene, **{"chain.particles": 21})
    assert not any("beam limit" in text for text in warnings(stiffer) + warnings(shorter))


def test_the_long_reach_of_2s_does_not_make_it_infinite():
    scene = nrchain.load_scene("buckling", **{"slip.neighbours": "all"})
    assert all("inf" not in text for text in warnings(scene))


def test_chains_without_plane_waves_are_left_alone():
    strengths = [100.0] * 10 + [-100.0] * 10
    assert warnings(nrchain.load_scene("buckling", **{"slip.2s": strengths})) == []


def test_description_carries_the_warnings():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 64})
    assert nrchain.describe(scene).warnings == warnings(scene)
