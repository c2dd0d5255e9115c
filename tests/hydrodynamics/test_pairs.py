"""Slip flows summed by compiled loops, against the printed pair laws and against PyStokes."""

import os
import subprocess
import sys
from fractions import Fraction

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import legendre
from support.pair_reference import (
    LABELS,
    assert_close,
    crooked_chain,
    slip_twists,
    stresslet_of_finite_spheres,
    sum_law,
)
from support.poses import pose_derivative
from support.side_by_side import reads_of_the_loop

from nrchain import slip_modes
from nrchain.hydrodynamics import pair_law, pairs
from nrchain.hydrodynamics.pairs import SlipFlow
from nrchain.hydrodynamics.slip_mode import SlipMode

E1 = (1.0, 0.0, 0.0)


def make_flow(labels, count, *, reach=None, radius=1.0, axes=None, seed=3, **options):
    rng = np.random.default_rng(seed)
    strengths = [rng.normal(size=count) for _ in labels]
    flow = SlipFlow(
        labels,
        strengths,
        axes or [E1] * len(labels),
        count=count,
        reach=count - 1 if reach is None else reach,
        radius=radius,
        **options,
    )
    return flow, strengths


def evaluate(flow, positions, frames):
    twists = np.zeros((len(positions), 6))
    flow.add_twists(positions, frames, twists)
    return twists


def product(flow, positions, frames, poses):
    flow.add_twists(positions, frames, np.zeros((len(positions), 6)))
    twists = np.zeros((len(positions), 6))
    flow.add_product(poses, twists)
    return twists


@pytest.mark.parametrize("label", LABELS)
@pytest.mark.parametrize("radius", [0.3, 1.0, 2.7])
@pytest.mark.parametrize("reach", [1, 3, 8])
def test_each_mode_is_its_printed_law(label, radius, reach):
    positions, frames = crooked_chain(np.random.default_rng(1), 9, radius)
    flow, strengths = make_flow([label], 9, reach=reach, radius=radius)
    expected = slip_twists([label], positions, [frames[:, 0]], strengths, reach, radius)
    twists = evaluate(flow, positions, frames)
    assert_close(twists[:, :3], expected[:, :3])
    assert_close(twists[:, 3:], expected[:, 3:])


@given(seed=st.integers(0, 2**32 - 1), exponent=st.floats(-9, 9), count=st.integers(2, 30))
@settings(max_examples=40, deadline=None)
def test_all_modes_together_at_any_scale(seed, exponent, count):
    """More than a vector's width of spheres, and fewer, in units of any size."""
    radius = 10.0**exponent
    positions, frames = crooked_chain(np.random.default_rng(seed), count, radius)
    flow, strengths = make_flow(LABELS, count, radius=radius, seed=seed)
    axes = [frames[:, 0]] * len(LABELS)
    expected = slip_twists(LABELS, positions, axes, strengths, count - 1, radius)
    np.testing.assert_allclose(
        evaluate(flow, positions, frames) * [1, 1, 1, radius, radius, radius],
        expected * [1, 1, 1, radius, radius, radius],
        rtol=0,
        atol=1e-13 * max(np.abs(s).max() for s in strengths),
    )


def test_finite_size_is_that_of_the_stresslet():
    positions, frames = crooked_chain(np.random.default_rng(2), 6, 0.8)
    for label in LABELS:
        flow, strengths = make_flow([label], 6, radius=0.8, finite_size=True)
        state = positions, frames[:, 0], strengths[0], 5, 0.8
        expected = slip_twists([label], positions, [state[1]], strengths, 5, 0.8)
        if label == "2s":
            expected[:, :3] = sum_law({"2s": stresslet_of_finite_spheres}, "2s", *state)
        assert_close(evaluate(flow, positions, frames), expected)


@pytest.mark.parametrize("finite_size", [False, True])
@pytest.mark.parametrize("label", LABELS)
def test_spin_is_half_the_curl_of_the_flow(label, finite_size):
    positions, frames = crooked_chain(np.random.default_rng(5), 3, 1.0)
    strengths = [np.array([1.3, -0.8, 0.0])]
    flow = SlipFlow([label], strengths, [E1], count=3, reach=2, radius=1.0, finite_size=finite_size)

    def velocity(positions, frames):
        return evaluate(flow, positions, frames)[2, :3]

    gradient = pose_derivative(velocity, positions, frames)[:, 2, :3]
    half_curl = np.array([gradient[k - 1, k - 2] - gradient[k - 2, k - 1] for k in range(3)]) / 2
    spin = evaluate(flow, positions, frames)[2, 3:]
    np.testing.assert_allclose(spin, half_curl, rtol=0, atol=1e-8 * np.abs(gradient).max())
    assert abs(np.trace(gradient)) <= 1e-8 * np.abs(gradient).max()


