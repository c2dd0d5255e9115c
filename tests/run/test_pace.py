"""How often a run looks at signals and budgets changes none of its results."""

import numpy as np
import pytest
from support.stepping import small

import nrchain
from nrchain.run import budget

SLACK = dict.fromkeys(("stretch", "shear", "twist", "bend"), 0.0)
EXTENDED = {
    # the flow carries two free spheres farther in a step than they are apart
    "chain": {"particles": 2, "spacing": 6.0},
    "elasticity": SLACK,
    "flow": {
        "gradient": [[0.5, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0, 0.0, 0.0]],
        "disturbance": False,
    },
    "start": {"shape": "given", "positions": [[300.0, 0.0, 0.0], [306.0, 1.0, 2.0]]},
    "run": {"end": 8.0, "rtol": 1e-3, "atol": 1e-3},
}


@pytest.mark.parametrize("integrator", ["radau", "cvode"])
@pytest.mark.parametrize(
    "table", [EXTENDED, small("buckling", 6, 400.0)], ids=["extended", "buckling"]
)
def test_the_pace_of_looks_does_not_change_a_bit(integrator, table, monkeypatch):
    changes = {"run.integrator": integrator, "run.snapshots": 2}
    scene = nrchain.load_scene(table, **changes)
    runs = []
    for seconds in (1e-9, 10.0):
        monkeypatch.setattr(budget, "LOOK", seconds)
        runs.append(nrchain.simulate(scene))
    often, seldom = runs
    assert often.counters["steps"] == seldom.counters["steps"] > 10
    assert np.array_equal(often.positions, seldom.positions)
    assert np.array_equal(often.frames, seldom.frames)


def test_steps_are_counted_exactly_however_many_are_taken_at_once(monkeypatch):
    monkeypatch.setattr(budget, "LOOK", 10.0)
    changes = {"run.integrator": "radau", "run.snapshots": 2, "run.max_steps": 17}
    run = nrchain.simulate(nrchain.load_scene("buckling", **changes))
    assert run.cause is nrchain.Cause.BUDGET
    assert run.counters["steps"] == 17


def test_the_pace_follows_the_time_of_steps():
    pace = budget.Pace()
    assert pace.steps == 1
    pace.measure(1, 1e-9)
    assert pace.steps == 10
    for _ in range(9):
        pace.measure(pace.steps, pace.steps * budget.LOOK / 100.0)
    assert pace.steps == pytest.approx(100, abs=1)
    pace.measure(1, 10.0)
    assert pace.steps == 1
