"""Known waves, motions and shapes, written into trajectories and measured."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from scipy.stats import linregress

import nrchain
from nrchain import measure
from nrchain.analysis.measure import MeasurementError
from nrchain.theory.lattice import Branch, lattice_rates

D = 10.0
MEASURES = [
    "wave",
    "rate",
    "fit_shape",
    "translation",
    "spin",
    "turned_angle",
    "handedness",
    "straightness",
]


def made_of(positions, time=None, frames=None, ends="free"):
    """A trajectory of given positions (T, N, 3)."""
    positions = np.asarray(positions, float)
    snapshots, count = positions.shape[:2]
    time = np.linspace(0.0, 1.0, snapshots) if time is None else time
    if frames is None:
        frames = np.broadcast_to(np.eye(3), (snapshots, count, 3, 3))
    scene = nrchain.load_scene(
        {"chain": {"particles": count, "ends": ends}, "run": {"end": float(time[-1]) or 1.0}}
    )
    return nrchain.Trajectory(np.asarray(time), positions, np.asarray(frames), scene)


def straight(count, snapshots):
    positions = np.zeros((snapshots, count, 3))
    positions[..., 0] = D * np.arange(count)
    return positions


def with_wave(q, amplitude, kind, count=24, ends="periodic", time=None):
    """A straight chain plus A(t) exp(iqs) of one kind."""
    shape = np.asarray(amplitude)[:, None] * np.exp(1j * q * D * np.arange(count))
    positions = straight(count, len(shape))
    if kind in ("right", "left"):
        positions[..., 1] = shape.real
        positions[..., 2] = shape.imag * (1 if kind == "right" else -1)
    else:
        positions[..., "xyz".index(kind)] += shape.real
    return made_of(positions, time, ends=ends)


@given(
    kind=st.sampled_from(["right", "left", "y", "z", "x"]),
    turns=st.integers(-11, 11).filter(bool),
    growth=st.floats(-3, 3),
    frequency=st.floats(-10, 10),
    phase=st.floats(-3, 3),
)
@settings(max_examples=60, deadline=None)
def test_waves_on_a_periodic_chain_are_read_back_exactly(kind, turns, growth, frequency, phase):
    q, time = turns * 2 * np.pi / (24 * D), np.linspace(0, 1, 41)
    expected = 0.1 * np.exp(1j * phase + (growth + 1j * frequency) * time)
    wave = measure.wave(with_wave(q, expected, kind, time=time), q, kind)
    assert np.abs(wave.amplitude - expected).max() < 1e-12
    assert wave.misfit.max() < 1e-12
    rate = measure.rate(wave)
    assert rate.value == pytest.approx(growth + 1j * frequency, abs=1e-9)
    assert rate.phase_velocity.value == pytest.approx(-frequency / q, abs=1e-7)


def test_other_waves_and_rigid_motion_do_not_reach_the_projection():
    q = 2 * np.pi / (24 * D)
    amplitude = np.full(5, 0.1 + 0.05j)
    trajectory = with_wave(3 * q, amplitude, "right")
    trajectory.positions[..., 1] += with_wave(2 * q, 7 * amplitude, "y").positions[..., 1] + 4.0
    trajectory.positions[..., 2] += with_wave(-3 * q, 7 * amplitude, "z").positions[..., 2]
    # of the plane wave z = Re B exp(−3iqs), i B*/2 goes to w = y + iz at +3q
    expected = amplitude + 0.5j * np.conj(7 * amplitude)
    assert measure.wave(trajectory, 3 * q).amplitude == pytest.approx(expected, abs=1e-12)
    assert measure.wave(trajectory, 5 * q).amplitude == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("kind", ["right", "left", "y", "z", "x"])
def test_the_shortest_wave_is_its_own_mirror_image(kind):
    trajectory = with_wave(np.pi / D, np.full(5, 0.1), kind)
    assert measure.wave(trajectory, np.pi / D, kind).amplitude == pytest.approx(0.1)


@pytest.mark.parametrize("kind", ["right", "y", "x"])
def test_open_chains_are_fitted_with_their_rigid_motion_beside(kind):
    q, time = 1.7 * np.pi / (23 * D), np.linspace(0, 1, 21)
    expected = 0.1 * np.exp((0.7 - 2j) * time)
    trajectory = with_wave(q, expected, kind, ends="free", time=time)
    trajectory.positions[..., 1] += 3.0 + time[:, None] * np.linspace(0, 0.4, 24)
    assert measure.wave(trajectory, q, kind).amplitude == pytest.approx(expected, abs=1e-12)
    if kind != "x":
        without = measure.wave(trajectory, q, kind, rigid=False)
        assert np.abs(without.amplitude - expected).max() > 0.1
        assert without.misfit.min() > 0.1


def test_tilt_and_shear_are_read_from_the_frames():
    count, q = 24, 2 * np.pi / (24 * D)
    s = D * np.arange(count)
    tilt = 1e-3 * np.exp(1j * q * s)
    turns = Rotation.from_rotvec(np.stack([0 * s, -tilt.imag, tilt.real], axis=1))
    frames = np.broadcast_to(turns.as_matrix().transpose(0, 2, 1), (5, count, 3, 3))
    tilted = made_of(straight(count, 5), frames=frames, ends="periodic")
    assert measure.wave(tilted, q, of="tilt").amplitude == pytest.approx(1e-3, rel=1e-5)
    # on a straight chain all of the tilt is shear, but for the stencil's own fourth order
    assert measure.wave(tilted, q, of="shear").amplitude == pytest.approx(1e-3, rel=(q * D) ** 4)
    # where the frames follow the curve, none is
    curve = with_wave(q, np.full(5, 1e-3 / (1j * q)), "right")
    along = nrchain.Trajectory(curve.time, curve.positions, frames, curve.scene)
    assert np.abs(measure.wave(along, q, of="shear").amplitude).max() < 1e-3 * (q * D) ** 4


@pytest.mark.parametrize("correlation", [0.0, 0.6])
def test_standard_errors_are_as_large_as_the_errors(correlation):
    time, true = np.linspace(0, 1, 400), 0.5 - 1.5j
    rng = np.random.default_rng(1)
    scores = []
    for _ in range(200):
        noise = rng.standard_normal((400, 2)) @ [1, 1j]
        for k in range(1, 400):
            noise[k] += correlation * noise[k - 1]
        wave = measure.Wave(time, np.exp(true * time + 1e-3 * noise), 0 * time, 1.0)
        rate = measure.rate(wave, start=0.0)
        scores.append((rate.growth.value - true.real) / rate.growth.error)
        scores.append((rate.frequency.value - true.imag) / rate.frequency.error)
    assert np.std(scores) == pytest.approx(1.0, abs=0.12)


@pytest.mark.parametrize("snapshots", [4, 5, 6, 9])
def test_the_error_of_a_slope_has_two_degrees_of_freedom_less(snapshots):
    """Against SciPy's regression, with independent residuals."""
    time = np.linspace(0.0, 3.0, snapshots)
    positions = straight(3, snapshots)
    positions[..., 1] += (0.7 * time + 0.1 * (-1.0) ** np.arange(snapshots))[:, None]
    found = measure.translation(made_of(positions, time))[1]
    expected = linregress(time, positions[:, 0, 1])
    assert found.value == pytest.approx(expected.slope)
    assert found.error == pytest.approx(expected.stderr)


