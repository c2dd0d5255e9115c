"""The cost of a run: counted work, processor time and its extrapolation to the whole run."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.command_line import call
from support.fake_clock import PRICES, Processor, fake_processor

import nrchain
from nrchain import work
from nrchain.accuracy.cost import work_precision
from nrchain.accuracy.plan_effects import plan_effects
from nrchain.accuracy.timing import predict_cost
from nrchain.planning.counted_work import evaluation_work
from nrchain.run.counters import Counters
from nrchain.run.work import (
    LAPS,
    LARGEST_FACTOR,
    STRANGE,
    RunCost,
    Stopwatch,
    Work,
    cost_of,
    extrapolation_factors,
)
from nrchain.trajectory.writer import TrajectoryWriter

CVODE = {"run.integrator": "cvode", "run.rtol": 2e-6, "run.atol": 2e-6}
"""An integrator whose calls of a chain a test can count and price."""

SCENE = nrchain.load_scene(
    "buckling",
    **{
        "chain.particles": 8,
        "chain.radius": 0.5,
        "chain.viscosity": 2.0,
        "chain.spacing": 7.0,
        "run.end": 40.0,
        **CVODE,
    },
)

BUSY = 3.0
"""Factor within which costs are known on a busy machine, whose caches are shared."""


def timed(monkeypatch, laps, start=0.0):
    """A stopwatch after laps of (seconds, right-hand sides)."""
    now = start
    monkeypatch.setattr(work, "clock", lambda: now)
    watch, total = Stopwatch(), 0
    watch.go()
    for seconds, evaluations in laps:
        now += seconds
        total += evaluations
        watch.lap(total)
    return watch


def test_processor_time_is_the_sum_over_steps(monkeypatch):
    laps = [(0.5, 2), (1.5, 1), (0.25, 1), (1.75, 2)]
    assert timed(monkeypatch, laps, start=1e3).seconds == 4.0


def test_steps_that_compile_count_at_the_median_and_costly_steps_in_full(monkeypatch):
    usual = [(1.0, 2)] * 20 + [(1.5, 1)] * 5
    costly = [(0.5 * 0.99 * STRANGE, 1)]
    strange = [(1e3, 4)]
    expected = 20.0 + 7.5 + 0.5 * 0.99 * STRANGE + 4 * 0.5
    assert timed(monkeypatch, strange + usual + costly).seconds == pytest.approx(expected)


def test_a_lap_without_right_hand_sides_is_added_to_the_next(monkeypatch):
    watch = timed(monkeypatch, [(0.5, 1), (0.25, 0), (0.5, 1), (1.0, 2)])
    assert watch.seconds == 2.25


def test_time_in_a_pause_is_not_counted(monkeypatch):
    now = 0.0
    monkeypatch.setattr(work, "clock", lambda: now)
    watch = Stopwatch()
    with watch.paused():  # before it goes
        now += 100.0
    watch.go()
    now += 1.0
    with watch.paused():
        now += 50.0
    now += 2.0
    watch.lap(3)
    assert watch.seconds == 3.0


@pytest.mark.parametrize("first", [STRANGE, 1e4, 1e7])
def test_long_runs_keep_few_laps_and_leave_out_compilation(monkeypatch, first):
    """Compilation is recognised, or takes less than STRANGE/LAPS of the time of the steps."""
    count = 40 * LAPS
    watch = timed(monkeypatch, [(first, 1)] + [(1.0, 1)] * count)
    assert len(watch._spent) <= 2 * LAPS
    assert count <= watch.seconds <= count * (1.0 + STRANGE / LAPS) + STRANGE


@given(
    slowness=st.lists(st.floats(1.0, BUSY), min_size=40, max_size=60),
    spikes=st.sets(st.integers(0, 39), max_size=15),
    late=st.floats(0.0, 1.0),
)
def test_on_a_busy_processor_the_cost_grows_by_no_more_than_its_slowdown(slowness, spikes, late):
    """Each step is slower by up to a factor of BUSY. Some also compile or collect garbage."""
    with pytest.MonkeyPatch.context() as patch:
        laps = [(n % 3 + 1.0, n % 3 + 1) for n in range(len(slowness))]
        slow = [
            (s * factor + (1e5 if n in spikes else 0.0), e)
            for n, ((s, e), factor) in enumerate(zip(laps, slowness, strict=True))
        ]
        truth = sum(s for s, _ in laps)
        cost = RunCost(Work(60, 120, 9, 80), timed(patch, slow).seconds, 2.0, 4.0, late)
    assert truth <= cost.seconds <= BUSY * truth
    least, most = cost.whole
    assert truth <= least <= most <= 3.0 * BUSY * truth


def test_the_rest_is_extrapolated_at_the_pace_of_the_whole_or_of_the_second_half():
    assert extrapolation_factors(1.0, 0.1) == (1.0, 1.0)
    assert extrapolation_factors(0.25, 0.25) == (
        2.5,
        4.0,
    )  # half the pace of all in the second half
    assert extrapolation_factors(0.25, 0.75) == (4.0, 5.5)
    assert extrapolation_factors(1.0 / LARGEST_FACTOR, 0.5) == (
        LARGEST_FACTOR,
        LARGEST_FACTOR,
    )


@pytest.mark.parametrize("part", [0.99 / LARGEST_FACTOR, 1e-3, 1.5e-5, 0.0])
def test_the_cost_is_not_known_if_too_little_was_run(part):
    cost = RunCost(Work(500, 700, 90, 900), 0.05, part * 60.0, 60.0)
    assert cost.whole is None
    assert cost.factors is None
    assert cost.words().startswith("not known: 500 steps, 700 right-hand sides")
    assert f"more than {LARGEST_FACTOR:g} times" in cost.words()


def test_a_few_steps_have_a_known_work_and_no_known_time():
    cost = RunCost(Work(3, 5, 1, 8), 0.7, 60.0, 60.0)
    assert cost.whole is None
    assert cost.words() == (
        "3 steps, 5 right-hand sides, 1 Jacobians, 8 solves; the time of so few steps is not known"
    )


def test_a_chain_with_all_spheres_clamped_costs_nothing():
    held = nrchain.load_scene("passive", **{"chain.particles": 2, "chain.ends": "clamped"})
    cost = cost_of(nrchain.simulate(held))
    assert cost.work == Work(0, 0, 0, 0)
    assert cost.whole == (0.0, 0.0)


def test_the_cost_of_a_run_is_that_of_its_counted_work():
    with fake_processor(Processor()) as processor:
        run = nrchain.simulate(SCENE)
        assert cost_of(run).seconds == processor.truth
    assert cost_of(run).work.evaluations == processor.done["rates"]
    assert cost_of(run).work.jacobians == processor.done["linearise"]
    assert cost_of(run).work.solves == processor.done["solve"]


def test_watching_and_writing_are_not_part_of_the_cost(monkeypatch, tmp_path):
    with fake_processor(Processor()) as processor:

        def spend(method):
            def call(*arguments, **options):
                processor.now += 0.5
                return method(*arguments, **options)

            return call

        for name in ("write", "checkpoint", "update_counters"):
            method = getattr(TrajectoryWriter, name)
            monkeypatch.setattr(TrajectoryWriter, name, spend(method))
        run = nrchain.simulate(SCENE, output=tmp_path / "run.h5", progress=spend(lambda _: None))
        assert processor.now > processor.truth + 50.0
    assert cost_of(run).seconds == processor.truth


def test_a_run_in_memory_reads_its_counters_as_often_with_more_snapshots(monkeypatch):
    read = []
    table = Counters.table
    monkeypatch.setattr(Counters, "table", lambda self: read.append(1) or table(self))
    often = []
    for snapshots in (3, 41):
        read.clear()
        nrchain.simulate(nrchain.load_scene(SCENE, **{"run.snapshots": snapshots}))
        often.append(len(read))
    assert often[0] == often[1]


def test_compilation_on_a_busy_processor_changes_the_cost_by_a_bounded_factor():
    """Busy cores slow every step, and each kernel compiles for an hour at its first call."""
    for seed in range(5):
        random = np.random.default_rng(seed)
        met: set[float] = set()

        def busy(price, random=random, met=met):
            compiled = 0.0 if price in met else 3600.0
            met.add(price)
            return price * random.uniform(1.0, BUSY) + compiled

        with fake_processor(Processor(busy)) as processor:
            cost = cost_of(nrchain.simulate(SCENE))
        # near neighbours are solved directly: no products
        assert met == {PRICES[name] for name in PRICES if name != "product"}
        assert processor.now > 3600.0
        assert 0.8 * processor.truth <= cost.seconds <= BUSY * processor.truth


@pytest.mark.slow
def test_plan_cost_and_run_report_the_same_number(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.to_toml(), encoding="utf-8")
    with fake_processor(Processor()) as processor:
        run = cost_of(nrchain.simulate(SCENE))
        expected = processor.truth
        file = cost_of(nrchain.simulate(SCENE, output=tmp_path / "run.h5"))
        kept = cost_of(nrchain.Trajectory.open(tmp_path / "run.h5"))
        planned = plan_effects(SCENE)
        measured = work_precision(SCENE, budget=3.0)
        printed = call("run", path, "-v", "-o", tmp_path / "out")
    costs = [run, file, kept, planned.cost, measured.own]
    assert {one.seconds for one in costs} == {expected}
    assert {one.work for one in costs} == {run.work}
    words = f"{run.work.words()} in {expected:.0f} s of processor time"
    assert f"the run: {words}" in planned.notes()
    assert f"the unchanged scene: {words}" in measured.notes()
    assert printed.exit_code == 0, printed.stderr
    # long lines are wrapped
    shown = " ".join((printed.stderr + printed.stdout).split())
    assert f"{expected:.0f} s" in shown
    assert all(
        work.DEFINITION in text
        for text in (shown, *("\n".join(found.notes()) for found in (planned, measured)))
    )


def test_a_resumed_run_costs_as_much_as_an_uninterrupted_one(tmp_path):
    path = tmp_path / "run.h5"
    with fake_processor(Processor()) as processor:
        nrchain.simulate(nrchain.load_scene(SCENE, **{"run.max_steps": 30}), output=path)
        part = cost_of(nrchain.Trajectory.open(path))
        assert part.seconds == processor.truth
        assert 0.0 < part.part < 1.0
        while (run := nrchain.resume(path)).status != "completed":
            assert run.counters["steps"] < 1000
        done = cost_of(run)
        alone = cost_of(nrchain.simulate(SCENE))
    assert done.part == 1.0
    assert done.seconds == alone.seconds


def test_the_cost_predicted_from_a_part_holds_for_the_whole():
    """A spinning chain takes steps of equal cost, except at its start."""
    scene = nrchain.load_scene("spiral-left", **CVODE, **{"run.end": 20.0})
    with fake_processor(Processor()):
        whole = cost_of(nrchain.simulate(scene))
        part = predict_cost(
            scene, allowed=0.3 * whole.work.evaluations * evaluation_work(scene)
        ).cost
    assert 1.0 / LARGEST_FACTOR < part.part < 0.5
    least, most = part.whole
    assert least / 1.5 <= whole.seconds <= 1.5 * most
    assert f"extrapolated from t = {part.reached:.3g} of 20" in part.words()


def test_the_part_that_is_run_does_not_depend_on_the_clock(monkeypatch):
    scene = nrchain.load_scene(SCENE, **{"run.end": 1e5})
    quick = predict_cost(scene, allowed=5e-3)
    now = 0.0

    def hours():
        nonlocal now
        now += 3600.0
        return now

    monkeypatch.setattr(work, "clock", hours)
    slow = predict_cost(scene, allowed=5e-3)
    assert slow.scene == quick.scene
    assert slow.cost.work == quick.cost.work
    assert slow.cost.seconds > 3600.0
    assert slow.cost.whole is None
    assert np.array_equal(slow.trajectory.positions, quick.trajectory.positions)


def test_the_cost_of_a_run_that_stops_is_that_of_its_steps():
    limp = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "twist", "bend")}
    scene = nrchain.load_scene(
        {"chain.particles": 3, "slip.2s": -100.0, "run.end": 100.0, "run.atol": 1e-9} | limp
    )
    cost = predict_cost(scene).cost
    assert cost.part == 1.0
    assert cost.end < 100.0
    assert cost.factors == (1.0, 1.0)
    assert math.isfinite(cost.seconds)
