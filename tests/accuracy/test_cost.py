"""Error against wall time of a scene: distances, budgets, advice, and the command."""

import itertools
import math
import time
from dataclasses import replace

import numpy as np
import pytest
from support.command_line import call
from support.fake_clock import Processor, fake_processor

from nrchain import load_scene, simulate
from nrchain.accuracy import cost, timing
from nrchain.accuracy.cost import Point, WorkPrecision, short_runs, work_precision
from nrchain.accuracy.cost.settings import TOLERANCES
from nrchain.accuracy.timing import Measured, distance, measure_all, run_timed
from nrchain.cli.exits import REFUSED
from nrchain.errors import SceneError
from nrchain.geometry import lie
from nrchain.planning.counted_work import evaluation_work
from nrchain.run import work
from nrchain.run.work import LARGEST_FACTOR, RunCost, Work
from nrchain.trajectory.trajectory import Trajectory

SMALL = load_scene("buckling", **{"chain.particles": 5, "run.end": 50.0, "chain.radius": 0.5})


@pytest.fixture
def run():
    return simulate(load_scene(SMALL, **{"run.snapshots": 4}))


def altered(run, positions=None, frames=None):
    return Trajectory(
        run.time,
        run.positions if positions is None else positions,
        run.frames if frames is None else frames,
        run.scene,
        run.counters,
        run.status,
        run.reason,
    )


def measured(error, *seconds, late=0.5):
    return Measured(error, 0.1 * error, Work(10, 20, 3, 40), seconds, late, 1e-3)


def found(*pairs, reached=SMALL.run.end, reference_error=1e-10):
    points = [
        Point("stepping", f"setting {k}", {"run.rtol": 10.0**-k}, one)
        for k, one in enumerate(pairs)
    ]
    own = RunCost(Work(10, 20, 3, 40), 1.0, reached, SMALL.run.end)
    return WorkPrecision(SMALL, reached, own, points, "the reference", reference_error)


@pytest.mark.parametrize("angle", np.geomspace(1e-12, math.pi, 9))
def test_distance_is_in_radii_and_the_angle_of_the_turn_between_frames(run, angle):
    frames, positions = run.frames.copy(), run.positions.copy()
    turn = np.empty((3, 3))
    axis = np.array([0.6, 0.0, 0.8])
    half = min(angle, 0.999 * math.pi) / 2
    lie.cayley(2 * math.tan(half) * axis, turn)
    frames[2, 3] = frames[2, 3] @ turn.T
    positions[1, 2] += [0.0, 3e-3, 4e-3]
    apart, turned = distance(altered(run, positions, frames), run)
    assert apart == pytest.approx(5e-3 / 0.5, rel=1e-9)
    assert turned == pytest.approx(2 * half, rel=1e-3, abs=1e-15)


def test_the_late_half_of_a_run_takes_what_a_run_of_half_of_it_leaves():
    """Steps lengthen as the chain comes to rest."""
    tight = {"run.rtol": 1e-9, "run.atol": 1e-9}
    run, cost_of_run = run_timed(load_scene("passive", **tight, **{"run.end": 4.0}))
    half = simulate(load_scene("passive", **tight, **{"run.end": 2.0}))
    left = 1.0 - half.counters["evaluations"] / run.counters["evaluations"]
    assert 0.05 < left < 0.45
    assert cost_of_run.late == pytest.approx(left, abs=0.03)


def test_a_run_that_stopped_is_infinitely_far(run):
    short = Trajectory(
        run.time[:2], run.positions[:2], run.frames[:2], run.scene, {}, "stopped", "contact"
    )
    assert distance(short, run) == (math.inf, math.inf)


def test_runs_are_interleaved_until_the_work_is_done(monkeypatch, run):
    order = []
    done = RunCost(Work(10, 100, 3, 40), 0.25, SMALL.run.end, SMALL.run.end)

    def fake(scene):
        order.append(scene.run.rtol)
        return run, done

    monkeypatch.setattr(timing, "run_timed", fake)
    scenes = {str(tol): load_scene(SMALL, **{"run.rtol": tol}) for tol in (1e-3, 1e-4)}
    result = measure_all(scenes, run, repeats=3)
    assert order == [1e-3, 1e-4] * 3
    assert result["0.001"].seconds == (0.25,) * 3
    assert result["0.001"].nominal == 100 * evaluation_work(SMALL)
    order.clear()
    measure_all(scenes, run, repeats=3, budget=3.5 * result["0.001"].nominal)
    assert order == [1e-3, 1e-4, 1e-3]


def test_what_an_integrator_refuses_is_left_out_and_other_errors_are_not(monkeypatch, run):
    def refuse(scene):
        raise SceneError(scene.title, None, "no")

    monkeypatch.setattr(timing, "run_timed", refuse)
    assert measure_all({"": replace(SMALL, title="run.integrator")}, run) == {}
    with pytest.raises(SceneError):
        measure_all({"": replace(SMALL, title="slip")}, run)