def test_the_transient_is_found_and_dropped():
    time = np.linspace(0, 1, 101)
    amplitude = np.exp((-0.5 + 1j) * time) + 0.3 * np.exp(-60 * time)
    wave = measure.Wave(time, amplitude, 0 * time, 1.0)
    found, all_of_it = measure.rate(wave), measure.rate(wave, start=0.0)
    assert abs(all_of_it.value - (-0.5 + 1j)) > 0.02
    assert found.value == pytest.approx(-0.5 + 1j, abs=1e-6)
    assert 0.1 < found.start <= 0.5
    assert all_of_it.start == 0.0


@pytest.mark.parametrize(
    ("amplitude", "message"),
    [
        (np.exp(1.7j * np.arange(8)), "too far apart"),
        (np.array([1.0, 1.0, 0.0, 1.0, 1.0]), "vanishes at t = 2"),
        (np.ones(3), "3 snapshots"),
    ],
)
def test_rates_that_cannot_be_measured_are_refused(amplitude, message):
    time = np.arange(len(amplitude), dtype=float)
    with pytest.raises(MeasurementError, match=message):
        measure.rate(measure.Wave(time, amplitude + 0j, 0 * time, 1.0))


def test_impossible_waves_are_refused():
    trajectory = with_wave(0.01, np.ones(5), "y", ends="free")
    for q in (0.0, 0.32, np.nan):
        with pytest.raises(MeasurementError, match="wavenumber"):
            measure.wave(trajectory, q)
    with pytest.raises(MeasurementError, match="kind"):
        measure.wave(trajectory, 0.01, "x", of="tilt")
    with pytest.raises(MeasurementError, match="of ="):
        measure.wave(trajectory, 0.01, of="stretch")


