"""A description names the effects that act, those left out, and keys without effect."""

import numpy as np
import pytest

import nrchain
from nrchain.planning.description import without_effect

SMALL = {"chain.particles": 4, "run.end": 1.0, "run.snapshots": 2}


def small(**changes):
    return nrchain.load_scene("buckling", **SMALL, **changes)


@pytest.mark.parametrize("name", nrchain.scene_names())
def test_all_that_shipped_scenes_set_has_an_effect(name):
    assert not nrchain.describe(nrchain.load_scene(name)).without_effect


def test_a_description_is_shown_in_one_line():
    shown = repr(nrchain.describe(nrchain.load_scene("buckling")))
    assert shown.startswith("Description(simulated=list of ")
    assert len(shown) < 160


def test_what_acts_and_what_does_not():
    described = nrchain.describe(small(**{"slip.3a": 0.0}))
    assert ("slip 2s", "strength 100, 1 neighbour a side") in described.simulated
    assert ("slip 3a", "strength 0") in described.left_out
    assert ("measure of twist and bend", "paper") in described.simulated
    assert ("pair laws of slip", "native") in described.simulated
    assert ("integrator", "auto: radau, rtol 1e-06, atol 1e-06") in described.simulated
    assert ("finite size", "(a/r)² in the velocity of 2s") in described.left_out


def test_finite_size_is_described_only_for_modes_that_have_it():
    described = nrchain.describe(small(**{"slip.2s": None, "slip.3t": 1.0}))
    assert "finite size" not in dict(described.simulated) | dict(described.left_out)
    still = nrchain.describe(small(**{"slip.2s": 0.0}))
    assert "finite size" not in dict(still.left_out)
    assert "long range" not in dict(still.left_out)


def test_the_disturbance_is_described_where_there_is_a_flow():
    flow = {"gradient": [[0.0, 0.01, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}
    described = nrchain.describe(small(flow=flow))
    assert ("strain", "stresslet, all pairs") in described.simulated
    assert "finite size of strain" in dict(described.left_out)
    assert "long range of strain" not in dict(described.left_out)
    described = nrchain.describe(small(flow=flow | {"neighbours": 2, "finite_size": True}))
    assert dict(described.simulated)["strain"] == "stresslet, 2 neighbours a side"
    assert "finite size of strain" in dict(described.simulated)
    assert dict(described.left_out)["long range of strain"] == (
        "disturbances beyond 2 neighbours a side"
    )
    described = nrchain.describe(small(flow=flow | {"disturbance": False}))
    assert {"strain"} == {"strain", "finite size of strain"} & dict(described.left_out).keys()
    described = nrchain.describe(small())
    assert not {"strain", "finite size of strain"} & dict(described.left_out).keys()


def test_a_fluid_at_rest_and_the_near_field_that_no_mobility_has_are_named():
    described = nrchain.describe(small())
    assert dict(described.left_out)["flow"] == "the fluid is at rest far away"
    assert "near field" not in dict(described.left_out)
    described = nrchain.describe(small(friction="pairwise", flow={"gradient": _TURN}))
    assert "flow" not in dict(described.left_out)
    assert dict(described.left_out)["near field"] == "lubrication and reflections, of order (a/r)⁴"


_SHEAR = [[0.0, 0.01, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
_TURN = [[0.0, 0.01, 0.0], [-0.01, 0.0, 0.0], [0.0, 0.0, 0.0]]

INERT = [
    ({"flow.neighbours": 2}, "flow.neighbours"),
    ({"flow.disturbance": False, "flow.gradient": _TURN}, "flow.disturbance"),
    ({"flow": {"disturbance": False, "gradient": _SHEAR, "finite_size": True}}, "flow.finite_size"),
    ({"flow": {"gradient": _SHEAR}, "slip.2s": None, "slip.neighbours": 2}, "slip.neighbours"),
    ({"friction": {"neighbours": 1}}, "friction.neighbours"),
    ({"slip.accuracy": 1e-3}, "slip.accuracy"),
    ({"slip.accuracy": 1e-3, "slip.neighbours": "all"}, "slip.accuracy"),
    ({"slip.accuracy": "direct", "slip.2s": None}, "slip.accuracy"),
    ({"friction": {"backend": "pystokes"}}, "friction.backend"),
    ({"slip.2s": 0.0, "slip.2s.axis": [0, 1, 0]}, "slip.2s.axis"),
    ({"slip.2s": None, "slip.neighbours": 2}, "slip.neighbours"),
    ({"slip.2s": None, "slip.3t": 1.0, "slip.finite_size": True}, "slip.finite_size"),
    ({"elasticity": {"bend": 0.0, "measure": "isotropic"}}, "elasticity.measure"),
    ({"elasticity": {"bend": 0.0, "ratio": 1e6}}, "elasticity.ratio"),
    ({"start.shape": "straight", "start.amplitude": 0.3}, "start.amplitude"),
    ({"start.shape": "random", "start.wavenumber": 2}, "start.wavenumber"),
    ({"start.shape": "sine", "start.seed": 2}, "start.seed"),
]


@pytest.mark.parametrize(("changes", "key"), INERT)
def test_a_key_without_effect_is_named_and_has_none(changes, key):
    scene = small(**changes)
    assert key in dict(without_effect(scene))
    plain = nrchain.load_scene(scene, **{key: None})
    assert key not in dict(without_effect(plain))
    runs = [nrchain.simulate(one) for one in (scene, plain)]
    np.testing.assert_array_equal(runs[0].positions, runs[1].positions)
    np.testing.assert_array_equal(runs[0].frames, runs[1].frames)
