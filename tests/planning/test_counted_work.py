"""Nominal work: what compiled steps and probes count for the same chain."""

import pytest

import nrchain
from nrchain.planning.counted_work import evaluation_work, interpreted_work

NEAR = {"chain.particles": 12, "chain.radius": 0.5}


def works(**changes):
    """Of a right-hand side with each integrator."""
    scene = nrchain.load_scene("buckling", **NEAR, **changes)
    return {
        name: evaluation_work(nrchain.load_scene(scene, **{"run.integrator": name}))
        for name in ("auto", "radau", "cvode", "scipy-bdf")
    }


@pytest.mark.parametrize("reach", [1, 3, 8])
def test_near_neighbours_count_as_compiled_where_radau_steps(reach):
    found = works(**{"slip.neighbours": reach})
    assert found["auto"] == found["radau"] < 0.5 * found["cvode"]
    assert found["cvode"] == found["scipy-bdf"]


@pytest.mark.parametrize(
    "changes",
    [{"slip.neighbours": "all"}, {"friction": "pairwise"}, {"slip.neighbours": 9}],
)
def test_interactions_beyond_them_count_alike_with_every_integrator(changes):
    assert len(set(works(**changes).values())) == 1


def test_a_probe_counts_the_steps_that_it_takes_whatever_the_run_does():
    scene = nrchain.load_scene("buckling", **NEAR)
    rival = nrchain.load_scene(scene, **{"run.integrator": "cvode"})
    assert interpreted_work(scene) == interpreted_work(rival) == evaluation_work(rival)


def test_wider_reach_costs_more_beyond_what_elasticity_couples():
    near, same, wide = (works(**{"slip.neighbours": k})["radau"] for k in (1, 3, 6))
    assert near == same < wide


def test_the_disturbance_of_a_flow_counts_as_slip_of_its_reach():
    shear = {"flow.gradient": [[0.0, 0.1, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}
    for reach in (3, 6):
        disturbed = works(**shear, **{"flow.neighbours": reach})
        assert disturbed["radau"] == works(**{"slip.neighbours": reach})["radau"]
        assert disturbed["radau"] < 0.5 * disturbed["cvode"]
    assert len(set(works(**shear, **{"flow.neighbours": "all"}).values())) == 1


def test_friction_of_near_neighbours_counts_as_compiled_without_clamps():
    near = {"friction": {"kind": "pairwise", "neighbours": 2}}
    found = works(**near, **{"chain.ends": "free"})
    assert works(**{"chain.ends": "free"})["radau"] < found["radau"] < 0.5 * found["cvode"]
    assert len(set(works(**near, **{"chain.ends": "clamped"}).values())) == 1