@pytest.mark.parametrize("kind", ["right", "left", "y", "x"])
def test_the_shape_fit_reads_a_travelling_wave_of_an_open_chain(kind):
    q, true, time = 1.3 * np.pi / (29 * D), -0.8 + 2.5j, np.linspace(0, 2, 31)
    exact = with_wave(q, 0.1 * np.exp(true * time), kind, count=30, ends="free", time=time)
    rng = np.random.default_rng(2)
    exact.positions[:] += 1e-4 * rng.standard_normal(exact.positions.shape)
    if kind == "x":
        # a longitudinal wave is separated from drift by its mean, which is left out of both
        exact.positions[..., 0] += 3.0 * time[:, None]
        q = 4 * np.pi / (30 * D)
        exact.positions[..., 0] = (
            with_wave(q, 0.1 * np.exp(true * time), kind, count=30, time=time).positions[..., 0]
            + 3.0 * time[:, None]
        )
    fit = measure.fit_shape(exact, q, kind, start=0.0)
    assert fit.misfit < 5e-3
    assert abs(fit.rate.value - true) < 5 * max(fit.rate.error, 1e-6)
    assert fit.rate.error < 5e-3
    assert fit.amplitude == pytest.approx(0.1, rel=0.01)


def test_the_error_of_a_shape_fit_is_that_of_its_noise():
    """δΛ = σ/√(N Σ w(t − t̄)²) with w = |A|²exp(2 Re Λ t), as least squares has it."""
    q, true, time, noise = 1.3 * np.pi / (29 * D), 0.9 + 2.5j, np.linspace(0, 2, 41), 1e-3
    exact = with_wave(q, 0.1 * np.exp(true * time), "right", count=30, ends="free", time=time)
    exact.positions[:] += noise * np.random.default_rng(3).standard_normal(exact.positions.shape)
    weights = 0.01 * np.exp(2.0 * true.real * time)
    spread = weights @ (time - np.average(time, weights=weights)) ** 2
    fit = measure.fit_shape(exact, q, "right", start=0.0)
    error = noise / math.sqrt(30 * spread)
    assert fit.rate.growth.error == pytest.approx(error, rel=0.1)
    assert fit.rate.frequency.error == pytest.approx(error, rel=0.1)


def test_a_shape_that_is_no_wave_says_so():
    positions = straight(30, 11)
    positions[..., 1] = np.linspace(0, 1, 30) ** 4
    bent, q = made_of(positions), np.pi / (29 * D)
    with pytest.raises(MeasurementError, match=r"misfit .* is 0\.65 of the shape"):
        measure.fit_shape(bent, q, "y")
    fit = measure.fit_shape(bent, q, "y", most_misfit=1.0)
    assert fit.misfit == pytest.approx(0.65, abs=0.01)
    assert fit.rate.end == bent.time[-1]


