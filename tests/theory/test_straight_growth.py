"""The straight state of a finite chain and its growth rates, against runs and plane waves."""

import math
from itertools import product

import numpy as np
import pytest
from scipy.sparse import csc_array
from support.graded_chains import UNITS, graded, opposed
from support.plan_scenes import random_scene
from support.poses import pose_derivative
from support.selection import few_of

import nrchain
from nrchain.motion.model import Model
from nrchain.outcome import Cause
from nrchain.theory.lattice import lattice_rates
from nrchain.theory.line_loads import sparse_factors
from nrchain.theory.straight_growth import DENSE, straight_growth
from nrchain.theory.straight_state import LONGEST, straight_state
from nrchain.watch.seed import bend_growth_exponent

FORTY = [500.0] * 20 + [-500.0] * 20

FRICTIONS = ("one-body", "pairwise")

CHAINS = [
    {"slip.2s": 60.0},
    {"slip.2s": [60.0] * 6 + [20.0] * 6, "chain.ends": "clamped"},
    {"slip.2s": 60.0, "slip.4a": 800.0},
    {"slip.3a": 4000.0, "slip.neighbours": "all"},
    {"slip.2s": -60.0, "slip.2s.axis": [0.0, 1.0, 0.0]},
]


def mirrored(state):
    """The link at which a straight chain stops, and its mirror image."""
    return state.link, len(state.lengths) - 1 - state.link


def growth(scene):
    return straight_growth(scene, straight_state(scene))


def ring(count, **changes):
    table = {"chain.ends": "periodic", "chain.particles": count, "elasticity.ratio": 1e9}
    return nrchain.load_scene("buckling", **UNITS, **table | changes)


