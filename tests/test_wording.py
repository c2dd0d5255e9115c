"""A range whose printed ends differ shows both, any other one number."""

import re

import numpy as np
import pytest

import nrchain
from nrchain.effects.slip import effect_of
from nrchain.hydrodynamics.slip_modes import find
from nrchain.scene.derived import modes_text
from nrchain.wording import span


def test_a_range_whose_ends_look_alike_is_one_number():
    assert span("1.4", "1.4") == "1.4"
    assert span("1.4", "1.9") == "1.4 to 1.9"
    assert span("-2", "3", sign="–") == "-2–3"


@pytest.mark.parametrize(
    ("strengths", "shown"),
    [
        ([7.0, 7.0], "7"),
        ([7.0, 7.0 + 1e-9], "7"),
        ([-7.0, 3.0], "-7 to 3"),
        ([3.0, -7.0], "-7 to 3"),
    ],
)
def test_strengths_along_a_chain_are_shown_alike_everywhere(strengths, shown):
    scene = nrchain.load_scene("passive", **{"chain.particles": 2, "slip.2s": strengths})
    details = dict(nrchain.describe(scene).simulated)
    assert details["slip 2s"].startswith(f"strength {shown},")
    assert effect_of(find("2s")).detail(scene).startswith(f"strength {shown},")
    words = modes_text(scene.slip).removeprefix("2s ").replace("−", "-")
    assert [float(n) for n in re.split(" to ", words)] == sorted(
        {float(f"{s:g}") for s in np.asarray(strengths)}
    )