def test_a_wave_that_an_open_chain_does_not_show_has_no_rate():
    q, time = np.pi / (29 * D), np.linspace(0, 1, 11)
    shape = with_wave(q, 0.1 * np.exp(-time), "y", count=30, ends="free", time=time)
    assert measure.rate(measure.wave(shape, q, "y")).misfit < 1e-9
    # of the third harmonic there is a part in it, which decays as the whole does
    third = measure.wave(shape, 3 * q, "y")
    with pytest.raises(measure.MeasurementError, match=r"misfit .* is \d.* of the wave"):
        measure.rate(third)
    trusted = measure.rate(third, most_misfit=np.inf)
    assert trusted.misfit == pytest.approx(np.median(third.misfit / np.abs(third.amplitude)))
    assert trusted.growth.value == pytest.approx(-1.0)


def test_other_waves_of_a_periodic_chain_do_not_spoil_a_rate():
    time = np.linspace(0, 1, 11)
    q = 2 * np.pi / (24 * D)
    shape = with_wave(q, 0.1 * np.exp(-time), "right", time=time)
    shape.positions[..., 1] += with_wave(2 * q, 1.0 + time, "y", time=time).positions[..., 1]
    assert measure.rate(measure.wave(shape, q)).growth.value == pytest.approx(-1.0)


def test_translation_is_the_slope_of_the_centre():
    positions, time = straight(5, 20), np.linspace(0, 3, 20)
    velocity = np.array([0.5, -2.0, 0.1])
    positions += velocity * time[:, None, None]
    positions[:8, :, 0] += 1.0
    measured = measure.translation(made_of(positions, time), start=2.0)
    assert [v.value for v in measured] == pytest.approx(velocity)
    assert measured[0].error < 1e-12


def test_spin_counts_the_turns_between_snapshots():
    scene = nrchain.load_scene(
        "spiral-left",
        **{"start.shape": "straight", "run.end": 50.0, "run.snapshots": 11},
    )
    trajectory = nrchain.simulate(scene)
    count, strength = scene.chain.particles, scene.slip.modes["4a"].strength
    expected = -363 / 5 * strength / D**5 * (1 - 1 / count)  # 36 rad between snapshots
    spin = measure.spin(trajectory)
    assert spin.value == pytest.approx(expected, rel=1e-5)
    assert measure.turned_angle(trajectory)[-1] == pytest.approx(50 * expected, rel=1e-5)


def test_snapshots_too_far_apart_for_the_spin_are_refused():
    time, count = np.arange(6.0), 4
    turns = Rotation.from_rotvec(np.outer([0, 0.2, 0.4, 0.6, 2.8, 3.0], [1, 0, 0]))
    frames = np.repeat(turns.as_matrix().transpose(0, 2, 1)[:, None], count, axis=1)
    trajectory = made_of(straight(count, 6), time, frames)
    with pytest.raises(MeasurementError, match="between t = 3 and 4"):
        measure.spin(trajectory)
    early = made_of(straight(count, 4), time[:4], frames[:4])
    assert measure.spin(early).value == pytest.approx(0.2)


def test_a_straight_chain_has_length_one():
    for ends in ("free", "periodic"):
        trajectory = made_of(straight(9, 2), ends=ends)
        assert measure.straightness(trajectory) == pytest.approx(1)


def test_straightness_of_a_half_circle():
    angle = np.linspace(0, np.pi, 400)
    circle = 1e3 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    assert measure.straightness(made_of(circle[None])) == pytest.approx(2 / np.pi, rel=1e-5)


