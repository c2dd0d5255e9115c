"""A run that ends early is complete: on disk, resumed, verified, among many."""

import numpy as np
import pytest
from support.selection import few_of

import nrchain

SETTLES = nrchain.load_scene(
    "buckling",
    **{"chain.particles": 6, "slip.neighbours": 1, "slip.2s": 900.0, "elasticity.ratio": 1e6},
    **{"elasticity.measure": "isotropic", "start.amplitude": 0.5},
    **{"run.end": 200.0, "run.snapshots": 401, "run.until": "settled"},
)


@pytest.fixture(scope="module")
def whole():
    run = nrchain.simulate(SETTLES)
    assert "settled" in run.reason
    assert len(run.time) < 401
    return run


def same(run, other):
    return (
        np.array_equal(run.time, other.time)
        and np.array_equal(run.positions, other.positions)
        and np.array_equal(run.frames, other.frames)
        and (run.status, run.reason) == (other.status, other.reason)
    )


def test_its_file_is_complete_and_is_not_resumed(whole, tmp_path):
    assert same(nrchain.simulate(SETTLES, output=tmp_path / "run.h5"), whole)
    assert same(nrchain.Trajectory.open(tmp_path / "run.h5"), whole)
    assert same(nrchain.resume(tmp_path / "run.h5"), whole)


@pytest.mark.parametrize("steps", few_of([3, 20, 40], {3, 40}))
def test_a_run_that_is_interrupted_ends_at_the_same_snapshot(whole, tmp_path, steps):
    budget = nrchain.load_scene(SETTLES, **{"run.max_steps": steps})
    run = nrchain.simulate(budget, output=tmp_path / "run.h5")
    assert run.cause is nrchain.Cause.BUDGET
    while run.cause is nrchain.Cause.BUDGET:
        run = nrchain.resume(tmp_path / "run.h5")
    assert same(run, whole)


def test_its_error_is_known_to_its_end(whole):
    run = nrchain.simulate(nrchain.load_scene(SETTLES, **{"run.verify": True}))
    assert same(run, whole)
    assert np.isfinite(run.position_error).all()


def test_members_end_early_each_by_itself(whole):
    weaker = nrchain.load_scene(SETTLES, **{"slip.2s": 0.0, "slip.neighbours": None})
    found = {m.index: m.result() for m in nrchain.simulate_many([SETTLES, weaker])}
    assert same(found[0], whole)
    assert "settled" in found[1].reason
    assert found[1].time[-1] != whole.time[-1]
