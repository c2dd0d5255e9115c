"""Branches of cycles from a Hopf point, against its rates, runs and cycles found by themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import nrchain
from nrchain.comoving.motions import moved
from nrchain.errors import SceneError, TrajectoryError
from nrchain.states.cycles.branch import COLUMNS
from nrchain.states.cycles.charts import chart
from nrchain.states.cycles.file import write_cycles

MIX = {
    "chain.particles": 12,
    "slip.2s": 200.0,
    "slip.3t": 3900.0,
    "elasticity.ratio": 1e8,
}
ALONG = {"slip.3t": (3900.0, 4700.0)}
TIGHT = {"run.rtol": 1e-10, "run.atol": 1e-10, "run.integrator": "radau", "run.snapshots": 2}


@pytest.fixture(scope="module")
def scene():
    """A straight chain that begins to oscillate at 3t = 4173."""
    return nrchain.load_scene("buckling", **MIX)


@pytest.fixture(scope="module")
def onset(scene):
    found = nrchain.continue_state(scene, ALONG, branches=1)
    (point,) = [one for one in found.special if one.kind == "Hopf"]
    return point


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cycles") / "found"


@pytest.fixture(scope="module")
def branches(scene, onset, folder):
    found = nrchain.continue_cycle(
        scene, ALONG, onset, steps=3, step=0.1, intervals=12, output=folder
    )
    return found.branches


@pytest.fixture(scope="module")
def cycle(branches):
    return branches[0].cycle(-1)


@pytest.mark.slow
def test_two_kinds_of_oscillation_leave_a_hopf_point_with_two_modes(branches, onset):
    """One goes to and fro and is unstable, the other goes round and is stable."""
    assert onset.multiplicity == 2
    assert len(branches) == 2
    assert sorted(branch.is_stable[-1] for branch in branches) == [False, True]
    for branch in branches:
        flat = np.linalg.svd(branch.orbits[-1].excursions.reshape(-1, 3)[:, 1:], compute_uv=False)
        assert (flat[1] > 0.1 * flat[0]) == branch.is_stable[-1]


def test_branches_leave_at_the_strength_and_frequency_of_the_hopf_point(branches, onset):
    """Amplitudes are square roots of the distance from it, and periods go to 2π/ω."""
    for branch in branches:
        beyond = branch.values[:3] - onset.value
        squares = branch.amplitudes[:3] ** 2
        assert np.ptp(squares / beyond) < 0.03 * squares[0] / beyond[0]
        # T is linear in p near the point
        slope = (branch.periods[1] - branch.periods[0]) / (beyond[1] - beyond[0])
        at_onset = branch.periods[0] - slope * beyond[0]
        assert at_onset == pytest.approx(2.0 * np.pi / onset.frequency, rel=1e-3)


def test_a_run_goes_round_a_cycle_of_a_branch(branches):
    (branch,) = [one for one in branches if one.is_stable[-1]]
    cycle = branch.cycle(-1)
    assert branch.periods[-1] == pytest.approx(cycle.period, rel=1e-4)
    assert branch.multipliers[-1, :2] == pytest.approx(cycle.multipliers[:2], abs=1e-4)
    changed = nrchain.load_scene(cycle.scene, **TIGHT | {"run.end": cycle.period})
    positions, frames = cycle.at(0.0)
    run = nrchain.simulate(changed, positions=positions, frames=frames)
    assert run.positions[-1] == pytest.approx(positions, abs=2.0 * cycle.error)


@pytest.mark.slow
def test_a_branch_ends_where_its_oscillation_dies_out(branches, onset):
    (branch,) = [one for one in branches if one.is_stable[-1]]
    cycle, own = branch.cycle(2), float(branch.values[2])
    found = nrchain.continue_cycle(
        cycle.scene, {"slip.3t": (3900.0, own + 20.0)}, cycle, step=0.2, intervals=12
    )
    (back,) = found.branches
    assert back.reasons == (
        "the oscillation dies out at a Hopf point",
        "the end of the range is reached",
    )
    assert back.values[-1] == own + 20.0
    assert back.values[0] == pytest.approx(onset.value, rel=2e-3)
    assert np.all(np.diff(back.values) > 0.0)
    assert np.interp(own, back.values, back.periods) == pytest.approx(cycle.period, rel=1e-3)


def test_scenes_off_the_line_and_points_of_another_kind_are_refused(scene, cycle, onset):
    with pytest.raises(SceneError, match="on the line"):
        nrchain.continue_cycle(cycle.scene, {"slip.3t": (5000.0, 6000.0)}, cycle)
    with pytest.raises(SceneError, match="Hopf point, a cycle or a trajectory"):
        nrchain.continue_cycle(scene, ALONG, replace(onset, kind="fold"))


def test_files_hold_whole_branches(branches, cycle, folder, tmp_path):
    found = nrchain.CycleDiagram.open(folder).branches
    assert found[0].cycle(-1).period == cycle.period
    for read, branch in zip(found, branches, strict=True):
        assert (read.line, read.reasons) == (branch.line, branch.reasons)
        for name in COLUMNS:
            assert np.array_equal(getattr(read, name), getattr(branch, name))
    special = nrchain.SpecialCycle("fold", 4500.0, 1e-3, 0.0, 1, 2, branches[0].orbits[1])
    write_cycles(tmp_path / "cycles-000.h5", replace(branches[0], special=(special,)))
    (again,) = nrchain.CycleDiagram.open(tmp_path).special
    assert (again.kind, again.index) == ("fold", 2)
    assert again.orbit.period == branches[0].periods[1]
    assert np.array_equal(again.orbit.frames, branches[0].orbits[1].frames)
    with pytest.raises(TrajectoryError, match="holds no cycles"):
        nrchain.CycleDiagram.open(tmp_path / "nowhere")


@pytest.mark.slow
def test_runs_off_a_cycle_decay_before_a_neimark_sacker_point_and_grow_beyond():
    """The multipliers on both sides are those of runs, to 1 %, and cross the unit circle there."""
    strong = nrchain.load_scene("buckling", **MIX | {"slip.3t": 11500.0, "run.end": 1500.0})
    run = nrchain.simulate(nrchain.load_scene(strong, **{"run.snapshots": 1501}))
    along = {"slip.3t": (11400.0, 12080.0)}
    found = nrchain.continue_cycle(strong, along, run, step=0.1, intervals=24)
    (special,) = found.special
    assert special.kind == "Neimark–Sacker"
    (branch,) = found.branches
    for place, grows in ((special.index, False), (special.index + 1, True)):
        cycle = branch.cycle(place, tolerance=1e-5)
        start, mode = cycle.at(0.0), cycle.modes[0]
        positions, frames = moved(*start, 1e-4 * mode.real)
        ends = {"run.end": 3.0 * cycle.period, "run.snapshots": 4}
        changed = nrchain.load_scene(cycle.scene, **TIGHT | ends)
        off = nrchain.simulate(changed, positions=positions, frames=frames)
        changed = nrchain.load_scene(changed, **{"run.end": 1e-3, "run.snapshots": 2})
        on = nrchain.simulate(changed, positions=start[0], frames=start[1])
        path = chart(on.positions[-1], on.frames[-1], start)
        columns = np.stack([mode.real, mode.imag, path], axis=-1).reshape(-1, 3)
        first, last = (
            np.linalg.lstsq(columns, chart(*pose, start).ravel(), rcond=None)[0][:2] @ [1.0, -1.0j]
            for pose in zip(off.positions[[1, 3]], off.frames[[1, 3]], strict=True)
        )
        assert (last / first) == pytest.approx(cycle.multipliers[0] ** 2, rel=0.02)
        assert (abs(last / first) > 1.0) == grows
        assert cycle.is_stable != grows
