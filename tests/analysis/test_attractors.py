"""Each kind of attractor, on chains whose end is known by other means."""

import contextlib
import math
from itertools import pairwise

import numpy as np
import pytest

import nrchain
from nrchain import measure
from nrchain.analysis.measure.attractors.alignment import distances, first_inside
from nrchain.comoving.relative import RelativeChain


def scene(name="buckling", **changes):
    few = {"chain.particles": 8, "slip.neighbours": 1, "elasticity.ratio": 1e7}
    return nrchain.load_scene(
        name, **few | {key.replace("__", "."): changes[key] for key in changes}
    )


def test_a_passive_chain_settles_straight_when_its_bend_has_decayed():
    run = nrchain.simulate(scene("passive", run__end=400.0, start__amplitude=0.5))
    found = measure.attractor(run)
    away = np.linalg.norm(run.positions - run.positions[-1], axis=2).max(axis=1)
    assert found.kind == "straight"
    assert found.since == run.time[np.flatnonzero(away > 1e-3)[-1] + 1]


def test_pushers_end_buckled_at_the_state_that_attracts_them():
    pushers = scene(slip__2s=700.0, run__end=100.0, start__amplitude=0.5)
    run = nrchain.simulate(nrchain.load_scene(pushers, **{"elasticity.measure": "isotropic"}))
    found = measure.attractor(run)
    away = np.linalg.norm(run.positions - run.positions[-1], axis=2).max(axis=1)
    assert found.kind == "buckled"
    assert found.since == run.time[np.flatnonzero(away > 1e-3)[-1] + 1]


def test_an_unstable_state_that_is_passed_slowly_is_no_attractor():
    pushers = scene(slip__2s=400.0, run__end=10.0, start__amplitude=1e-5, run__atol=1e-9)
    run = nrchain.simulate(pushers)
    assert np.abs(run.positions[-1, :, 1:]).max() < 1e-3
    assert measure.attractor(run).kind == "unsettled"


def flutter(**changes):
    """Pushers whose polar flow keeps a wave going along the chain."""
    strong = {"chain.particles": 10, "slip.2s": 600.0, "slip.3t": 6000.0}
    start = {"start.shape": "sine", "start.amplitude": 0.5, "run.end": 500.0}
    return nrchain.load_scene(scene(), **strong | start | changes)


def zero_crossings(time, height):
    """Times at which a height, linear between snapshots, goes up through 0."""
    up = np.flatnonzero((height[:-1] < 0.0) & (height[1:] >= 0.0))
    return time[up] - height[up] * (time[up + 1] - time[up]) / (height[up + 1] - height[up])


@pytest.mark.parametrize(
    ("snapshots", "further"), [(1001, False), (51, True)], ids=["fine", "too far apart"]
)
def test_a_wave_that_keeps_its_height_has_the_period_of_its_spheres(snapshots, further):
    run = nrchain.simulate(flutter(**{"run.snapshots": snapshots}))
    found = measure.attractor(run, further=further)
    fine = nrchain.simulate(flutter(**{"run.snapshots": 5001}))
    height = fine.positions[:, 4, 1]
    times = zero_crossings(fine.time, height)
    assert found.kind == "travelling oscillation"
    assert found.period == pytest.approx(np.diff(times)[-1], rel=2e-4)
    assert found.numbers["ellipticity"] < 1e-6
    tops = [height[(fine.time >= a) & (fine.time < b)].max() for a, b in pairwise(times)]
    late = [top for top, begin in zip(tops, times[:-1], strict=True) if begin >= found.since]
    assert len(late) > 3
    assert np.ptp(late) < 0.05 * tops[-1]
    assert times[0] - found.period < found.since < times[2]


def test_snapshots_too_far_apart_for_a_period_are_said_to_be():
    run = nrchain.simulate(flutter(**{"run.snapshots": 51}))
    found = measure.attractor(run, further=False)
    assert (found.kind, found.since) == ("unsettled", None)
    assert "too far apart" in found.confidence


def test_bends_that_go_round_make_a_rotating_shape():
    turning = {"slip.2s": 400.0, "slip.3t": 0.0, "slip.4a": 4000.0, "start.shape": "random"}
    run = nrchain.simulate(flutter(**turning, **{"run.end": 300.0}))
    found = measure.attractor(run)
    assert found.kind == "rotating shape"
    assert found.numbers["ellipticity"] > 0.9
    middle = nrchain.simulate(
        flutter(**turning, **{"run.end": 300.0, "run.snapshots": 3001})
    ).positions[:, 4]
    angle = np.unwrap(np.arctan2(middle[:, 2], middle[:, 1]))
    late = angle[-1] - angle[-1001]
    assert found.period == pytest.approx(100.0 * 2.0 * math.pi / abs(late), rel=5e-3)


