"""The PyStokes backend against the printed pair laws, summed in plain loops."""

import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pystokes
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.pair_reference import (
    LABELS,
    SPIN,
    VELOCITY,
    assert_close,
    law,
    mobility,
    sum_law,
)

from nrchain.errors import BackendError, SceneError
from nrchain.hydrodynamics import pystokes as release
from nrchain.hydrodynamics import pystokes_backend as backend
from nrchain.hydrodynamics.pystokes_check import check


def reference(laws, label, positions, axes, strengths, neighbours, radius):
    reach = len(positions) - 1 if neighbours == "all" else neighbours
    return sum_law(laws, label, positions, axes, strengths, reach, radius)


def pose(rng, count, radius):
    """A crooked chain with spheres at least 2.5 radii apart, with axes and strengths of its own."""
    steps = rng.uniform([2.5, -1.0, -1.0], [4.0, 1.0, 1.0], (count, 3))
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return radius * np.cumsum(steps, axis=0), axes, rng.normal(size=count)


def evaluate(label, positions, axes, strengths, *, neighbours="all", radius=1.0, finite_size=False):
    return backend.twists(
        positions,
        [axes],
        [strengths],
        neighbours=neighbours,
        radius=radius,
        viscosity=1.3,
        finite_size=finite_size,
        labels=[label],
    )


@pytest.mark.parametrize("label", LABELS)
@pytest.mark.parametrize("radius", [0.3, 1.0, 2.7])
@pytest.mark.parametrize("neighbours", [1, 3, "all"])
def test_each_mode_is_its_closed_form(label, radius, neighbours):
    state = pose(np.random.default_rng(4), 7, radius)
    velocities, spins = evaluate(label, *state, neighbours=neighbours, radius=radius)
    assert_close(velocities, reference(VELOCITY, label, *state, neighbours, radius))
    assert_close(spins, reference(SPIN, label, *state, neighbours, radius))


@given(
    seed=st.integers(0, 2**32 - 1),
    exponent=st.floats(-9, 9),
    label=st.sampled_from(LABELS),
    neighbours=st.sampled_from([1, 2, 4, 9, "all"]),
    count=st.integers(2, 6),
)
@settings(max_examples=60, deadline=None)
def test_any_pose_and_any_radius(seed, exponent, label, neighbours, count):
    radius = 10.0**exponent
    state = pose(np.random.default_rng(seed), count, radius)
    velocities, spins = evaluate(label, *state, neighbours=neighbours, radius=radius)
    # One pair may lie near a zero of its law, where rounding of its cosine is all there is.
    u_scale, w_scale = np.abs(state[2]).max(), np.abs(state[2]).max() / radius
    u = reference(VELOCITY, label, *state, neighbours, radius)
    w = reference(SPIN, label, *state, neighbours, radius)
    np.testing.assert_allclose(velocities, u, rtol=0, atol=1e-13 * u_scale)
    np.testing.assert_allclose(spins, w, rtol=0, atol=1e-13 * w_scale)


@pytest.mark.parametrize("label", LABELS)
def test_closed_forms_hold_a_million_radii_away(label):
    positions, axes, strengths = pose(np.random.default_rng(8), 8, 1.0)
    positions[4:] += [1e6, 0.0, 0.0]
    strengths[:4] = 0.0
    velocities, spins = evaluate(label, positions, axes, strengths)
    state = positions, axes, strengths, "all", 1.0
    assert_close(velocities[:4], reference(VELOCITY, label, *state)[:4])
    assert_close(spins[:4], reference(SPIN, label, *state)[:4])


def test_modes_add_up_each_along_its_own_axis():
    rng = np.random.default_rng(5)
    positions = pose(rng, 5, 1.0)[0]
    states = {label: pose(rng, 5, 1.0)[1:] for label in LABELS}
    together = backend.twists(
        positions,
        [axes for axes, _ in states.values()],
        [strengths for _, strengths in states.values()],
        neighbours=2,
        radius=1.0,
        viscosity=1.0,
        finite_size=False,
        labels=LABELS,
    )
    alone = [evaluate(label, positions, *states[label], neighbours=2) for label in LABELS]
    assert_close(together[0], sum(u for u, _ in alone), 1e-14)
    assert_close(together[1], sum(w for _, w in alone), 1e-14)


@pytest.mark.parametrize("radius", [0.3, 1.0, 2.7])
def test_finite_size_stresslet_is_what_pystokes_returns(radius):
    positions, axes, strengths = pose(np.random.default_rng(6), 5, radius)
    raw = np.zeros(15)
    tensor = release.irreducible_tensor(2, axes, strengths)
    rbm = pystokes.unbounded.Rbm(radius=radius, particles=5)
    rbm.propulsionT2s(raw, positions.T.flatten(), tensor.flatten())
    found, _ = evaluate("2s", positions, axes, strengths, radius=radius, finite_size=True)
    assert_close(found, -raw.reshape(3, 5).T, 1e-15)