def fastest_wave_that_fits(scene):
    """max Re Λ over the waves that a ring of N spheres holds, of the hands of bends and shear."""
    count = scene.chain.particles
    waves = 2.0 * math.pi * np.arange(1, count // 2 + 1) / (count * scene.chain.spacing)
    return lattice_rates(scene, waves, frame="spinning").real.max()


@pytest.mark.parametrize(
    ("friction", "ends"),
    few_of(
        product(FRICTIONS, ["free", "clamped", "periodic"]),
        [*product(["one-body"], ["free", "clamped", "periodic"]), ("pairwise", "periodic")],
    ),
)
def test_the_straight_state_is_where_a_straight_chain_comes_to_rest(ends, friction):
    scene = graded(ends, friction, 100.0, **{"slip.2s": [10.0] * 5 + [-5.0] * 7})
    state, run = straight_state(scene), nrchain.simulate(scene)
    assert (state.stopped, run.status) == (None, "completed")
    x = run.positions[-1, :, 0]
    lengths = np.diff(x)
    assert np.ptp(lengths) > 0.05 * scene.chain.spacing
    assert state.lengths[: len(lengths)] == pytest.approx(lengths, rel=1e-3)
    assert len(state.lengths) == len(lengths) + (ends == "periodic")


@pytest.mark.filterwarnings("ignore::nrchain.SceneWarning")
def test_spheres_that_come_to_touch_on_the_line_do_so_in_the_run():
    for scene in (opposed(6.0), opposed(20.0, **{"chain.particles": 40, "slip.3t": FORTY})):
        state, run = straight_state(scene), nrchain.simulate(scene)
        assert state.stopped is run.cause is Cause.TOUCH
        assert state.time == pytest.approx(run.time[-1], rel=0.05)
        assert any(f"spheres {link} and {link + 1}" in run.reason for link in mirrored(state))


@pytest.mark.filterwarnings("ignore::nrchain.SceneWarning")
def test_a_chain_that_lingers_before_it_collapses_is_followed_to_the_end():
    """Links 30 % shorter move slowly at first; long implicit steps would end at rest there."""
    scene = random_scene(1185)
    state, run = straight_state(scene), nrchain.simulate(scene)
    assert state.stopped is run.cause is Cause.TOUCH
    assert state.time == pytest.approx(run.time[-1], rel=0.1)


@pytest.mark.filterwarnings("ignore::nrchain.SceneWarning")
def test_links_that_torques_turn_over_do_so_in_the_run():
    """μ∥ sin θ cos θ holds no more than μ∥/2; the moment of halves that spin apart is above it."""
    scene = nrchain.load_scene(
        "spiral-left",
        **{"slip.4a": [1e4] * 10 + [-1e4] * 10, "elasticity.twist": 900.0},
        **{"start.shape": "straight", "run.end": 2.0},
    )
    state, run = straight_state(scene), nrchain.simulate(scene)
    assert state.stopped is run.cause is Cause.TURN
    assert state.time == pytest.approx(run.time[-1], rel=0.1)
    assert any(f"link {link} " in run.reason for link in mirrored(state))


@pytest.mark.parametrize(
    ("changes", "friction"),
    few_of(
        product(CHAINS, FRICTIONS),
        [*product(CHAINS[:3], ["one-body"]), *product(CHAINS[3:], ["pairwise"])],
    ),
)
def test_growth_is_the_largest_eigenvalue_of_difference_quotients(friction, changes):
    """∂(v, ω)/∂(u, φ) by moving one sphere at a time, in axes that spin with the chain."""
    table = {"chain.particles": 12, "elasticity.ratio": 1e8, "chain.ends": "free"}
    scene = nrchain.load_scene("buckling", **UNITS, **table | changes, friction=friction)
    state, model = straight_state(scene), Model(scene)
    matrix = pose_derivative(model.twists, state.positions, state.frames, 1e-4)
    own, spin = np.arange(12), state.twists[5, 3]
    matrix[own, 1, own, 2] += spin
    matrix[own, 2, own, 1] -= spin
    free = ~model.held
    matrix = matrix[free][:, :, free].reshape(6 * free.sum(), -1)
    values = np.linalg.eigvals(matrix).real.max()
    found = growth(scene)
    largest = max(found.along.rate, found.across.rate)
    assert largest == pytest.approx(max(values, 0.0), rel=1e-3, abs=1e-6)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"slip.neighbours": "all"},
        {"slip.4a": 2000.0},
        {"slip.3a": 9000.0, "slip.2s": None},
        {"friction": "pairwise"},
    ],
)
def test_a_ring_grows_as_the_plane_waves_that_fit_it(changes):
    """On a uniform ring plane waves are exact: the infinite chain is its own reference there."""
    scene = ring(16, **changes)
    expected = fastest_wave_that_fits(scene)
    assert expected > 1e-4
    found = growth(scene)
    assert found.whole
    assert found.across.rate == pytest.approx(expected, rel=1e-6)


