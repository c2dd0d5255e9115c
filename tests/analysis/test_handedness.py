"""Coils of both hands and none, with noise of known size, on chains with a ≠ 1 and d ≠ 10."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import nrchain
from nrchain import measure
from nrchain.analysis.handedness import SURE

D, A = 7.0, 2.5


def made_of(positions, ends="free", spacing=D, **run):
    positions = np.asarray(positions, float)
    snapshots, count = positions.shape[:2]
    scene = nrchain.load_scene(
        {
            "chain": {"particles": count, "ends": ends, "spacing": spacing, "radius": A},
            "run": {"end": 1.0, **run},
        }
    )
    frames = np.broadcast_to(np.eye(3), (snapshots, count, 3, 3))
    return nrchain.Trajectory(np.linspace(0.0, 1.0, snapshots), positions, frames, scene)


def helix(count, turns, radius, hand=1, spacing=D):
    """(1, N, 3): ``turns`` turns over N spacings."""
    phase = 2.0 * math.pi * turns * np.arange(count) / count
    x = spacing * np.arange(count)
    return np.stack([x, radius * np.cos(phase), hand * radius * np.sin(phase)], axis=1)[None]


def volumes_of(positions, period=0.0):
    """(T,) Σ det of three links in a row, by determinants."""
    if period:
        shift = [period, 0.0, 0.0]
        positions = np.concatenate([positions, positions[:, :3] + shift], axis=1)
    links = np.diff(positions, axis=1)
    last = len(links[0]) - 2
    return sum(np.linalg.det(links[:, k : k + 3]) for k in range(last))


@pytest.mark.parametrize("ends", ["free", "periodic"])
@pytest.mark.parametrize("hand", [1, -1])
@settings(max_examples=25, deadline=None)
@given(
    st.sampled_from([(4, 1), (5, 1), (6, 2), (9, 1), (24, 2), (24, 7)]),
    st.floats(0.01, 20.0),
    st.floats(2.0, 50.0),
)
def test_an_exact_helix_has_its_hand_and_its_size(ends, hand, wave, radius, spacing):
    count, turns = wave
    theta = 2.0 * math.pi * turns / count
    spacing = max(spacing, 2.1 * A)
    coil = made_of(helix(count, turns, radius, hand, spacing), ends, spacing)
    found = measure.handedness(coil)
    assert found.hand == pytest.approx(hand)
    size = 8.0 * math.sin(theta / 2.0) ** 2 * math.sin(theta) * (1.0 - math.cos(theta))
    assert found.size == pytest.approx(hand * (radius / spacing) ** 2 * size, rel=1e-9)
    assert 0.0 < found.error[0] < abs(found.size[0]) / SURE


def test_the_size_of_a_long_wave_is_that_of_its_curvature_and_torsion():
    q, radius = 2.0 * math.pi / (400 * D), 3.0
    found = measure.handedness(made_of(helix(400, 1, radius)))
    assert found.size[0] == pytest.approx((radius * q * q) ** 2 * q * D**3, rel=1e-3)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_a_hand_is_the_same_from_any_side_and_its_mirror_has_the_other(seed):
    rng = np.random.default_rng(seed)
    shape = D * np.cumsum(np.array([1.0, 0.0, 0.0]) + rng.standard_normal((1, 8, 3)), axis=1)
    turn = Rotation.random(random_state=seed).as_matrix()
    own, turned, mirrored = (
        measure.handedness(made_of(r), noise=0.01)
        for r in (shape, shape @ turn.T + [3.0, -4.0, 5.0], shape * [1.0, -1.0, 1.0])
    )
    for other, sign in ((turned, 1.0), (mirrored, -1.0)):
        assert other.size == pytest.approx(sign * own.size, rel=1e-9, abs=1e-12)
        assert other.hand == pytest.approx(sign * own.hand, rel=1e-9, nan_ok=True)
        assert other.error == pytest.approx(own.error, rel=1e-9)


@pytest.mark.parametrize("height", [0.0, 1e-6, 1.0, 300.0])
@pytest.mark.parametrize("ends", ["free", "periodic"])
def test_a_plane_curve_has_no_hand_however_it_lies(ends, height):
    phase = 2.0 * math.pi * np.arange(20) / 20
    wave = np.zeros((1, 20, 3))
    wave[0, :, 0], wave[0, :, 1] = D * np.arange(20), height * np.sin(phase)
    # a ring of spheres repeats along x, and is turned about that
    turn = Rotation.from_rotvec([0.7, 0, 0] if ends == "periodic" else [0.3, -1.1, 2.0])
    for noise in (None, 0.0):
        found = measure.handedness(made_of(wave @ turn.as_matrix().T, ends), noise=noise)
        assert np.isnan(found.hand).all()
        assert np.abs(found.size) == pytest.approx(0.0, abs=SURE * found.error[0])


@pytest.mark.parametrize("noise", [1e-8, 1e-4, 0.3])
@pytest.mark.parametrize("ends", ["free", "periodic"])
@pytest.mark.parametrize("count", [4, 5, 6, 7, 20])
def test_chains_straight_but_for_noise_have_no_hand(count, ends, noise):
    rng = np.random.default_rng(count)
    shape = np.tile(D * np.arange(count)[:, None] * [1.0, 0.0, 0.0], (400, 1, 1))
    shape += noise * rng.standard_normal(shape.shape)
    found = measure.handedness(made_of(shape, ends), noise=noise)
    assert np.isfinite(found.hand).sum() <= 4


@pytest.mark.parametrize(
    ("count", "radius", "noise"),
    [(4, 0.0, 0.1), (5, 3.0, 0.05), (20, 0.0, 0.2), (20, 0.5, 0.1), (20, 8.0, 0.1), (8, 1.0, 2.0)],
)
@pytest.mark.parametrize("ends", ["free", "periodic"])
def test_the_error_is_the_scatter_that_noise_gives(count, radius, noise, ends):
    """The stated error equals the scatter over 4000 realisations of the noise."""
    rng = np.random.default_rng(3)
    exact = helix(count, 1, radius)
    seen = exact + noise * rng.standard_normal((4000, count, 3))
    period = count * D if ends == "periodic" else 0.0
    unit = D**3 * (count if period else count - 3)
    scatter = np.std(volumes_of(seen, period)) / unit
    estimated = measure.handedness(made_of(exact, ends), noise=noise).error[0]
    # from a chain without noise, the error is the larger of the first two orders
    assert estimated == pytest.approx(scatter, rel=0.35)
    errors = measure.handedness(made_of(seen, ends), noise=noise).error
    assert math.sqrt(np.mean(errors**2)) == pytest.approx(scatter, rel=0.3)
    sizes = measure.handedness(made_of(seen, ends), noise=noise).size
    assert sizes == pytest.approx(volumes_of(seen, period) / unit, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("count", [4, 5, 6, 7, 12])
@pytest.mark.parametrize("ends", ["free", "periodic"])
def test_noise_alone_spans_volumes(count, ends):
    """The part ε⁶ of the variance: 6 w² of three spheres with w n_i·(n_j × n_k) in the volume."""
    straight, noise = helix(count, 1, 0.0), 0.8 * D
    once, twice = (
        measure.handedness(made_of(straight, ends), noise=each).error[0] ** 2
        for each in (noise, 2.0 * noise)
    )
    unit = D**3 * (count if ends == "periodic" else count - 3)
    # the chain has no slopes of its volume, so the rest is the part ε⁴
    found = (twice - 16.0 * once) / (64.0 - 16.0) / noise**6 * unit**2
    expected = 0.0
    for spheres in itertools.combinations(range(count), 3):
        shape = np.zeros((count, 3))
        shape[spheres, range(3)] = 1.0
        if ends == "periodic":
            shape = np.concatenate([shape, shape[:3]])
        expected += 6.0 * float(volumes_of(shape[None])[0]) ** 2
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_coil_keeps_its_hand_under_noise_well_below_it():
    rng = np.random.default_rng(1)
    shape = helix(24, 2, 4.0, -1) + 0.02 * rng.standard_normal((50, 24, 3))
    found = measure.handedness(made_of(shape), noise=0.02)
    assert (found.hand < -0.95).all()
    apart = (found.size - measure.handedness(made_of(helix(24, 2, 4.0, -1))).size) / found.error
    assert np.std(apart) == pytest.approx(1.0, abs=0.35)


def test_half_a_coil_of_each_hand_is_mixed():
    right, left = helix(20, 2, 5.0)[0], helix(20, 2, 5.0, -1)[0]
    both = np.concatenate([right, left + right[-1] - left[0] + [D, 0, 0]])
    found = measure.handedness(made_of(both[None]), noise=0.0)
    assert abs(np.nan_to_num(found.hand[0])) < 0.3


@pytest.mark.parametrize("count", [2, 3])
def test_three_spheres_are_in_one_plane(count):
    found = measure.handedness(made_of(helix(count, 1, 3.0)), noise=1e-9)
    assert np.isnan(found.hand).all()
    assert found.size == pytest.approx(0.0)


@pytest.mark.parametrize("factor", [1.0, 1e4])
def test_a_hand_below_the_tolerances_of_a_run_is_none(factor):
    """Coils of hundredths and of a thousand times atol; both when it is coarser by a factor."""
    tolerances = {"atol": factor * 1e-9, "rtol": factor * 1e-9}
    for radius, has_one in ((1e-2, False), (1e3, True)):
        coil = helix(12, 1, radius * A * tolerances["atol"])
        found = measure.handedness(made_of(coil, **tolerances))
        assert np.isfinite(found.hand).all() == has_one


def test_a_run_that_decays_to_straight_loses_its_hand():
    """The hand is nan once the coil is smaller than the tolerances."""
    scene = nrchain.load_scene(
        "stable",
        **{
            "chain.ends": "periodic",
            "start": {"shape": "helix-left", "amplitude": 1e-2},
            "run": {"end": 2000.0, "snapshots": 21},
        },
    )
    found = measure.handedness(nrchain.simulate(scene))
    assert found.hand[0] == pytest.approx(-1.0)
    assert np.isnan(found.hand[-1])
    assert abs(found.size[-1]) < 1e-6 * abs(found.size[0])


@pytest.mark.parametrize("noise", ["x", -1.0, math.nan, math.inf, True, [0.1]])
def test_noise_that_is_none_is_refused(noise):
    with pytest.raises(measure.MeasurementError, match=r"^noise = .*at least 0"):
        measure.handedness(made_of(helix(5, 1, 1.0)), noise=noise)