def test_a_tighter_tolerance_is_left_out_where_the_one_before_took_too_long():
    """Each integrator is judged by its own last point alone."""
    changes = {
        f"{scheme} {k}": {"run.integrator": scheme} for scheme in ("bdf", "cvode") for k in range(3)
    }
    short = measured(1e-3, 1.0)
    points = {"bdf 0": replace(short, nominal=9.0), "bdf 1": replace(short, nominal=2.0)}
    points["cvode 0"] = replace(short, nominal=0.5)
    assert short_runs._too_long(changes, "bdf 2", points, 1.0)
    assert not short_runs._too_long(changes, "bdf 2", points, 3.0)
    assert not short_runs._too_long(changes, "cvode 1", points, 1.0)
    assert not short_runs._too_long(changes, "cvode 0", {"bdf 0": points["bdf 0"]}, 1.0)


def test_advice_is_the_cheapest_setting_that_is_sure():
    table = found(measured(1e-3, 1.0), measured(7e-5, 2.0), measured(4e-5, 5.0, 3.0, 4.0))
    advice = table.advise(1e-4)
    assert advice.point.setting == "setting 2"  # 7e-5 is within the margin of 1e-4
    assert advice.reached
    assert advice.seconds == (3.0, 5.0)
    assert advice.arguments == "--set run.rtol=0.01"
    assert "nothing is extrapolated" in advice.sure[-1]
    assert table.advise(2e-4).point.setting == "setting 1"


def test_advice_says_when_the_target_is_out_of_reach():
    advice = found(measured(1e-3, 1.0), measured(7e-5, 2.0)).advise(1e-6)
    assert not advice.reached
    assert advice.point.setting == "setting 1"
    assert "no setting reaches" in advice.sure[0]


def test_a_chain_that_does_not_move_is_measured_too():
    advice = found(measured(0.0, 1.0), reference_error=0.0).advise(1e-4)
    assert advice.reached
    assert advice.error == 0.0
    assert advice.sure[0] == "no two runs differ: the chain does not move"


def test_errors_near_that_of_the_reference_are_not_trusted():
    table = found(measured(1e-12, 1.0), reference_error=1e-9)
    assert not table.advise(1e-9).reached
    assert table.advise(1e-9).error == 1e-8


def test_a_short_run_is_extrapolated_in_proportion_to_time():
    table = found(measured(1e-6, 1.0, 2.0, late=0.25), reached=SMALL.run.end / 4)
    advice = table.advise(1e-5)
    assert advice.error == pytest.approx(4e-6)
    # half the pace of the whole in the second half, for the three quarters left
    assert advice.seconds == pytest.approx((1.0 + 3 * 0.5, 2.0 * 4))
    assert "proportion" in advice.sure[-1]
    assert advice.known


@pytest.mark.parametrize("part", [0.9 / LARGEST_FACTOR, 1.5e-5])
def test_too_small_a_part_is_not_extrapolated(part):
    table = found(measured(1e-6, 1.0, 2.0), measured(2e-4, 0.1), reached=part * SMALL.run.end)
    advice = table.advise(1e-4)
    assert not advice.known
    assert not advice.reached
    assert table.whole_run(advice.point.measured) is None
    assert (advice.point.setting, advice.error, advice.seconds) == ("setting 0", 1e-6, (1.0, 2.0))
    assert advice.lines()[0].endswith("for the part that was run")
    assert (
        f"not known for the whole run: the short runs cover {part:.2g} of it" in advice.lines()[1]
    )
    assert any(line.startswith("the unchanged scene: not known") for line in table.notes())


@pytest.fixture(scope="module")
def measured_scene():
    """With a budget that leaves no setting out, on any machine."""
    stages = []
    return work_precision(SMALL, budget=1e4, progress=stages.append), stages


def test_work_precision_of_a_scene(measured_scene):
    result, stages = measured_scene
    assert len(stages) == 4
    assert result.reference_error < 1e-7
    stepping = {p.setting: p.measured for p in result.points if p.axis == "stepping"}
    for scheme in TOLERANCES:
        loose, tight = (stepping[f"{scheme}, {TOLERANCES[scheme][k]:.0e}"] for k in (0, 4))
        assert tight.error < 1e-2 * loose.error
        assert tight.work.steps > loose.work.steps
    reach = [p.measured.error for p in result.points if p.axis == "reach"]
    assert reach[-1] == 0.0 < reach[1] < reach[0]
    model = [p.setting for p in result.points if p.axis == "model"]
    assert model[0] == "the scene itself"
    assert [p.measured.error for p in result.points if p.axis == "model"][-1] == 0.0
    advice = result.advise(1e-3)
    exact = simulate(load_scene(SMALL, **{"run.rtol": 1e-11, "run.atol": 1e-11}))
    assert max(distance(simulate(load_scene(SMALL, **advice.point.changes)), exact)) < 1e-3


