"""Tension and moment of straight chains against sums, simulated chains and closed forms."""

import math
from itertools import product

import numpy as np
import pytest
from support.graded_chains import HALVES, UNITS, graded, opposed
from support.selection import few_of

import nrchain
from nrchain.motion.model import Model
from nrchain.theory.line_loads import line_loads


def carried(run, scene):
    """The tension and moment of each link from the poses alone, by the energy of the paper.

    σ = λ∥ d (C₁r − 1): a link of four spheres pulls with 26/24 of σ at itself and −1/24 of it at
    the links beside it, the first and last link of an open chain with σ.
    """
    x, d, moduli = run.positions[-1, :, 0], scene.chain.spacing, scene.moduli
    periodic = scene.chain.ends == "periodic"
    lengths = np.append(np.diff(x), x[0] + scene.length - x[-1]) if periodic else np.diff(x)
    wide = np.ones(len(lengths), bool)
    if not periodic:
        wide[[0, -1]] = False
    beside = np.roll(lengths, 1) + np.roll(lengths, -1)
    strain = np.where(wide, (26.0 * lengths - beside) / 24.0, lengths) / d - 1.0
    stress = moduli.stretch * d * strain
    passed_on = np.where(wide, stress, 0.0) / 24.0
    tension = np.where(wide, 26.0 / 24.0, 1.0) * stress
    tension[1:] -= passed_on[:-1]
    tension[:-1] -= passed_on[1:]
    if periodic:
        tension[0] -= passed_on[-1]
        tension[-1] -= passed_on[0]
    e2, e3 = run.frames[-1, :, 1], run.frames[-1, :, 2]
    angles = np.arctan2(e2[:, 2], e2[:, 1])
    turns = (np.roll(angles, -1) - angles)[: len(lengths)]
    turns = (turns + math.pi) % (2.0 * math.pi) - math.pi
    assert np.allclose(np.cross(e2, e3)[:, 0], 1.0)
    return tension, moduli.twist * np.sin(turns) * np.cos(turns)


def test_opposed_halves_press_on_the_links_between_them():
    """(2/5)(a/d)³ V by each neighbour: one of the first sphere, two of six, none of the eighth."""
    found = line_loads(opposed(6.0))
    pushed = 6.0 * math.pi * 0.4 / 1e3 * 500.0
    # a sphere swims by both neighbours; at the cut each side is slowed by the other's first sphere
    velocity = np.array([sum(HALVES[j] for j in (i - 1, i + 1) if 0 <= j < 16) for i in range(16)])
    by_hand = -np.cumsum(6.0 * math.pi * 0.4 / 1e3 * velocity)[:15]
    assert found.tension == pytest.approx(by_hand)
    assert found.tension[7] == pytest.approx(-13.0 * pushed)
    assert found.velocity == pytest.approx([0.0, 0.0, 0.0], abs=1e-15)


def test_links_that_give_way_a_little_carry_a_little_more():
    """−49.0 at rest length; at λ∥ = 500 spheres 1 % nearer each other push by 49.7."""
    scene = opposed(500.0)
    tension, _ = carried(nrchain.simulate(scene), scene)
    assert tension[7] == pytest.approx(-49.7, abs=0.05)
    assert line_loads(scene).tension[7] == pytest.approx(-49.0, abs=0.05)


@pytest.mark.parametrize(
    ("ends", "friction"),
    few_of(
        product(["free", "clamped", "periodic"], ["one-body", "pairwise"]),
        {("clamped", "one-body"), ("periodic", "pairwise")},
    ),
)
def test_loads_are_those_of_simulated_chains_as_they_become_stiff(ends, friction):
    """Ten times the stiffness gives a tenth of the strain, and of the difference."""
    off = []
    for stiffness in (1e3, 1e4):
        scene = graded(ends, friction, stiffness)
        found = line_loads(scene)
        tension, moment = carried(nrchain.simulate(scene), scene)
        off.append(
            [
                np.abs(tension - found.tension).max() / np.abs(found.tension).max(),
                np.abs(moment - found.moment).max() / np.abs(found.moment).max(),
            ]
        )
    assert max(off[0]) < 0.2
    assert np.divide(*off) == pytest.approx([10.0, 10.0], rel=0.2)


@pytest.mark.parametrize("friction", ["one-body", "pairwise"])
@pytest.mark.parametrize("ends", ["free", "periodic"])
def test_a_chain_swims_and_spins_by_the_sum_of_what_acts_on_it(ends, friction):
    scene = graded(ends, friction, 1e5)
    found = line_loads(scene)
    run = nrchain.simulate(scene)
    twists = Model(scene).twists(run.positions[-1], run.frames[-1])
    assert np.ptp(twists[:, 0]) < 1e-5 * abs(found.velocity[0])
    assert twists[:, 0].mean() == pytest.approx(found.velocity[0], rel=1e-2)
    assert twists[:, 3].mean() == pytest.approx(found.spin, rel=1e-2)


@pytest.mark.parametrize("ends", ["free", "periodic", "clamped"])
def test_a_force_across_moves_what_is_not_held_by_its_drag(ends):
    """V = F/6πηa of every sphere; clamped ends hold a chain that a force along it pulls."""
    force = [0.0, 2.0, -3.0] if ends != "clamped" else [2.0, 0.0, 0.0]
    units = {"radius": 0.5, "spacing": 7.0, "viscosity": 0.2, "ends": ends, "particles": 8}
    scene = nrchain.load_scene({"chain": units, "field.force": force, "run.end": 1.0})
    drag = 6.0 * math.pi * 0.2 * 0.5
    moved = np.zeros(3) if ends == "clamped" else np.array(force) / drag
    assert line_loads(scene).velocity == pytest.approx(moved, abs=1e-13)


def test_a_stretching_flow_pulls_as_a_parabola():
    """T_i = γ_T G d (i + 1)(N − 1 − i)/2: the drag of either side, relative to the middle."""
    rate = 0.01
    flow = {"flow": {"gradient": np.diag([rate, -rate / 2, -rate / 2]).tolist()}}
    scene = nrchain.load_scene(
        "passive", **UNITS, **flow, **{"chain.ends": "free", "flow.disturbance": False}
    )
    count, drag = scene.chain.particles, scene.drag.translation
    i = np.arange(count - 1)
    expected = drag * rate * 8.0 * (i + 1) * (count - 1 - i) / 2
    assert line_loads(scene).tension == pytest.approx(expected)


def test_an_endless_uniform_ring_carries_nothing():
    """All spheres have equal forces: the active stress strains no link."""
    found = line_loads(nrchain.load_scene("buckling", **{"chain.ends": "periodic"}, **UNITS))
    assert found.tension == pytest.approx(np.zeros(20), abs=1e-12)
    free = line_loads(nrchain.load_scene("buckling", **{"chain.ends": "free"}))
    assert free.tension == pytest.approx(np.full(19, 6 * math.pi * 7 / 3), rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"slip.4a": 100.0, "slip.4a.axis": [1.0, 1.0, 0.0]}, "slip"),
        ({"field.torque": [0.0, 1.0, 0.0]}, "field"),
        ({"field.force": [0.0, 1.0, 0.0], "friction": "pairwise"}, "field"),
        ({"flow.gradient": [[0, 0.1, 0], [0, 0, 0], [0, 0, 0]], "chain.ends": "free"}, "flow"),
    ],
)
def test_what_bends_a_straight_chain_is_named(changes, key):
    with pytest.raises(nrchain.SceneError, match="does not stay straight") as refused:
        line_loads(nrchain.load_scene("passive", **changes))
    assert refused.value.key.startswith(key)
