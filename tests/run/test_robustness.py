"""Every scene ends as documented, and completed runs hold their invariants."""

import random
import shutil
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.selection import few_of

import nrchain
from nrchain.errors import SceneError
from nrchain.outcome import Cause
from nrchain.planning.checked_start import starting_poses
from nrchain.trajectory import recorder as recording
from validation.hard_cases import charts
from validation.hard_cases.agreement import LEEWAY
from validation.hard_cases.fuzz import fuzz, fuzzed, table
from validation.hard_cases.outputs import GOES_ON, NOT_TRIED
from validation.hard_cases.processes import kills_resumed, outputs, soak
from validation.hard_cases.run import GROWN
from validation.report.gallery import GALLERY, REFUSED

MODES = [(), ("2s",), ("2s", "3a", "3t", "4a")]
STRENGTH = st.sampled_from([1e-12, 1.0, -100.0, 5000.0, 1e8, -1e150, 1e300])


@st.composite
def wild_scenes(draw):
    """Short chains of any stiffness and strength, with small budgets."""
    periodic = draw(st.booleans())
    steric = {"kind": draw(st.sampled_from(["none", "wca", "harmonic"]))}
    if steric["kind"] != "none":
        steric["strength"] = draw(st.sampled_from([1e-3, 1.0, 1e6]))
    return {
        "chain": {
            "particles": draw(st.integers(2, 6)),
            "spacing": draw(st.sampled_from([2.3, 4.0, 10.0])),
            "ends": "periodic" if periodic else draw(st.sampled_from(["free", "clamped"])),
        },
        "elasticity": {"ratio": draw(st.sampled_from([1e-3, 1e3, 1e7, 1e12]))},
        "slip": {
            "neighbours": draw(st.sampled_from([1, 3] if periodic else [1, 3, "all"])),
            **{label: draw(STRENGTH) for label in draw(st.sampled_from(MODES))},
        },
        "friction": draw(st.sampled_from(["one-body", "pairwise"])) if not periodic else "one-body",
        "steric": steric,
        "start": {
            "shape": draw(st.sampled_from(["straight", "sine", "helix-left", "random"])),
            "amplitude": draw(st.sampled_from([0.0, 1e-12, 0.1, 3.0, 1e200])),
        },
        "run": {
            "end": draw(st.sampled_from([1e-9, 1.0, 1e3])),
            "snapshots": 4,
            "max_steps": 60,
            "max_seconds": 5.0,
            "integrator": draw(st.sampled_from(["cvode", "radau", "scipy-bdf"])),
        },
    }


def assert_ends_as_documented(table):
    """Complete, refused or stopped for a cause."""
    try:
        ended = nrchain.simulate(nrchain.load_scene(table))
    except SceneError:
        return
    assert (ended.status == "completed") == (ended.cause is None)
    assert ended.status in ("completed", "stopped")
    assert bool(ended.reason) == (ended.cause is not None)
    assert ended.cause is not Cause.ERROR
    assert (np.diff(ended.time) > 0).all()
    gram = np.einsum("...ak,...bk->...ab", ended.frames, ended.frames)
    assert np.abs(gram - np.eye(3)).max() < 1e-12
    if ended.status == "completed":
        assert len(ended.time) == 4


@pytest.mark.filterwarnings("ignore::nrchain.errors.SceneWarning")
@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow])
@given(wild_scenes())
def test_every_scene_completes_is_refused_or_stops_for_a_cause(table):
    assert_ends_as_documented(table)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::nrchain.errors.SceneWarning")
@settings(max_examples=200, suppress_health_check=[HealthCheck.too_slow])
@given(wild_scenes())
def test_every_one_of_many_scenes_ends_as_documented(table):
    assert_ends_as_documented(table)


