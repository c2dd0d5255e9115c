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


def test_a_chain_is_judged_by_its_strongest_spheres():
    assert (
        warnings(nrchain.load_scene("buckling", **{"slip.2s": [100.0] * 10 + [-100.0] * 10})) == []
    )
    (told,) = warnings(nrchain.load_scene("buckling", **{"slip.2s": [200.0] + [1.0] * 19}))
    assert "prestress 88 is 0.46 of λ∥d = 193" in told


def test_shear_is_judged_and_cured_by_itself():
    soft = {"elasticity": {"ratio": None, "stretch": 500.0, "shear": 5.0}}
    scene = nrchain.load_scene("buckling", **soft)
    (told,) = warnings(scene)
    assert "prestress 44 is 0.88 of λ⊥d = 50, and tangents turn away" in told
    assert "elasticity.shear of 15 or more" in told
    assert warnings(nrchain.load_scene(scene, **{"elasticity.shear": 15.0})) == []


@pytest.mark.parametrize("changes", [{}, {"friction": "pairwise"}, {"elasticity.bend": 0.0}])
def test_a_passive_chain_is_judged_too(changes):
    assert warnings(nrchain.load_scene("passive", **changes)) == []


def test_what_cannot_be_judged_is_said():
    """A straight chain that turns across itself, and strengths beyond the range of floats."""
    tilted = {"slip.4a": 100.0, "slip.4a.axis": [1.0, 1.0, 0.0]}
    (told,) = warnings(nrchain.load_scene("passive", **tilted))
    assert "cannot be judged beforehand: slip = " in told
    assert any("cannot" in x for x in warnings(nrchain.load_scene("stable", **{"slip.2s": -1e200})))


def test_description_carries_the_warnings():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 64})
    assert nrchain.describe(scene).warnings == warnings(scene)