@pytest.mark.parametrize(
    ("slip", "shape", "kind", "branch"),
    [
        ({"2s": 100.0}, "sine", "y", Branch.BEND_PLUS),
        ({"3a": 5000.0}, "helix-left", "left", Branch.BEND_MINUS),
        ({"4a": 5000.0}, "helix-right", "right", Branch.BEND_PLUS),
    ],
)
def test_a_simulated_wave_has_the_rate_of_the_lattice(slip, shape, kind, branch):
    scene = nrchain.load_scene(
        {
            "chain": {"particles": 32, "ends": "periodic"},
            "elasticity": {"ratio": 1e12},
            "slip": slip,
            "start": {"shape": shape, "amplitude": 1e-4},
            "run": {"end": 50.0, "rtol": 1e-8, "atol": 1e-12},
        }
    )
    rate = measure.rate(measure.wave(nrchain.simulate(scene), kind=kind))
    exact = complex(lattice_rates(scene, scene.wavevector)[branch])
    assert abs(rate.value - exact) < 1e-4 * abs(exact)
    assert rate.error < 1e-4 * abs(exact)


def decaying(amplitude, end, **run):
    """A ring of pullers whose longest helix decays below the tolerances."""
    start = {"shape": "helix-left", "amplitude": amplitude}
    changes = {f"run.{key}": value for key, value in run.items()}
    scene = {"chain.ends": "periodic", "start": start, "run.end": end, **changes}
    return nrchain.simulate(nrchain.load_scene("stable", **scene))


def test_what_has_decayed_below_the_tolerance_is_left_out():
    run = decaying(1e-3, 1500.0, snapshots=151)
    wave = measure.wave(run, kind="left")
    assert np.abs(wave.amplitude[-1]) < 1e-8
    rate = measure.rate(wave)
    exact = lattice_rates(run.scene, run.scene.wavevector)[Branch.BEND_MINUS].real
    assert abs(rate.growth.value - exact) < 3.0 * rate.growth.error < 0.05 * abs(exact)
    assert abs(wave.amplitude[wave.time == rate.end][0]) > 50.0 * run.scene.run.atol
    with pytest.raises(MeasurementError, match="0 snapshots from t = 1000 on"):
        measure.rate(wave, 1000.0)


@pytest.mark.parametrize("of", ["displacement", "tilt", "shear"])
def test_a_wave_below_the_tolerance_has_no_rate(of):
    run = decaying(1e-8, 50.0, snapshots=11)
    with pytest.raises(MeasurementError, match=r"lower run\.atol"):
        measure.rate(measure.wave(run, kind="left", of=of))
    finer = decaying(1e-8, 50.0, snapshots=11, atol=1e-14)
    exact = lattice_rates(run.scene, run.scene.wavevector)[Branch.BEND_MINUS].real
    found = measure.rate(measure.wave(finer, kind="left"))
    assert found.growth.value == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("given", [None, 5, "x"])
@pytest.mark.parametrize("name", MEASURES)
def test_what_is_no_trajectory_is_refused(name, given):
    with pytest.raises(MeasurementError, match="must be a"):
        getattr(measure, name)(given)


def test_wrong_arguments_of_measures_are_named():
    trajectory = made_of(straight(8, 6), ends="periodic")
    for wavenumber in ("a", [0.1], 1j, math.nan, 10**400, True):
        with pytest.raises(MeasurementError, match=r"^wavenumber = "):
            measure.wave(trajectory, wavenumber)
    for start in ("a", [1], 1j, math.nan):
        with pytest.raises(MeasurementError, match=r"^start = "):
            measure.translation(trajectory, start)
    for kind in (None, ["y"], np.array(["y", "z"])):
        with pytest.raises(MeasurementError, match=r"^kind = "):
            measure.wave(trajectory, kind=kind)
        with pytest.raises(MeasurementError, match=r"^of = "):
            measure.wave(trajectory, of=kind)
    wave = measure.wave(with_wave(2 * np.pi / 240, np.full(6, 0.1), "y"), kind="y")
    with pytest.raises(MeasurementError, match=r"^most_misfit = "):
        measure.rate(wave, most_misfit="x")
    with pytest.raises(MeasurementError, match=r"^most_misfit = "):
        measure.fit_shape(trajectory, most_misfit="x")