def test_modes_act_each_along_its_own_axis():
    positions, frames = crooked_chain(np.random.default_rng(6), 7, 1.0)
    bodies = [(0.0, 2.0, 0.0), (1.0, -3.0, 0.5), E1, (0.0, 1.0, 0.0)]
    flow, strengths = make_flow(LABELS, 7, reach=3, axes=bodies)
    assert len(flow.law.axes) == 3
    axes = [np.array(b) / np.linalg.norm(b) @ frames for b in bodies]
    expected = slip_twists(LABELS, positions, axes, strengths, 3, 1.0)
    assert_close(evaluate(flow, positions, frames), expected)


def test_a_registered_mode_is_compiled_like_any_other(monkeypatch):
    """A rotlet: u = V s² e × n, whose half curl is V s³ (3c n − e)/2a, read from one row."""
    monkeypatch.setattr(slip_modes, "_MODES", dict(slip_modes._MODES))
    slip_modes.register(SlipMode("1r", "rotlet", 1, True, True, {("x", 2): (1,)}))
    positions, frames = crooked_chain(np.random.default_rng(7), 5, 1.7)
    flow, strengths = make_flow(["1r", "3t"], 5, radius=1.7)
    expected = slip_twists(["3t"], positions, [frames[:, 0]], strengths[1:], 4, 1.7)
    rotlet = {"1r": lambda a, r, c, n, e: a**2 / r**2 * np.cross(e, n)}
    half_curl = {"1r": lambda a, r, c, n, e: a**2 / r**3 * (3 * c * n - e) / 2}
    state = "1r", positions, frames[:, 0], strengths[0], 4, 1.7
    expected[:, :3] += sum_law(rotlet, *state)
    expected[:, 3:] += sum_law(half_curl, *state)
    assert_close(evaluate(flow, positions, frames), expected)


def test_all_images_of_a_periodic_chain():
    """Against plain sums over many neighbours, whose remainder falls as their number squared."""
    count, period = 4, 14.5
    positions, frames = crooked_chain(np.random.default_rng(12), count, 1.0)

    def sums(reach):
        rng = np.random.default_rng(3)
        strengths = [rng.normal(size=count) for _ in LABELS]
        options = {"count": count, "reach": reach, "radius": 1.0, "period": period}
        return SlipFlow(LABELS, strengths, [E1] * len(LABELS), **options)

    whole = evaluate(sums(None), positions, frames)
    plain = [evaluate(sums(count * images), positions, frames) for images in (1000, 2000)]
    errors = [np.abs(p - whole).max() for p in plain]
    assert errors[1] < 1e-6 * np.abs(whole).max()
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)
    assert np.abs((4 * plain[1] - plain[0]) / 3 - whole).max() < 0.01 * errors[1]


@pytest.mark.parametrize("reach", [1, 4, 9])
def test_periodic_chains_feel_their_images(reach):
    count, period = 4, 14.5
    positions, frames = crooked_chain(np.random.default_rng(12), count, 1.0)
    flow, strengths = make_flow(LABELS, count, reach=reach, period=period)
    axes = [frames[:, 0]] * len(LABELS)
    expected = slip_twists(LABELS, positions, axes, strengths, reach, 1.0, period)
    assert_close(evaluate(flow, positions, frames), expected)


def test_modes_without_strength_are_not_evaluated(monkeypatch):
    positions, frames = crooked_chain(np.random.default_rng(13), 4, 1.0)
    options = {"count": 4, "reach": 3, "radius": 1.0}
    flow = SlipFlow(["2s", "4a"], [np.zeros(4), np.ones(4)], [E1, E1], **options)
    assert flow.labels == ("4a",)
    assert "3.5" not in flow.law.source
    np.testing.assert_array_equal(flow.strengths, np.ones((1, 4)))

    for compile_kernel in ("twist_kernel", "product_kernel", "block_kernel"):
        monkeypatch.setattr(pairs, compile_kernel, lambda *_: pytest.fail("evaluated"))
    still = SlipFlow(["2s", "4a"], [np.zeros(4)] * 2, [E1, E1], **options)
    assert not still
    blocks = np.zeros((4, 3, 6, 6))
    still.add_jacobian(positions, frames, blocks)
    assert not evaluate(still, positions, frames).any()
    assert not product(still, positions, frames, np.ones((4, 6))).any()
    assert not blocks.any()


def test_results_do_not_depend_on_the_number_of_threads():
    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("one thread only")
    count = 301
    positions, frames = crooked_chain(np.random.default_rng(14), count, 1.0)
    flow, _ = make_flow(LABELS, count)
    assert flow._parallel
    poses = np.random.default_rng(15).normal(size=(count, 6))
    results = []
    before = numba.get_num_threads()
    try:
        for threads in (1, 2):
            numba.set_num_threads(threads)
            twists = evaluate(flow, positions, frames)
            results.append((twists, product(flow, positions, frames, poses)))
    finally:
        numba.set_num_threads(before)
    np.testing.assert_array_equal(results[0], results[1])

    flow._parallel = False
    assert_close(evaluate(flow, positions, frames), results[0][0], 1e-14)