def test_a_long_ring_too_of_which_few_eigenvalues_are_taken():
    scene = ring(5 * DENSE // 2, **{"elasticity.ratio": 3e12})
    assert growth(scene).across.rate == pytest.approx(fastest_wave_that_fits(scene), rel=1e-3)
    cut = ring(5 * DENSE // 2, **{"elasticity.ratio": 3e12, "slip.neighbours": "all"})
    found = growth(cut)
    assert not found.whole
    assert found.across.rate == pytest.approx(fastest_wave_that_fits(cut), rel=0.1)


def test_a_short_free_chain_of_pushers_stays_straight_where_the_infinite_one_buckles():
    """The tension of the links balances the slip stress: no thrust is left, and bends decay."""
    scene = nrchain.load_scene("buckling", **{"chain.ends": "free", "run.end": 400.0})
    assert growth(scene).across.rate == 0.0
    waves = np.linspace(0.0157, 0.314, 64)
    assert lattice_rates(scene, waves).real.max() > 0.01
    run = nrchain.simulate(scene)
    assert np.ptp(run.positions[-1, :, 1]) < np.ptp(run.positions[0, :, 1])


@pytest.mark.parametrize(
    ("ends", "label", "strongest"), [("clamped", "2s", 30.0), ("free", "3a", 9e3)]
)
def test_growth_is_that_of_a_run_from_a_small_bend(ends, label, strongest):
    """d ln(offset)/dt late in a run that stays small: strengths differ along the chain."""
    each = np.linspace(strongest, 0.3 * strongest, 20).tolist()
    scene = nrchain.load_scene(
        "buckling",
        **UNITS,
        **{"chain.ends": ends, "slip.2s": None, f"slip.{label}": each, "slip.neighbours": 2},
        **{"elasticity.ratio": 1e10, "run.snapshots": 101},
        **{"start.amplitude": 1e-7, "run.atol": 1e-12, "run.rtol": 1e-9},
    )
    rate = growth(scene).across.rate
    run = nrchain.simulate(nrchain.load_scene(scene, **{"run.end": 12.0 / rate}))
    axis = run.positions[:, -1] - run.positions[:, 0]
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    away = np.cross(run.positions - run.positions[:, :1], axis[:, None])
    sizes = np.log(np.linalg.norm(away, axis=2).max(axis=1))
    assert math.log(1e-5) < sizes[-1] < math.log(0.1)
    measured = np.polyfit(run.time[70:], sizes[70:], 1)[0]
    assert measured == pytest.approx(rate, rel=0.02)


def test_motions_of_the_whole_chain_are_no_growth():
    """An extension carries a chain away, e-fold every 1/G, and turns one that lies across it."""
    for gradient in ([0.01, -0.005, -0.005], [-1e-4, 2e-4, -1e-4]):
        scene = nrchain.load_scene(
            "passive",
            **{"chain.ends": "free", "flow.gradient": np.diag(gradient).tolist()},
            **{"elasticity.ratio": 1e9, "run.end": 1e4},
        )
        found = growth(scene)
        for mode in (found.along, found.across):
            assert (mode.rate, mode.shear, mode.phase) == (0.0, 0.0, 0.0)


def test_modes_of_shear_are_separated_from_those_of_bending():
    stiff = {"elasticity": {"ratio": None, "stretch": 500.0, "shear": 500.0}}
    soft = {"elasticity": {"ratio": None, "stretch": 500.0, "shear": 1.0}}
    bends, shears = (
        growth(nrchain.load_scene("buckling", **each)).across for each in (stiff, soft)
    )
    assert bends.shear < 0.2 < 0.5 < shears.shear
    assert bends.phase < 0.6


def test_longer_chains_are_refused_before_any_time_is_spent():
    with pytest.raises(nrchain.SceneError, match="at most 1000") as refused:
        straight_state(nrchain.load_scene("buckling", **{"chain.particles": LONGEST + 1}))
    assert refused.value.value == LONGEST + 1


def test_a_chain_beyond_rounding_is_not_judged_and_ends_as_it_must(capfd):
    # the pull of the slip is 1e138 times that of the links: no factors of the line are sound
    keys = {"chain.particles": 7, "chain.ends": "free", "chain.spacing": 2.5, "chain.radius": 0.8}
    strong = {"slip.2s": -1e150, "friction": "pairwise", "run.end": 0.3, "elasticity.ratio": 3e11}
    scene = nrchain.load_scene("passive", **keys, **strong)
    with pytest.raises((FloatingPointError, nrchain.SceneError)):
        straight_state(scene)
    assert bend_growth_exponent(scene) == 0.0
    assert nrchain.simulate(scene).cause in (Cause.STEP, Cause.NOT_FINITE)
    assert capfd.readouterr().out == ""


def test_singular_factors_raise_the_error_that_callers_expect():
    with pytest.raises(FloatingPointError, match="the straight chain is singular"):
        sparse_factors(csc_array(np.zeros((3, 3))))
