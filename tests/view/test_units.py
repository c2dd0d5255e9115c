"""Units of axes: those of the paper where a scene has them, and none where it has others."""

import math

import pytest

import nrchain
from nrchain.view import units


@pytest.mark.parametrize(
    ("changes", "time", "speed"),
    [
        ({}, True, True),
        ({"elasticity.bend": 1.0}, False, False),
        # γ_T d² and μ grow alike, but a is 2
        ({"chain.radius": 2.0}, True, False),
    ],
)
def test_a_unit_is_named_where_it_is_one(changes, time, speed):
    scene = nrchain.load_scene("buckling", **changes)
    assert ("gamma" in units.label("t", scene, "time")) == time
    assert ("mu" in units.label("v", scene, "speed")) == speed
    assert (units.words("size", scene, "length") == "size  [$a$]") == (
        "chain.radius" not in changes
    )


def test_the_unit_of_time_in_words():
    scene = nrchain.load_scene("buckling", **{"elasticity.bend": 1.0})
    assert units.time_unit(scene) == f"γ_T d²/μ = {600 * math.pi:.4g} units of t"
    soft = nrchain.load_scene("buckling", **{"elasticity.bend": 0.0, "elasticity.twist": 1.0})
    assert units.time_unit(soft) == ""
