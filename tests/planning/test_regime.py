"""Scenes out of the beam limit bring a warning; those in it do not."""

import math
import re

import pytest

import nrchain
from nrchain.planning.regime import warnings


@pytest.mark.parametrize(
    "name", ["passive", "buckling", "stable", "helix-left", "wave", "spiral-left"]
)
def test_shipped_scenes_are_in_the_beam_limit(name):
    assert warnings(nrchain.load_scene(name)) == []


def test_a_chain_that_tears_is_announced_with_a_remedy_that_holds():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 64, "chain.ends": "free"})
    (text,) = warnings(scene)
    # λd = 1.6 against what the pair forces leave to the links (the paper's Eq. 2s_prestress)
    assert "tension T = 44 of a link is 28 times λ∥d = 1.6" in text
    assert text.startswith("out of the beam limit")
    assert nrchain.simulate(nrchain.load_scene(scene, **{"run.end": 200})).status == "stopped"
    ratio = float(re.search(r"elasticity.ratio = (\S+) holds it$", text)[1])
    stiffer = nrchain.load_scene(scene, **{"elasticity.ratio": ratio})
    assert warnings(stiffer) == []
    assert nrchain.simulate(nrchain.load_scene(stiffer, **{"run.end": 200})).status == "completed"


def test_the_long_reach_of_2s_does_not_make_it_infinite():
    scene = nrchain.load_scene("buckling", **{"slip.neighbours": "all"})
    assert all("inf" not in text for text in warnings(scene))


def test_a_chain_is_judged_by_what_all_its_spheres_do_together():
    """A strong end pushes the next sphere with f, which drags the others along: T₁ = 2V γ_T − f."""
    strengths = [200.0] + [1.0] * 19
    end = nrchain.load_scene("buckling", **{"slip.2s": strengths, "chain.ends": "free"})
    strong, weak = (6 * math.pi * 7 / 300 * one for one in (200.0, 1.0))
    drag = (strong - weak) / 20
    (warning,) = warnings(end)
    assert (
        f"tension T = {2 * drag - strong + 2 * weak:.3g} of a link is -0.41 times λ∥d = 193"
        in warning
    )
    assert warnings(nrchain.load_scene(end, **{"slip.2s": [20.0] + [1.0] * 19})) == []


def test_weak_shear_is_found_and_its_remedy_holds():
    soft = {"elasticity": {"ratio": None, "stretch": 500.0, "shear": 5.0}}
    scene = nrchain.load_scene("buckling", **soft)
    (warning,) = warnings(scene)
    assert "is 0.88 times λ⊥d = 50, and links turn away" in warning
    shear = float(re.search(r"elasticity.shear = (\S+) holds it$", warning)[1])
    assert warnings(nrchain.load_scene(scene, **{"elasticity.shear": shear})) == []


@pytest.mark.parametrize("changes", [{}, {"friction": "pairwise"}, {"elasticity.bend": 0.0}])
def test_a_passive_chain_is_judged_too(changes):
    assert warnings(nrchain.load_scene("passive", **changes)) == []


def test_what_cannot_be_judged_is_said():
    """A straight chain that does not stay straight, and strengths beyond the range of floats."""
    tilted = {"slip.4a": 100.0, "slip.4a.axis": [1.0, 1.0, 0.0]}
    (warning,) = warnings(nrchain.load_scene("passive", **tilted))
    assert "cannot be judged before the run: slip = " in warning
    assert any("cannot" in x for x in warnings(nrchain.load_scene("stable", **{"slip.2s": -1e200})))


def test_description_carries_the_warnings():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 64})
    assert nrchain.describe(scene).warnings == warnings(scene)
