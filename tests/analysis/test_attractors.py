"""Each kind of attractor, on chains whose end is known by other means."""

import math

import numpy as np

import nrchain
from nrchain import measure
from nrchain.analysis.measure.attractors.alignment import distances
from nrchain.states.relative import RelativeChain


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