def test_a_position_that_is_no_number_is_felt_by_all():
    positions, frames = crooked_chain(np.random.default_rng(16), 40, 1.0)
    flow, _ = make_flow(LABELS, 40)
    positions[17, 1] = np.nan
    assert np.isnan(evaluate(flow, positions, frames)).all()


LAW = """
from nrchain.hydrodynamics import pair_law
law = pair_law.PairLaw.of(["2s", "3t"], [(1.0, 0.0, 0.0)] * 2)
function = pair_law._compiled(law.source{change}, "{name}")
"""


@pytest.mark.parametrize(
    ("name", "tables", "rows"), [("sum_twists", 1, 3 + 3 + 2), ("sum_changes", 2, 8 + 3 + 3)]
)
def test_the_loop_over_pairs_reads_side_by_side(name, tables, rows):
    """The places, the axis and the strengths of several spheres at once, and their changes: the
    speed of all-pairs sums rests on it."""
    assert reads_of_the_loop(LAW.format(change="", name=name), tables) == (rows, 0)


@pytest.mark.parametrize(
    "change",
    [
        # an index that may count from the end
        '.replace("np.uint64(first), np.uint64(last)", "first, last")',
        '.replace("        inverse =", "        print(j)\\n        inverse =")',
    ],
)
def test_a_loop_that_could_not_would_be_noticed(change):
    assert reads_of_the_loop(LAW.format(change=change, name="sum_twists"), 1)[0] == 0


def test_machine_code_is_found_again_by_another_process(tmp_path):
    """Also when the first process needed it for one thread and the second for several."""
    code = """
import sys
import numpy as np
from nrchain.hydrodynamics.pairs import SlipFlow, twist_kernel
for count in map(int, sys.argv[1:]):
    flow = SlipFlow(["3t"], [np.ones(count)], [(1, 0, 0)], count=count, reach=count - 1, radius=1.0)
    positions = np.arange(3.0 * count).reshape(-1, 3)
    flow.add_twists(positions, np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 6)))
    stats = twist_kernel(flow.law.source, flow._parallel).stats
    print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    runs = [
        subprocess.run(
            [sys.executable, "-c", code, *counts],
            env=environment,
            check=True,
            capture_output=True,
            text=True,
        ).stdout.split()
        for counts in (["5"], ["5", "200"], ["200"])
    ]
    assert runs == [["0", "1"], ["1", "0", "0", "1"], ["1", "0"]]


def test_no_two_kernels_share_a_name():
    """Machine code of one name, kept by different processes, is linked as one (see rename)."""
    laws = {
        pair_law.PairLaw.of([label], [E1], finite_size).source
        for label in LABELS
        for finite_size in (False, True)
    }
    kernels = [
        make(law, parallel)
        for law in laws
        for make in (pairs.twist_kernel, pairs.product_kernel)
        for parallel in (False, True)
    ]
    kernels += [pairs.block_kernel(law) for law in laws]
    assert len({kernel.py_func.__qualname__ for kernel in kernels}) == len(kernels)


def test_the_text_of_a_law_is_the_law_whatever_its_powers(monkeypatch):
    """Two rows far apart, run as plain Python: no machine code on disk takes the text's place.

    The flow is ∇φ × r of a harmonic φ: u = V (s² + s⁸ P₇'(c)) e × n.
    """
    monkeypatch.setattr(slip_modes, "_MODES", dict(slip_modes._MODES))
    seventh = tuple(Fraction(q, 16) for q in (-35, 0, 945, 0, -3465, 0, 3003))
    rows = {("x", 2): (1,), ("x", 8): seventh}
    slip_modes.register(SlipMode("9x", "two far rows", 9, True, True, rows))
    law = pair_law.PairLaw.of(["9x"], [(1.0, 0.0, 0.0)])
    radius, strength, axis = 1.3, -2.0, np.array([0.6, 0.0, 0.8])
    sources = np.zeros((7, 2))
    sources[:3, 1], sources[3:6, 0], sources[6, 0] = [2.0, -3.0, 1.5], axis, strength
    run = pair_law._compiled(law.source, "sum_twists").py_func
    distance = np.linalg.norm(sources[:3, 1])
    scale, normal = radius / distance, sources[:3, 1] / distance
    slope = legendre.Legendre.basis(7).deriv()(axis @ normal)
    expected = strength * (scale**2 + scale**8 * slope) * np.cross(axis, normal)
    np.testing.assert_allclose(run(sources, radius, 1, 0, 1)[:3], expected, rtol=1e-14)
