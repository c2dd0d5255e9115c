"""The numbers of a scene that spectra are sensitive to, and scenes with one of them changed."""

import numpy as np
import pytest

import nrchain
from nrchain.states.parameters import parameters

AXIS = (-1.0, 0.0, 0.0)


def scene():
    changes = {
        "chain.particles": 4,
        "slip.2s": [1.0, 2.0, 3.0, 0.0],
        "slip.3a": {"strength": 40.0, "axis": AXIS},
        "field.body_force": [3.0, 0.0, 0.0],
        "slip.4a": 0.0,
    }
    return nrchain.load_scene("buckling", **changes)


def test_every_number_that_acts_is_a_parameter():
    found = {one.key: one.value for one in parameters(scene())}
    strengths = {f"slip.2s[{k}]": value for k, value in enumerate([1.0, 2.0, 3.0, 0.0])}
    force = {f"field.body_force[{k}]": value for k, value in enumerate([3.0, 0.0, 0.0])}
    chain = {"chain.spacing": 10.0, "chain.radius": 1.0, "chain.viscosity": 1.0}
    bend = scene().moduli.bend
    links = {"elasticity.ratio": 1e7, "elasticity.twist": bend, "elasticity.bend": bend}
    assert found == chain | links | strengths | force | {"slip.3a": 40.0}


@pytest.mark.parametrize("one", parameters(scene()), ids=lambda one: one.key)
def test_a_changed_scene_differs_in_that_number_alone(one):
    changed = one.changed(one.value + 0.5)
    found = {other.key: other.value for other in parameters(changed)}
    before = {other.key: other.value for other in parameters(scene())}
    assert found.pop(one.key) == pytest.approx(one.value + 0.5)
    follows = {"elasticity.twist", "elasticity.bend"} if one.key.startswith("chain") else set()
    follows |= {"elasticity.twist"} if one.key == "elasticity.bend" else set()
    for key, value in found.items():
        assert key in follows or value == before[key]
    assert changed.slip.modes["3a"].axis == AXIS


def test_the_sensitivity_to_a_body_force_is_a_difference_of_spectra():
    changes = {"chain.particles": 6, "chain.ends": "free", "field.body_force": [3.0, 0.0, 0.0]}
    given = nrchain.load_scene("wave", **changes)
    found = nrchain.spectrum(given)
    slope = found.sensitivities(keys=["field.body_force[0]"])["field.body_force[0]"]
    sides = [
        nrchain.spectrum(nrchain.load_scene(given, **{"field.body_force": [f, 0.0, 0.0]}))
        for f in (3.01, 2.99)
    ]
    expected = np.subtract(*(side.leading.rate for side in sides)) / 0.02
    assert slope == pytest.approx(expected, rel=1e-4)