@pytest.mark.parametrize("count", few_of([90, 300], {90}))
def test_fuzzed_scenes_are_read_refused_or_run(count):
    fates, undocumented = fuzz(count, seed=7)
    assert undocumented == []
    assert fates["texts"]["refused"] > count / 6
    assert fates["tables"]["completed"] > count / 6
    assert all(counter.total() - counter["refused"] > count / 10 for counter in fates.values())


def test_the_fuzz_repeats_itself():
    assert fuzzed(random.Random(3)) == fuzzed(random.Random(3))
    assert repr(table(random.Random(3))) == repr(table(random.Random(3)))


def moved_alike(table, seed):
    """The largest distance of a run, and of one moved as a whole, at the end, and the tolerance."""
    scene = nrchain.load_scene(table)
    positions, frames = starting_poses(scene)
    turn, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    turn *= np.linalg.det(turn)
    here = nrchain.simulate(scene)
    there = nrchain.simulate(scene, positions=positions @ turn.T - 3.0, frames=frames @ turn.T)
    assert here.status == there.status == "completed"
    moved = np.abs(here.positions[-1] - here.positions[0]).max()
    apart = max(
        np.abs(here.positions[-1] @ turn.T - 3.0 - there.positions[-1]).max(),
        np.abs(here.frames[-1] @ turn.T - there.frames[-1]).max(),
    )
    return apart, scene.run.atol + scene.run.rtol * moved


@settings(max_examples=15, deadline=None)
@given(
    modes=st.sampled_from(MODES),
    strength=st.sampled_from([1e-12, 1.0, -20.0, 50.0]),
    count=st.integers(2, 6),
    reach=st.sampled_from([1, "all"]),
    seed=st.integers(0, 1000),
)
def test_a_chain_moved_as_a_whole_moves_alike(modes, strength, count, reach, seed):
    apart, tolerance = moved_alike(
        {
            "chain": {"particles": count},
            "elasticity": {"stretch": 20.0, "shear": 20.0},
            "slip": {"neighbours": reach, **dict.fromkeys(modes, strength)},
            "start": {"shape": "random", "amplitude": 0.5, "seed": seed},
            "run": {"end": 5.0, "snapshots": 2},
        },
        seed,
    )
    assert apart < LEEWAY * tolerance


@settings(max_examples=20, deadline=None)
@given(
    count=st.integers(2, 8),
    ratio=st.sampled_from([1e3, 1e7, 1e12]),
    amplitude=st.sampled_from([1e-12, 0.1, 2.0]),
    ends=st.sampled_from(["free", "clamped"]),
    seed=st.integers(0, 1000),
)
def test_a_passive_chain_loses_energy(count, ratio, amplitude, ends, seed):
    scene = nrchain.load_scene(
        {
            "chain": {"particles": count, "ends": ends},
            "elasticity": {"ratio": ratio},
            "start": {"shape": "random", "amplitude": amplitude, "seed": seed},
            "run": {"end": 50.0, "snapshots": 6},
        }
    )
    run = nrchain.simulate(scene)
    # links of neighbours that start 2 a to either side may turn over as they relax
    assert run.cause in (None, Cause.TURN)
    energies = np.array(
        [
            nrchain.elastic_energy(*poses, spacing=10.0, **scene.moduli._asdict())
            for poses in zip(run.positions, run.frames, strict=True)
        ]
    )
    # at rest within its tolerance a link of stiffness λ has λ atol²: more may come and go
    rest = LEEWAY * count * max(scene.moduli) * scene.run.atol**2
    assert (np.diff(energies) <= rest).all()


def test_a_chain_turns_through_ten_thousand_radians():
    turn = charts.spin("cvode")
    assert abs(turn.counted) > charts.FAR
    assert turn.counted == pytest.approx(turn.exact, abs=turn.tolerance)


def test_a_chart_is_right_up_to_its_half_turn():
    frames, twists = charts.chart_near_its_half_turn()
    assert frames < 1e-14
    assert twists < 1e-12


