"""The parts of all effects add up to the motion, and each equals its own law."""

import numpy as np
import pytest
from support.poses import random_chain

import nrchain
from nrchain.analysis.decomposition import SUPPORT
from nrchain.effects.registry import acting
from nrchain.errors import SceneError
from nrchain.motion.model import Model

MODES = {"2s": 30.0, "3a": 20.0, "3t": -40.0, "4a": 50.0}
STERIC = {"kind": "harmonic", "strength": 50.0, "range": 3.9}
FIELD = {"force": [1.0, 2.0, -3.0], "body_torque": [1.0, 0.0, 5.0]}
TORQUE = {"torque": [1.0, 2.0, -3.0]}
SHEAR = {"gradient": [[0.0, 0.2, -0.1], [0.0, 0.0, 0.3], [0.0, 0.1, 0.0]]}
MODULI = {"stretch": 3.0, "shear": 5.0, "twist": 7.0, "bend": 11.0}
SLACK = dict.fromkeys(MODULI, 0.0)
PAIRS = {"kind": "pairwise"}

SCENES = {
    "passive": {},
    "isotropic": {"elasticity": MODULI | {"measure": "isotropic"}},
    "slip alone, clamped": {"slip": MODES, "elasticity": SLACK, "chain.ends": "clamped"},
    "all modes, free": {"slip": MODES | {"neighbours": "all", "finite_size": True}},
    "reach of three, periodic": {"slip": MODES | {"neighbours": 3}, "chain.ends": "periodic"},
    "all images": {
        "slip": MODES | {"neighbours": "all"},
        "chain.ends": "periodic",
        "friction": PAIRS,
        "field": TORQUE,
        "flow": SHEAR | {"finite_size": True},
    },
    "clamped through the fluid": {
        "slip": MODES | {"finite_size": True},
        "chain.ends": "clamped",
        "friction": PAIRS,
        "steric": STERIC,
        "field": FIELD,
        "flow": SHEAR,
    },
    "everything, free": {
        "slip": MODES | {"finite_size": True, "neighbours": 2},
        "friction": PAIRS | {"neighbours": 3},
        "steric": STERIC,
        "field": FIELD,
        "flow": SHEAR | {"finite_size": True, "neighbours": 4},
    },
    "pystokes": {
        "slip": MODES | {"backend": "pystokes", "neighbours": 2, "finite_size": True},
        "friction": PAIRS | {"backend": "pystokes"},
    },
}


def make(**changes):
    chain = {"particles": 6, "spacing": 4.0}
    base = {"chain": chain, "elasticity": MODULI, "run.end": 1.0}
    return nrchain.load_scene(base, **changes)


@pytest.mark.parametrize("name", SCENES)
def test_contributions_sum_to_the_motion(name):
    scene = make(**SCENES[name])
    poses = random_chain(6, spacing=4.0)
    found = nrchain.contributions(scene, *poses)
    model = Model(scene)
    assert np.array_equal(found.total.twist, model.twists(*poses))
    expected = [effect.name for effect in acting(scene)]
    assert set(found) == {*expected} | ({SUPPORT} if model.held.any() else set())
    for quantity in ("twist", "wrench"):
        parts = np.array([getattr(part, quantity) for part in found.values()])
        whole, largest = getattr(found.total, quantity), np.abs(parts).max()
        assert np.abs(parts.sum(axis=0) - whole).max() <= 1e-12 * largest


def test_a_part_is_what_is_lost_with_its_effect():
    """With one-body friction effects add: the motion without one is the total less its part."""
    scene = make(**SCENES["everything, free"], **{"friction.kind": "one-body"})
    poses = random_chain(6, spacing=4.0)
    found = nrchain.contributions(scene, *poses)
    for effect in acting(scene):
        without = Model(effect.without(scene)).twists(*poses)
        lost = found.total.twist - without
        if effect.name in TAKEN_ALONG:
            assert lost != pytest.approx(found[effect.name].twist, abs=1e-12)
        else:
            assert lost == pytest.approx(found[effect.name].twist, abs=1e-12), effect.name


TAKEN_ALONG = {f"slip {m}" for m in MODES} | {"finite size", "flow", "strain"}
"""With a mode goes the reach and the finite size of its flow, with the flow its strain, with the
strain its finite size, and with the finite size of slip what it adds beyond the nearest neighbours.
"""


def test_modes_are_those_of_scenes_that_name_them_alone():
    scene = make(slip=MODES, elasticity=SLACK)
    poses = random_chain(6, spacing=4.0)
    found = nrchain.contributions(scene, *poses)
    for label, strength in MODES.items():
        alone = make(slip={label: strength}, elasticity=SLACK)
        expected = Model(alone).twists(*poses)
        assert found[f"slip {label}"].twist == pytest.approx(expected, rel=1e-12, abs=1e-15)


def test_supports_hold_the_clamped_spheres():
    scene = make(**SCENES["clamped through the fluid"])
    found = nrchain.contributions(scene, *random_chain(6, spacing=4.0))
    support = found[SUPPORT].wrench
    assert support[[0, -1]].all()
    assert not support[1:-1].any()
    assert not found.total.twist[[0, -1]].any()


def test_sizes_over_a_trajectory():
    scene = make(slip=MODES, **{"run.snapshots": 3, "start.shape": "random"})
    trajectory = nrchain.simulate(scene)
    sizes = nrchain.contribution_sizes(trajectory)
    last = nrchain.contributions(scene, trajectory.positions[-1], trajectory.frames[-1])
    assert set(sizes) == {*last, "total"}
    twist = last["slip 2s"].twist
    expected = np.sqrt(np.mean(np.sum(twist**2, axis=1)))
    assert sizes["slip 2s"].shape == (3,)
    assert sizes["slip 2s"][-1] == pytest.approx(expected)


def test_poses_of_another_chain_are_refused():
    with pytest.raises(SceneError, match="positions"):
        nrchain.contributions(make(), *random_chain(5))
