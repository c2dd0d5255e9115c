"""How a scene sums over all pairs, and the error that a plan measures."""

import numpy as np
import pytest
from support.long_chains import long_chain

import nrchain
from nrchain.motion.model import Model
from nrchain.planning.pair_sums import pair_sum_errors, sum_over_pairs, unused_accuracy
from nrchain.planning.plan import plan

COUNT = 2500
LONG = {
    "chain.particles": COUNT,
    "elasticity.stretch": 200.0,
    "elasticity.shear": 200.0,
    "slip.2s": 100.0,
    "slip.4a": 1e3,
    "slip.neighbours": "all",
    "slip.accuracy": 1e-4,
    "friction": "pairwise",
    "run.end": 1.0,
}


def test_a_long_chain_is_summed_by_a_tree():
    scene = nrchain.load_scene(LONG)
    assert sum_over_pairs(scene) == "by a tree, relative error 0.0001"
    assert not unused_accuracy(scene)
    model = Model(scene)
    assert model.slip.tree
    assert model.friction.tree


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"chain.particles": 200}, "chains of fewer than"),
        ({"chain.ends": "periodic"}, "periodic"),
        ({"slip.neighbours": 3, "friction": "one-body"}, "nrchain sums neither"),
        ({"slip.backend": "pystokes", "friction.backend": "pystokes"}, "nrchain sums neither"),
    ],
)
def test_a_chain_that_is_summed_directly_says_why(changes, reason):
    scene = nrchain.load_scene(LONG, **changes)
    assert sum_over_pairs(scene) in ("", "direct")
    assert reason in unused_accuracy(scene)
    model = Model(scene)
    assert not model.slip.tree
    assert not (model.friction and model.friction.tree)


def test_direct_sums_on_demand():
    scene = nrchain.load_scene(LONG, **{"slip.accuracy": "direct"})
    assert sum_over_pairs(scene) == "direct"
    assert not unused_accuracy(scene)
    assert not Model(scene).slip.tree


def test_the_accuracy_follows_the_tolerance_of_the_run():
    scene = nrchain.load_scene(LONG, **{"slip.accuracy": None, "run.rtol": 1e-5})
    assert scene.pair_accuracy == 1e-5
    assert nrchain.load_scene(scene, **{"run.rtol": 1e-13}).pair_accuracy == 0.0
    assert nrchain.load_scene(scene, **{"slip.accuracy": 1e-3}).pair_accuracy == 1e-3
    assert nrchain.load_scene(scene, **{"slip.accuracy": "direct"}).pair_accuracy == 0.0


@pytest.mark.slow
def test_measured_errors_are_those_against_direct_sums():
    scene = nrchain.load_scene(LONG)
    positions, frames = long_chain("walk", COUNT)
    errors = pair_sum_errors(scene, positions, frames, sample=COUNT)
    assert [error.name for error in errors] == ["slip", "friction"]
    assert all(0.0 < max(error.velocity, error.spin) < 1e-4 for error in errors)
    twists = []
    for one in (scene, nrchain.load_scene(scene, **{"slip.accuracy": "direct"})):
        twists.append(np.zeros((COUNT, 6)))
        Model(one).add_slip_twists(positions, frames, twists[-1])
    found, exact = (t[:, :3] for t in twists)
    assert errors[0].velocity == pytest.approx(np.abs(found - exact).max() / np.abs(exact).max())


@pytest.mark.slow
def test_a_plan_tells_the_measured_error():
    scene = nrchain.load_scene(LONG, **{"friction": "one-body"})
    line = next(line for line in plan(scene).lines if line.quantity == "sum of slip")
    assert line.value.startswith("error = ")
    assert "0.0001 is allowed" in line.meaning


@pytest.mark.slow
def test_the_disturbance_of_a_flow_is_measured_too():
    scene = nrchain.load_scene(
        LONG,
        **{"flow.gradient": [[0.0, 0.3, -0.1], [0.0, 0.2, 0.4], [0.0, -0.3, -0.2]]},
        **{"flow.finite_size": True, "slip.neighbours": 1, "friction": "one-body"},
    )
    assert sum_over_pairs(scene).startswith("by a tree")
    errors = pair_sum_errors(scene, *long_chain("coil", COUNT))
    assert [error.name for error in errors] == ["strain", "finite size of strain"]
    assert all(0.0 < error.velocity < 1e-4 for error in errors)