def test_a_step_to_the_half_turn_of_the_chart_stops_the_run():
    scene = nrchain.load_scene("passive", **{"chain.ends": "free", "run.snapshots": 11})
    assert charts.leap(scene) is Cause.CHART


@pytest.mark.parametrize("case", [c for c in GALLERY if c.ends == (REFUSED,)], ids=lambda c: c.name)
def test_cases_of_the_gallery_that_are_refused(case):
    scene = case.scene()
    with pytest.raises(SceneError):
        nrchain.simulate(scene, **case.poses(scene))


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"chain.particles": 10**12}, "chain.particles"),
        ({"run.snapshots": 10**12}, "run.snapshots"),
    ],
)
def test_what_does_not_fit_the_memory_is_refused_at_once(changes, key):
    with pytest.raises(SceneError, match="GiB") as caught:
        nrchain.simulate(nrchain.load_scene("passive", **changes))
    assert caught.value.key == key


def test_every_cause_has_advice():
    assert all(cause.advice for cause in Cause)
    assert all(cause.advice_without_slip for cause in Cause)


@pytest.mark.parametrize(("name", "slips"), [("buckling", True), ("passive", False)])
def test_the_remedy_weakens_the_slip_where_there_is_some(name, slips):
    run = nrchain.simulate(nrchain.load_scene(name, **{"run.max_steps": 1}))
    for cause in Cause:
        advice = replace(run, cause=cause).advice
        assert slips or "slip" not in advice
        assert advice == (cause.advice if slips else cause.advice_without_slip)


def test_memory_stays_flat(tmp_path):
    found = soak(tmp_path, 5000)
    assert found["steps"] == 5000
    assert found["grown"] < GROWN, f"{found['grown']} kB in 4500 steps"


@pytest.mark.slow
def test_memory_stays_flat_over_a_hundred_thousand_steps(tmp_path):
    found = soak(tmp_path, 100_000)
    assert found["steps"] == 100_000
    assert found["grown"] < GROWN, f"{found['grown']} kB in 90 000 steps"


def test_a_run_killed_between_data_and_mark_resumes_to_the_same_bits(tmp_path):
    kills = kills_resumed(tmp_path, 3, end=20.0)
    assert [one.status for one in kills[:2]] == ["running", "running"]
    assert kills[0].snapshots == 0
    assert all(one.agreed for one in kills)


def test_what_cannot_be_written_or_read_ends_with_one_line():
    answers = outputs()
    for name, message in answers.items():
        assert "\n" not in message
        assert (message == "completed") == (name in GOES_ON), f"{name}: {message}"
    if untried := [name for name, message in answers.items() if message == NOT_TRIED]:
        pytest.skip(f"{NOT_TRIED}: {', '.join(untried)}")


def test_a_full_disk_refuses_snapshots_and_says_how_many_fit(tmp_path, monkeypatch):
    scene = nrchain.load_scene("passive", **{"run.snapshots": 1000, "run.end": 1.0})
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=100 * 2**10))
    with pytest.raises(
        SceneError, match=r"1\.85 MiB, and 96.* kiB are free .*; 50 snapshots would fit"
    ) as caught:
        nrchain.simulate(scene, output=tmp_path / "x.h5")
    assert (caught.value.key, caught.value.value) == ("run.snapshots", 1000)
    assert list(tmp_path.iterdir()) == []


def test_full_memory_refuses_snapshots(monkeypatch):
    scene = nrchain.load_scene("passive", **{"run.snapshots": 1000})
    monkeypatch.setattr(recording, "SMALL", 0)
    monkeypatch.setattr(recording, "available_memory", lambda: 2**20)
    with pytest.raises(SceneError, match="would fit") as caught:
        nrchain.simulate(scene)
    assert caught.value.key == "run.snapshots"
    monkeypatch.setattr(recording, "available_memory", lambda: 2**10)
    with pytest.raises(SceneError, match="first and last") as caught:
        nrchain.simulate(scene)
    assert caught.value.key == "chain.particles"
