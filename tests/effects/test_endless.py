"""Net forces on a periodic chain whose friction is cut: against sums over images, term by term."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.pair_reference import mobility

import nrchain
import nrchain.planning.plan
from nrchain.errors import SceneError
from nrchain.motion.model import Model

A, ETA, D, N = 0.7, 2.3, 5.0, 5
CHAIN = {"particles": N, "radius": A, "viscosity": ETA, "spacing": D, "ends": "periodic"}
SLACK = {"stretch": 0.0, "shear": 0.0, "twist": 0.0, "bend": 0.0}
FIELD = {
    "force": [20.0, -30.0, 40.0],
    "torque": [9.0, -5.0, 7.0],
    "body_force": [15.0, 10.0, -25.0],
}


def scene(neighbours, field=FIELD, **changes):
    table = {
        "chain": CHAIN,
        "elasticity": SLACK,
        "field": field,
        "friction": {"kind": "pairwise", "neighbours": neighbours},
        "run": {"end": 2.0, "snapshots": 5, "integrator": "radau", "rtol": 1e-10, "atol": 1e-10},
    }
    return nrchain.load_scene(table, **changes)


def crooked(seed=3):
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-0.9, 0.9, (N, 3))
    positions[:, 0] += D * np.arange(N)
    frames = np.linalg.qr(rng.normal(size=(N, 3, 3)))[0]
    return positions, frames * np.linalg.det(frames)[:, None, None]


def summed(positions, frames, neighbours):
    """μ·W, every pair and image by itself."""
    wrenches = np.tile([*FIELD["force"], *FIELD["torque"]], (N, 1))
    wrenches[:, :3] += np.array(FIELD["body_force"]) @ frames
    return (mobility(positions, neighbours, A, ETA, N * D) @ wrenches.ravel()).reshape(N, 6)


@pytest.mark.parametrize("neighbours", [1, 2, N - 1, N, 2 * N + 3])
def test_twists_are_the_sum_over_images(neighbours):
    poses = crooked()
    twists = Model(scene(neighbours)).twists(*poses)
    expected = summed(*poses, neighbours)
    assert twists == pytest.approx(expected, rel=1e-12, abs=1e-13)
    # the spheres at the seam feel those beyond it
    open_chain = Model(scene(neighbours, **{"chain.ends": "free"})).twists(*poses)
    assert np.abs(twists - open_chain)[[0, -1]].max() > 0.05 * np.abs(twists).max()


@pytest.mark.parametrize("integrator", ["radau", "cvode"])
def test_a_run_moves_as_the_sum_says(integrator):
    """Against SciPy's explicit Runge–Kutta of order 8 on positions and frames."""

    def rates(time, state):
        positions, frames = state[: 3 * N].reshape(N, 3), state[3 * N :].reshape(N, 3, 3)
        twists = summed(positions, frames, 2)
        turning = np.cross(twists[:, None, 3:], frames)
        return np.concatenate([twists[:, :3].ravel(), turning.ravel()])

    poses = crooked()
    case = scene(2, **{"run.integrator": integrator})
    start = np.concatenate([part.ravel() for part in poses])
    exact = solve_ivp(
        rates, (0.0, 2.0), start, "DOP853", np.linspace(0.0, 2.0, 5), rtol=1e-11, atol=1e-11
    ).y.T
    run = nrchain.simulate(case, positions=poses[0], frames=poses[1])
    assert run.status == "completed"
    assert np.abs(run.positions[-1] - poses[0]).max() > 0.5 * D
    assert run.positions.reshape(5, -1) == pytest.approx(exact[:, : 3 * N], abs=1e-7)
    assert run.frames.reshape(5, -1) == pytest.approx(exact[:, 3 * N :], abs=1e-7)


@pytest.mark.parametrize("neighbours", [1, 4, 9])
def test_a_straight_chain_falls_by_the_closed_form(neighbours):
    """V = f/6πηa (1 + 2 Σ_m ⟨mobility at md⟩), along the chain and across it."""
    m, force = np.arange(1, neighbours + 1), np.array([12.0, 0.0, -7.0])
    rho = m * D / A
    along, across = 1.5 / rho - 1.0 / rho**3, 0.75 / rho + 0.5 / rho**3
    mobilities = 1.0 + 2.0 * np.array([along.sum(), across.sum(), across.sum()])
    expected = mobilities * force / (6 * math.pi * ETA * A)
    case = scene(neighbours, {"force": force.tolist()}, **{"start.shape": "straight"})
    assert nrchain.steady_velocity(case) == pytest.approx(expected, rel=1e-13)
    run = nrchain.simulate(case)
    moved = (run.positions[-1] - run.positions[0]) / run.time[-1]
    assert moved == pytest.approx(np.tile(expected, (N, 1)), rel=1e-10)


@pytest.mark.parametrize("field", [{"force": [1.0, 0, 0]}, {"body_force": [0, 1.0, 0]}])
def test_all_pairs_are_refused_and_every_way_out_is_one(field):
    with pytest.raises(SceneError, match=r"has a net force.*has no sum") as caught:
        scene("all", field)
    assert caught.value.key == "field"
    for said, changes in {
        "a number for friction.neighbours": {"friction.neighbours": 3},
        "friction = 'one-body'": {"friction": "one-body"},
        "free or clamped ends": {"chain.ends": "free"},
        "clamped ends": {"chain.ends": "clamped"},
    }.items():
        assert said in caught.value.allowed
        table = {"friction": {"kind": "pairwise", "neighbours": "all"}, "chain": CHAIN}
        base = nrchain.load_scene(
            {**table, "run": {"end": 0.1, "snapshots": 2}, "elasticity": SLACK}
        )
        assert (
            nrchain.simulate(nrchain.load_scene(base, field=field, **changes)).status == "completed"
        )
    # torques alone have a sum: those of both sides cancel
    assert scene("all", {"torque": [1.0, 2.0, 3.0]})


@pytest.mark.parametrize(("field", "offered"), [({"torque": [0, 0, 1.0]}, True), (FIELD, False)])
def test_a_reach_that_is_refused_offers_all_pairs_where_they_have_a_sum(field, offered):
    with pytest.raises(SceneError, match="at most 100000") as caught:
        scene(100_001, field)
    assert caught.value.key == "friction.neighbours"
    assert ("'all'" in caught.value.allowed) is offered


@pytest.mark.parametrize(("field", "offered"), [({"torque": [0, 0, 1.0]}, True), (FIELD, False)])
def test_a_cut_that_gains_energy_offers_only_what_is_allowed(field, offered):
    near = {"chain.spacing": 2.02 * A, "chain.particles": 12}
    with pytest.raises(SceneError, match="not positive definite") as caught:
        nrchain.simulate(scene(1, field, **near))
    assert ("'all'" in caught.value.allowed) is offered
    holds = int(caught.value.allowed.partition(", which is enough here")[0].split()[-1])
    ways = [{"friction.neighbours": holds}] + offered * [{"friction.neighbours": "all"}]
    for way in ways:
        run = nrchain.simulate(scene(1, field, **near, **way, **{"run.end": 1e-3}))
        assert run.status == "completed"


def test_a_plan_of_such_a_chain_judges_its_cut_and_offers_no_other():
    lines = {
        line.quantity: line
        for line in nrchain.plan.plan(
            scene(
                2, **{"elasticity": {"bend": 900.0, "twist": 900.0, "stretch": 3.0, "shear": 3.0}}
            )
        ).lines
    }
    assert "left out" in lines["reach of friction"].value
    for line in lines.values():
        assert "'all'" not in line.meaning