@pytest.mark.parametrize("label", LABELS)
def test_finite_size_is_a_laplacian_that_only_the_stresslet_has(label):
    rng = np.random.default_rng(7)
    radius, h = 0.8, 1e-2
    state = pose(rng, 2, radius)
    corrected = evaluate(label, *state, radius=radius, finite_size=True)
    leading = evaluate(label, *state, radius=radius)
    np.testing.assert_array_equal(corrected[1], leading[1])
    if label != "2s":
        np.testing.assert_array_equal(corrected[0], leading[0])
        return

    positions, axes, strengths = state
    separation = positions[1] - positions[0]
    stencil = {-2: -1 / 12, -1: 4 / 3, 0: -5 / 2, 1: 4 / 3, 2: -1 / 12}
    laplacian = sum(
        weight / h**2 * law(VELOCITY, label, separation + m * h * direction, axes[0], radius)
        for direction in np.eye(3)
        for m, weight in stencil.items()
    )
    expected = strengths[0] * radius**2 * (1 / 6 + 1 / 10) * laplacian
    assert_close((corrected[0] - leading[0])[1], expected, 1e-6)


@pytest.mark.parametrize("finite_size", [False, True])
@pytest.mark.parametrize("label", LABELS)
def test_spin_is_half_the_curl_of_the_flow(label, finite_size):
    positions, axes, strengths = pose(np.random.default_rng(9), 2, 1.0)
    strengths[1] = 0.0

    def flow(shift):
        moved = positions + np.array([np.zeros(3), shift])
        return evaluate(label, moved, axes, strengths, finite_size=finite_size)[0][1]

    h = 1e-3
    gradient = np.array(
        [8 * (flow(h * e) - flow(-h * e)) - flow(2 * h * e) + flow(-2 * h * e) for e in np.eye(3)]
    ) / (12 * h)
    half_curl = np.array([gradient[k - 2, k - 1] - gradient[k - 1, k - 2] for k in range(3)]) / 2
    spin = evaluate(label, positions, axes, strengths, finite_size=finite_size)[1][1]
    np.testing.assert_allclose(spin, half_curl, rtol=0, atol=1e-9 * np.abs(gradient).max())


def test_torque_dipole_routine_is_wrong_and_what_replaces_it_is_right():
    """propulsionR3a has 32 V·x where half the curl of propulsionT3a has −8, and the other sign."""
    positions, axes, strengths = pose(np.random.default_rng(10), 2, 1.0)
    strengths[1] = 0.0
    tensor = release.irreducible_tensor(2, axes, strengths)
    raw = np.zeros(6)
    pystokes.unbounded.Rbm(particles=2).propulsionR3a(raw, positions.T.flatten(), tensor.flatten())
    raw = raw.reshape(3, 2)[:, 1]

    expected = reference(SPIN, "3a", positions, axes, strengths, "all", 1.0)[1]
    best = (raw @ expected) / (expected @ expected) * expected
    assert np.linalg.norm(raw - best) > 0.1 * np.linalg.norm(raw)

    x = positions[1] - positions[0]
    contracted = strengths[0] * (axes[0] * (axes[0] @ x) - x / 3)
    derived = -raw + 24 * contracted / np.linalg.norm(x) ** 5
    assert_close(derived, 96 / 13 * expected)
    assert_close(evaluate("3a", positions, axes, strengths)[1][1], expected)


def test_repeated_calls_agree_bit_for_bit_and_leave_their_input_alone():
    state = pose(np.random.default_rng(11), 60, 1.0)
    for array in state:
        array.flags.writeable = False
    for label in LABELS:
        first = evaluate(label, *state)
        for _ in range(5):
            np.testing.assert_array_equal(evaluate(label, *state), first)


def test_a_lone_sphere_stays_at_rest():
    for neighbours in (1, "all"):
        found = evaluate("2s", np.zeros((1, 3)), np.eye(3)[:1], np.ones(1), neighbours=neighbours)
        np.testing.assert_array_equal(found, np.zeros((2, 1, 3)))


def test_a_mode_without_strength_is_not_evaluated(monkeypatch):
    monkeypatch.setattr(backend, "sum_flow", lambda *_: pytest.fail("evaluated"))
    positions, axes, _ = pose(np.random.default_rng(12), 3, 1.0)
    assert not np.any(evaluate("4a", positions, axes, np.zeros(3)))


def test_a_mode_without_a_routine_is_refused():
    with pytest.raises(SceneError, match=r"2s, 3a, 3t, 4a only; mode '2q' needs 'native'"):
        evaluate("2q", *pose(np.random.default_rng(13), 3, 1.0))


def test_the_installed_release_passes_its_check():
    check()
    check("2.3.2")


def test_an_unknown_release_is_refused_with_what_was_measured(monkeypatch):
    monkeypatch.setattr(pystokes, "__version__", "9.8.7")
    with pytest.raises(BackendError) as refusal:
        evaluate("2s", *pose(np.random.default_rng(14), 3, 1.0))
    message = str(refusal.value)
    assert "PyStokes 9.8.7" in message
    assert "known: 2.3.2" in message
    for measured in ("propulsionT2s -1 ", "propulsionT3a 7.38462", "propulsionT4a -0.132231"):
        assert measured in message


