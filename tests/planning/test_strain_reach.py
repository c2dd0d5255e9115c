"""The reach of a disturbed flow in plan and cost, against a sum."""

import numpy as np
import pytest

import nrchain
from nrchain.accuracy.cost.settings import reach_and_model
from nrchain.planning.plan import plan

RATE, D, COUNT, RADIUS = 0.01, 7.0, 9, 1.4
FLOW = {"flow.gradient": np.diag([RATE, -RATE / 2, -RATE / 2])}


def make(**changes):
    chain = {"particles": COUNT, "spacing": D, "radius": RADIUS}
    return nrchain.load_scene({"chain": chain, "run.end": 1.0}, **FLOW, **changes)


def reach_line(scene):
    return [line for line in plan(scene).lines if line.quantity == "reach of strain"]


@pytest.mark.parametrize("neighbours", [1, 3])
def test_a_plan_states_what_the_reach_leaves_out(neighbours):
    """Along a straight chain in an extension sphere k feels Σ ± 1/m²."""
    places = np.arange(COUNT)
    gaps = places[:, None] - places
    terms = np.sign(gaps) / np.where(gaps == 0, 1, gaps) ** 2
    beyond = np.where(np.abs(gaps) > neighbours, terms, 0.0).sum(axis=1)
    share = np.abs(beyond).max() / np.abs(terms.sum(axis=1)).max()
    (line,) = reach_line(make(**{"flow.neighbours": neighbours}))
    assert line.value == f"{100 * share:.3g} % left out"
    assert "flow.neighbours = 'all' keeps it" in line.meaning


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"flow.neighbours": COUNT - 1},
        {"flow.neighbours": 1, "flow.disturbance": False},
        {"flow.gradient": [[0, 1, 0], [-1, 0, 0], [0, 0, 0]], "flow.neighbours": 1},
    ],
)
def test_a_plan_is_silent_where_nothing_is_cut(changes):
    scene = nrchain.load_scene(make(), **changes)
    assert not reach_line(scene)


def test_cost_compares_reach_and_size_of_a_disturbed_flow():
    axes = reach_and_model(make(**{"flow.neighbours": 1}))
    assert axes["reach"]["2 neighbours"] == {"flow.neighbours": 2}
    assert axes["reach"]["all pairs"] == {"flow.neighbours": "all"}
    assert axes["model"] == {
        "the scene itself": {},
        "all pairs": {"flow.neighbours": "all"},
        "… with finite size": {"flow.neighbours": "all", "flow.finite_size": True},
        "… and pairwise friction": {
            "flow.neighbours": "all",
            "flow.finite_size": True,
            "friction": "pairwise",
        },
    }
    both = reach_and_model(make(**{"slip.2s": 10.0}))
    assert both["reach"]["1 neighbour"] == {"slip.neighbours": 1, "flow.neighbours": 1}
    assert both["model"]["… with finite size"] == {
        "slip.neighbours": "all",
        "flow.neighbours": "all",
        "slip.finite_size": True,
        "flow.finite_size": True,
    }
