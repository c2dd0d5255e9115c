"""Cycles against long runs, returns of disturbed runs, spectra at a Hopf point and symmetries."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.poses import rigid_motion

import nrchain
from nrchain.comoving.motions import moved
from nrchain.comoving.relative import RelativeChain
from nrchain.errors import SceneError
from nrchain.states.cycles.carrying import carry, fit, rates
from nrchain.states.cycles.charts import chart
from nrchain.states.cycles.newton import solve
from nrchain.states.cycles.system import Condensed, System

TIGHT = {"run.rtol": 1e-10, "run.atol": 1e-10, "run.integrator": "radau"}
MIX = {
    "chain.particles": 12,
    "slip.2s": 200.0,
    "slip.3t": 6500.0,
    "elasticity.ratio": 1e8,
    "run.end": 1500.0,
    "run.snapshots": 1501,
}
ISOTROPIC = {"elasticity.measure": "isotropic"}


def mix(**changes):
    """A clamped chain of twelve that oscillates for ever."""
    return nrchain.load_scene("buckling", **MIX | changes)


def run_from_a_plane(scene, size=0.5):
    """A run from a planar arch between straight clamps."""
    state = nrchain.find_state(scene)
    positions, count = state.positions.copy(), scene.chain.particles
    positions[:, 1] += size * np.sin(np.pi * np.arange(count) / (count - 1)).round(12)
    return nrchain.simulate(scene, positions=positions, frames=state.frames)


@pytest.fixture(scope="module")
def run():
    return nrchain.simulate(mix())


@pytest.fixture(scope="module")
def cycle(run):
    return nrchain.find_cycle(run.scene, run, tolerance=1e-8)


def run_on(scene, poses, end, snapshots=2):
    changed = nrchain.load_scene(scene, **TIGHT | {"run.end": end, "run.snapshots": snapshots})
    return nrchain.simulate(changed, positions=poses[0], frames=poses[1])


def away(poses, other):
    return float(np.abs(chart(*poses, other)).max())


def test_a_run_goes_round_the_cycle(cycle):
    """Radau at 1e-10 comes back after the period, and is where the cycle says on its way."""
    assert cycle.is_stable
    run = run_on(cycle.scene, cycle.at(0.0), cycle.period, 8)
    reached = zip(run.positions, run.frames, strict=True)
    errors = [away(pose, cycle.at(t)) for t, pose in zip(run.time, reached, strict=True)]
    assert errors[-1] < 10.0 * cycle.error + 1e-7
    assert max(errors) < 1e-4
    speed = np.abs(np.diff(run.positions[-2:], axis=0)).max() / np.diff(run.time)[-1]
    assert cycle.period_error < 1e-7 * cycle.period
    assert errors[-1] / speed < 1e-5


def test_a_disturbed_run_returns_at_the_leading_multiplier(cycle):
    """The complex amplitude of the leading mode grows by μ each period, to 1 %."""
    mode, multiplier = cycle.modes[0], cycle.multipliers[0]
    start = cycle.at(0.0)
    disturbed = run_on(cycle.scene, moved(*start, 1e-3 * mode.real), 4.0 * cycle.period, 5)
    later = run_on(cycle.scene, start, 1e-4 * cycle.period)
    path = chart(later.positions[-1], later.frames[-1], start)
    columns = np.stack([mode.real, mode.imag, path], axis=-1).reshape(-1, 3)
    parts = [
        np.linalg.lstsq(columns, chart(*pose, start).ravel(), rcond=None)[0]
        for pose in zip(disturbed.positions, disturbed.frames, strict=True)
    ]
    amplitudes = np.array([part[0] - 1j * part[1] for part in parts])
    measured = (amplitudes[4] / amplitudes[1]) ** (1.0 / 3.0)
    assert measured == pytest.approx(multiplier, rel=0.01)


def test_the_monodromy_is_the_derivative_of_the_flow(cycle):
    """Φ v against central differences of runs over a period, in random directions."""
    chain = RelativeChain(cycle.scene, cycle.at(0.0))
    matrix = Condensed(System(chain, cycle.orbit)).monodromy
    rng, size, start = np.random.default_rng(1), 1e-4, cycle.at(0.0)
    for _ in range(2):
        vector = rng.standard_normal(chain.dimension)
        ends = [
            run_on(cycle.scene, moved(*start, sign * size * chain.poses(vector)), cycle.period)
            for sign in (1.0, -1.0)
        ]
        charted = [chart(run.positions[-1], run.frames[-1], start) for run in ends]
        slope = chain.coordinates(charted[0] - charted[1]) / (2.0 * size)
        product = matrix @ vector
        assert slope == pytest.approx(product, abs=1e-3 * np.abs(product).max())


def test_periods_converge_at_fourth_order_or_better(cycle):
    chain = RelativeChain(cycle.scene, cycle.at(0.0))
    periods = []
    for count in (16, 32, 128):
        orbit = cycle.orbit.remeshed(np.full(count, 1.0 / count))
        condensed, _, found = solve(chain, orbit)
        assert found
        periods.append(condensed.system.orbit.period)
    errors = np.abs(np.array(periods[:2]) - periods[2])
    assert np.log2(errors[0] / errors[1]) > 4.0
    assert errors[1] < 1e-5 * cycle.period


def test_the_stated_error_is_no_less_than_the_true_one(cycle, run):
    coarse = nrchain.find_cycle(run.scene, run, tolerance=1e-3)
    assert coarse.orbit.count < cycle.orbit.count
    assert abs(coarse.period - cycle.period) <= coarse.period_error
    trivial = coarse.trivial
    assert trivial.names == ("time",)
    assert trivial.error == abs(trivial.multipliers[0] - 1.0) <= coarse.multiplier_error
    assert coarse.multipliers[:2] == pytest.approx(
        cycle.multipliers[:2], abs=coarse.multiplier_error
    )


@pytest.mark.slow
def test_amplitudes_grow_as_the_square_root_from_a_hopf_point(cycle):
    """Their period at zero amplitude is that with which the straight chain turns unstable."""
    onset = nrchain.critical_strength(mix(), "slip.3t", (4000.0, 5000.0))
    found, guess, beyond = [], cycle, np.array([0.3, 0.16, 0.08, 0.04])
    for part in beyond:
        scene = mix(**{"slip.3t": onset.value * (1.0 + part)})
        guess = nrchain.find_cycle(scene, guess, tolerance=1e-4)
        found.append(guess)
    squares = np.array([one.amplitude**2 for one in found])
    assert squares[2] / squares[3] == pytest.approx(2.0, rel=0.02)
    curve = np.polyfit(beyond[1:], [one.period for one in found[1:]], 2)
    assert curve[2] == pytest.approx(2.0 * np.pi / onset.frequency, rel=1e-3)


@pytest.mark.slow
def test_a_planar_oscillation_turns_freely_about_its_axis():
    """It has two trivial multipliers, and grows out of its plane towards a rotating shape."""
    scene = mix(**ISOTROPIC)
    found = nrchain.find_cycle(scene, run_from_a_plane(scene))
    assert not found.is_stable
    assert found.trivial.names == ("time", "rotation about x", "turn about e₁")
    assert found.trivial.multipliers == pytest.approx([1.0, 1.0], abs=1e-6)
    assert found.rotation_angle == pytest.approx(np.zeros(3), abs=1e-9)
    half = found.at(0.5 * found.period)[0]
    assert half[:, 1:] == pytest.approx(-found.at(0.0)[0][:, 1:], abs=1e-4)
    chain = RelativeChain(scene, found.at(0.0))
    angle = 0.7
    axis = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0])
    moved_along = carry(chain, axis, angle)
    orbit = found.orbit
    positions, frames = moved_along.applied((orbit.positions, orbit.frames), chain.origin)
    system = System(chain, replace(orbit, positions=positions, frames=frames))
    assert np.abs(system.defects).max() < 1e-8


@pytest.mark.slow
def test_a_free_chain_of_all_pairs_swims_in_strokes():
    """It is carried 43 and turned by 0.87 in a period of 9.3, as a run from the cycle is."""
    strokes = {
        "chain.particles": 7,
        "chain.ends": "free",
        "elasticity.ratio": 1e7,
        "slip.neighbours": "all",
        "slip.2s": [800.0, -1200.0, -400.0, 100.0, -1000.0, 800.0, -900.0],
        "slip.4a": [0.0, 300.0, -1500.0, -700.0, -800.0, 1300.0, -600.0],
        "start.amplitude": 0.3,
        "run.end": 100.0,
        "run.snapshots": 201,
    }
    scene = nrchain.load_scene("buckling", **strokes)
    found = nrchain.find_cycle(scene, nrchain.simulate(scene), tolerance=1e-3)
    assert found.is_stable
    run = run_on(scene, found.at(0.0), found.period)
    assert away((run.positions[-1], run.frames[-1]), found.at(found.period)) < found.error
    shift = (run.positions[-1] - run.positions[0]).mean(axis=0)
    assert shift == pytest.approx(found.displacement, abs=found.error)
    assert np.linalg.norm(shift) > 40.0
    angle = np.linalg.norm(found.rotation_angle)
    assert angle == pytest.approx(0.866, abs=0.01)
    turning = np.exp(1j * angle * np.array([1.0, -1.0]))
    expected = np.concatenate([np.ones(3), np.repeat(turning, 2)])
    assert np.sort(found.trivial.expected.imag) == pytest.approx(np.sort(expected.imag), abs=1e-9)
    assert found.trivial.distances.max() < 1e-5


def test_another_start_in_time_gives_the_same_cycle(cycle):
    later = nrchain.simulate(cycle.scene, positions=cycle.at(11.0)[0], frames=cycle.at(11.0)[1])
    found = nrchain.find_cycle(cycle.scene, later)
    assert found.period == pytest.approx(cycle.period, abs=found.period_error)
    assert np.abs(found.multipliers[:3]) == pytest.approx(np.abs(cycle.multipliers[:3]), abs=1e-5)


def test_motions_of_the_chain_as_a_whole_are_recovered():
    table = {
        "chain": {"particles": 6, "ends": "free"},
        "start": {"shape": "random", "amplitude": 2.0},
        "elasticity.measure": "isotropic",
        "run.end": 1.0,
    }
    scene = nrchain.load_scene(table)
    start = nrchain.simulate(scene)
    poses = start.positions[-1], start.frames[-1]
    chain = RelativeChain(scene, poses)
    motion = np.array([2.0, -1.0, 0.5, 0.4, 1.9, -1.2, 2.1])
    reached = carry(chain, motion).applied(poses, chain.origin)
    fitted, distance = fit(chain, poses, reached)
    assert distance < 1e-10
    assert rates(chain, fitted) == pytest.approx(motion, abs=1e-9)
    turned = rigid_motion(*poses)
    assert fit(chain, poses, (turned[0], turned[1]))[1] < 1e-9


def test_guesses_that_do_not_repeat_are_refused(run):
    start = nrchain.load_scene(run.scene, **{"run.end": 30.0, "run.snapshots": 31})
    with pytest.raises(SceneError, match=r"nearly periodic|does not return"):
        nrchain.find_cycle(start, nrchain.simulate(start))
    with pytest.raises(SceneError, match="12 spheres"):
        nrchain.find_cycle(run.scene, (run.positions[-1], run.frames[-1]))
    still = nrchain.load_scene(run.scene, **{"slip.3t": 0.0, "slip.2s": 100.0})
    with pytest.raises(SceneError, match="find_state"):
        nrchain.find_cycle(still, nrchain.simulate(still))
    with pytest.raises(SceneError, match="positive number"):
        nrchain.find_cycle(run.scene, run, tolerance=0.0)


def test_a_cycle_on_which_spheres_overlap_is_refused(cycle, monkeypatch):
    monkeypatch.setattr("nrchain.states.search.contact_distance", lambda scene: 1e3)
    with pytest.raises(SceneError, match="overlap"):
        nrchain.find_cycle(cycle.scene, cycle)