@pytest.mark.parametrize(
    ("change", "measured"),
    [
        ({"ratio": Fraction(1, 2)}, r"propulsionT3t 1 where 1/2 is known, misfit \de-1\d"),
        ({"power": 0}, r"propulsionT3t \S+ where 1 is known, misfit [1-9]e-0\d"),
        ({"method": "propulsionT9z"}, r"propulsionT9z fails: .*propulsionT9z"),
        ({"method": "mobilityTT"}, r"mobilityTT \S+ where 1 is known, misfit"),
    ],
)
def test_the_check_finds_a_wrong_row(monkeypatch, change, measured):
    table = dict(release.RELEASES["2.3.2"])
    table["3t"] = replace(table["3t"], velocity=replace(table["3t"].velocity, **change))
    monkeypatch.setitem(release.RELEASES, "2.3.2", table)
    with pytest.raises(BackendError, match=measured):
        check()


def test_the_check_runs_once(monkeypatch):
    calls = []
    monkeypatch.setattr(backend, "check", calls.append)
    monkeypatch.setattr(backend, "_verified", cache(backend._verified.__wrapped__))
    state = pose(np.random.default_rng(15), 3, 1.0)
    evaluate("2s", *state)
    evaluate("3a", *state)
    assert calls == ["2.3.2"]


def test_a_missing_library_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pystokes", None)
    with pytest.raises(BackendError, match=r"cannot be imported .* install pystokes==2\.3\.2"):
        evaluate("2s", *pose(np.random.default_rng(16), 3, 1.0))


def test_a_sum_that_does_not_fit_in_memory_says_how_much_it_needs(monkeypatch):
    state = pose(np.random.default_rng(17), 3, 1.0)
    evaluate("2s", *state)

    def refuse(**_):
        raise MemoryError

    monkeypatch.setattr(pystokes.unbounded, "Rbm", refuse)
    with pytest.raises(BackendError, match=r"needs 6\.48e-07 GB to sum over all pairs of 3"):
        evaluate("2s", *state)


@pytest.mark.parametrize("radius", [0.3, 1.0, 2.7])
@pytest.mark.parametrize("neighbours", [1, 3, "all"])
def test_mobilities_are_their_closed_forms(radius, neighbours):
    rng = np.random.default_rng(18)
    positions = pose(rng, 6, radius)[0]
    wrenches = rng.normal(size=(6, 6))
    reach = 5 if neighbours == "all" else neighbours
    expected = mobility(positions, reach, radius, 1.3) @ wrenches.ravel()
    found = backend.mobility(positions, wrenches, neighbours, radius, 1.3)
    assert_close(found, expected.reshape(6, 6), 2e-15)


def test_mobility_of_a_lone_sphere():
    found = backend.mobility(np.zeros((1, 3)), np.ones((1, 6)), "all", 2.0, 1.0)
    expected = [1 / (12 * np.pi)] * 3 + [1 / (64 * np.pi)] * 3
    np.testing.assert_allclose(found, [expected], rtol=1e-15)


@pytest.mark.parametrize("neighbours", [2, "all"])
def test_overlapping_spheres_are_refused(neighbours):
    positions = np.array([[0.0, 0, 0], [5, 0, 0], [0, 1.9, 0], [20, 0, 0]])
    with pytest.raises(BackendError, match=r"spheres 0 and 2 are 1\.9 apart.*native"):
        backend.mobility(positions, np.ones((4, 6)), neighbours, 1.0, 1.0)
    backend.mobility(positions, np.ones((4, 6)), 1, 1.0, 1.0)


@pytest.mark.parametrize("neighbours", [3, 7, "all"])
def test_the_ends_of_a_closed_chain_that_overlap_are_refused(neighbours):
    positions = np.array([[0.0, 0, 0], [5, 0, 0], [5, 5, 0], [0, 3.1, 0]])
    with pytest.raises(BackendError, match=r"spheres 0 and 3 are 3\.1 apart"):
        backend.mobility(positions, np.ones((4, 6)), neighbours, 1.6, 1.0)
    backend.mobility(positions, np.ones((4, 6)), 2, 1.6, 1.0)


def test_the_check_finds_a_wrong_mobility(monkeypatch):
    monkeypatch.setitem(release.PI, "2.3.2", 3.1415926536)
    with pytest.raises(BackendError, match=r"mobilityRR 1 where 1 is known, misfit"):
        check()
    monkeypatch.undo()
    monkeypatch.setitem(release.MOBILITIES, "mobilityXX", release.MOBILITIES["mobilityTT"])
    with pytest.raises(BackendError, match="mobilityXX fails"):
        check()


def test_importing_the_backend_does_not_import_the_library():
    code = "import sys, nrchain.hydrodynamics.pystokes_backend; sys.exit('pystokes' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