def test_the_budget_shortens_the_runs():
    result = work_precision(load_scene("passive", **{"run.end": 1e6}), budget=0.05)
    assert result.part < 1.0
    assert any(f"{result.reached:.4g}" in note for note in result.notes())
    advice = result.advise(1e-3)
    assert not advice.known
    assert any("a larger --budget covers more" in line for line in advice.lines())
    assert work_precision(result.scene, budget=0.1).part > result.part


def test_what_is_run_does_not_depend_on_the_clock(monkeypatch):
    """Parts, errors and counts are the same if both cores are busy and the clock jumps by hours."""
    quick = work_precision(SMALL, budget=0.1)
    hours = itertools.count(step=3600.0)
    for name in ("perf_counter", "process_time", "monotonic", "time", "thread_time"):
        monkeypatch.setattr(time, name, lambda: next(hours))
    monkeypatch.setattr(work, "clock", lambda: next(hours))
    slow = work_precision(SMALL, budget=0.1)

    def timeless(found):
        points = [(p.axis, p.setting, p.changes, p.measured) for p in found.points]
        return found.reached, found.own.work, found.skipped, [
            (*point, m.position, m.frame, m.work, m.late, m.nominal, len(m.seconds))
            for *point, m in points
        ]  # fmt: skip

    assert timeless(slow) == timeless(quick)
    assert slow.own.seconds > 3600.0


@pytest.mark.slow
def test_stable_is_run_to_its_end_and_the_setting_advised_reaches_the_target():
    """The advice of ``nrchain cost stable --target 1e-4``, on a processor that counts work."""
    scene = load_scene("stable")
    with fake_processor(Processor()) as processor:
        result = work_precision(scene, budget=3.0)
        assert result.part == 1.0
        advice = result.advise(1e-4)
        before = processor.truth
        again = simulate(load_scene(scene, **advice.point.changes, **{"run.snapshots": 33}))
        least, most = advice.seconds
        assert least == most == processor.truth - before
    exact = {"run.integrator": "radau", "run.rtol": 1e-9, "run.atol": 1e-9, "run.snapshots": 33}
    assert max(distance(again, simulate(load_scene(scene, **exact)))) < 1e-4


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (["--target", "-1"], "target"),
        (["--target", "nan"], "target"),
        (["--budget", "0"], "budget"),
        (["--set", "slip.9z=1"], "slip.9z"),
    ],
)
def test_the_command_refuses(arguments, key):
    result = call("cost", "passive", *arguments)
    assert result.exit_code == REFUSED
    assert result.stderr.strip().splitlines()[-1].startswith(f"nrchain: {key} = ")


def test_limits_of_the_scene_do_not_cut_the_measurement():
    limited = load_scene(SMALL, **{"run.max_steps": 3, "run.max_seconds": 1e-6})
    measured = work_precision(limited, budget=0.1)
    assert all(math.isfinite(one.measured.error) for one in measured.points)
    assert any("ignore run.max_steps" in line for line in measured.notes())
    assert not any(
        "ignore run.max_steps" in line for line in replace(measured, scene=SMALL).notes()
    )


def test_a_scene_that_stops_is_refused():
    limp = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "twist", "bend")}
    scene = load_scene({"chain.particles": 3, "slip.2s": -100.0, "run.end": 100.0} | limp)
    with pytest.raises(SceneError, match=r"run\.end.*stops"):
        work_precision(scene, budget=1000.0)


def test_the_command_says_which_setting_to_use(monkeypatch, measured_scene):
    monkeypatch.setattr(cost, "work_precision", lambda scene, **_: measured_scene[0])
    result = call("cost", "buckling", "--target", "1e-3", "--set", "slip.2s=90")
    assert result.exit_code == 0, result.stderr
    advice = measured_scene[0].advise(1e-3)
    assert f"nrchain run buckling --set slip.2s=90 {advice.arguments}" in result.stdout
    # long lines are wrapped
    shown = " ".join(result.stdout.split())
    for line in (*measured_scene[0].notes(), *advice.lines()):
        assert " ".join(line.split()) in shown
    for axis in ("stepping", "reach", "model"):
        assert axis in result.stdout


def test_effects_left_to_choice_are_chosen_before_anything_is_measured(monkeypatch):
    def shortened(scene, allowed):
        raise SceneError("reached", scene.effects, "is what is measured")

    monkeypatch.setattr(short_runs, "_shortened", shortened)
    with pytest.raises(SceneError, match="reached = 'named'"):
        work_precision(load_scene(SMALL, effects="auto", tolerance=0.1))