@pytest.mark.parametrize("strength", [300.0, 450.0], ids=["decays", "grows"])
def test_about_a_state_the_exponent_is_the_rate_of_its_leading_mode(strength):
    pushers = scene(slip__2s=strength, run__end=300.0, run__snapshots=301, start__shape="straight")
    about = nrchain.spectrum(pushers).state
    with pytest.warns(nrchain.SceneWarning) if strength > 400.0 else contextlib.nullcontext():
        run = nrchain.simulate(pushers, positions=about.positions, frames=about.frames)
    exponent = measure.lyapunov(run)
    assert exponent.value == pytest.approx(nrchain.spectrum(pushers).leading.growth, rel=2e-3)


def test_on_a_cycle_that_attracts_the_exponent_is_zero_within_its_error():
    run = nrchain.simulate(flutter(**{"run.snapshots": 1001, "start.shape": "random"}))
    exponent = measure.lyapunov(run, start=200.0)
    assert abs(exponent.value) < 3.0 * exponent.error < 0.02


def test_out_of_a_plane_wave_small_changes_grow_at_the_exponent():
    run = nrchain.simulate(flutter(**{"run.snapshots": 1001}))
    exponent = measure.lyapunov(run, start=200.0)
    positions = run.positions[-1] + 1e-6 * np.sin(np.arange(10.0))[:, None] * [0.0, 0.0, 1.0]
    positions[[0, -1]] = run.positions[-1, [0, -1]]
    fine = flutter(**{"run.end": 250.0, "run.rtol": 1e-10, "run.atol": 1e-10})
    beside = nrchain.simulate(fine, positions=positions, frames=run.frames[-1])
    size = np.linalg.norm(beside.positions[:, :, 2], axis=1)
    late = beside.time > 100.0
    growth = np.polyfit(beside.time[late], np.log(size[late]), 1)[0]
    assert size[-1] < 1e-2
    assert exponent.value == pytest.approx(growth, rel=0.05)
    assert "unstable" in measure.attractor(run).confidence


def test_the_exponent_is_refused_for_few_snapshots():
    with pytest.raises(measure.MeasurementError, match="39 snapshots: at least 40"):
        measure.lyapunov(nrchain.simulate(scene(run__end=1.0, run__snapshots=39)))


def test_a_search_for_the_last_outside_looks_at_few():
    looked = []

    def is_outside(places):
        looked.extend(places)
        return places < 123_456

    assert first_inside(1_000_000, is_outside) == 123_456
    assert len(looked) < 1000
    assert first_inside(10, lambda places: places >= 0) == 10
    assert first_inside(10, lambda places: places < 0) == 0


def test_a_run_that_stops_at_a_contact_ends_touching():
    pushers = scene(chain__ends="free", slip__2s=-3000.0, elasticity__ratio=1e3)
    run = nrchain.simulate(nrchain.load_scene(pushers, **{"start.amplitude": 1.0}))
    assert run.cause is nrchain.Cause.TOUCH
    found = measure.attractor(run)
    assert (found.kind, found.since) == ("touching", run.time[-1])


def test_distances_do_not_depend_on_how_a_free_chain_lies():
    chain = scene("passive", chain__ends="free")
    start = nrchain.simulate(nrchain.load_scene(chain, **{"run.end": 1.0, "run.snapshots": 2}))
    positions = start.positions[-1]
    positions = positions + np.random.default_rng(0).normal(size=positions.shape)
    angle = 2.0
    turn = np.array(
        [[math.cos(angle), -math.sin(angle), 0.0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]]
    )
    moved = positions @ turn.T + [3.0, -7.0, 2.0]
    group = RelativeChain(chain, (positions, start.frames[-1]))
    assert distances(group, moved[None], positions)[0] < 1e-12
    mirrored = moved * [1.0, 1.0, -1.0]
    assert distances(group, mirrored[None], positions)[0] > 0.1


def test_beside_a_cycle_the_exponent_is_that_of_the_largest_multiplier():
    run = nrchain.simulate(flutter(**{"run.snapshots": 2001}))
    found = measure.attractor(run)
    cycle = nrchain.find_cycle(run.scene, run, tolerance=1e-3, modes=2)
    expected = math.log(abs(cycle.multipliers[0])) / cycle.period
    assert found.numbers["exponent"] == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("slip", [{"slip.2s": 10.0}, {"slip.2s": 10.0, "slip.3t": 5.0}])
def test_two_spheres_that_swim_or_rest_have_an_attractor(slip):
    """Two points lie on a line: there is no depth and no height to be wound in."""
    pair = {"chain.particles": 2, "chain.spacing": 3.0, "chain.ends": "free", "run.end": 300.0}
    run = nrchain.simulate(scene(**pair, **slip))
    found = measure.attractor(run, further=False)
    assert found.kind == ("swimming" if "slip.3t" in slip else "straight")
    assert found.numbers["depth over height"] == 0.0
