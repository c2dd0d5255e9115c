"""Closed-form laws against the lattice: order of convergence as qd → 0, and absolute caps."""

from __future__ import annotations

import numpy as np
import pytest

from nrchain.errors import SceneError
from nrchain.scene.loading import load_scene
from nrchain.theory.lattice import Branch, lattice_rates, steady_rotation, steady_velocity
from nrchain.theory.rod import (
    MODES,
    Rod,
    longitudinal,
    optical,
    steady_motion,
    transverse,
    twisting,
)

STRENGTHS = {"2s": 100.0, "3a": 5000.0, "3t": 1000.0, "4a": 10000.0}
PHASES = np.array([0.02, 0.04, 0.08])
BENDING = {1: Branch.BEND_PLUS, -1: Branch.BEND_MINUS}


def scene(*modes, stiffness=1e12, **changes):
    table = {
        "chain.particles": 20,
        "run.end": 1.0,
        "elasticity.stretch": stiffness,
        "elasticity.shear": stiffness,
    }
    return load_scene(table | {f"slip.{mode}": STRENGTHS[mode] for mode in modes} | changes)


def assert_order(errors, order, cap):
    assert np.diff(np.log(errors)) / np.log(2.0) == pytest.approx(order, abs=0.05)
    assert errors[0] < cap


@pytest.mark.parametrize("hand", [1, -1])
@pytest.mark.parametrize(
    ("mode", "correction"), [("2s", 1 / 12), ("3a", 0.1663), ("3t", 4 / 300), ("4a", 0.2545)]
)
def test_bending_waves(mode, correction, hand):
    """Λ of a mode without bending stiffness: relative error ``correction`` (qd)²."""
    chain = scene(mode, **{"elasticity.bend": 0.0})
    law = transverse(Rod.of(chain), PHASES / 10.0, hand)
    exact = lattice_rates(chain, PHASES / 10.0)[:, BENDING[hand]]
    errors = np.abs(exact / law - 1.0)
    assert_order(errors, 2.0, 1.3 * correction * PHASES[0] ** 2)
    assert errors[0] > 0.7 * correction * PHASES[0] ** 2


@pytest.mark.parametrize("hand", [1, -1])
def test_passive_bending(hand):
    """Λ = −(κ_R/Γ^T) q⁴, and with the four-body links an error of second order all the same."""
    law = transverse(Rod.of(scene()), PHASES / 10.0, hand)
    exact = lattice_rates(scene(), PHASES / 10.0)[:, BENDING[hand]]
    assert_order(np.abs(exact / law - 1.0), 2.0, 5e-5)


def test_modes_add_up():
    chain = scene(*MODES)
    q = np.array([0.002])
    for hand, branch in BENDING.items():
        parts = sum(transverse(Rod.of(scene(mode)), q, hand) for mode in MODES)
        passive = transverse(Rod.of(scene()), q, hand)
        law = transverse(Rod.of(chain), q, hand)
        np.testing.assert_allclose(law, parts - 3 * passive, rtol=1e-13)
        np.testing.assert_allclose(lattice_rates(chain, q)[:, branch], law, rtol=1e-3)


@pytest.mark.parametrize(("mode", "order"), [("2s", 2), ("3t", 2)])
def test_longitudinal_active_waves(mode, order):
    chain = scene(mode, stiffness=0.0)
    law = longitudinal(Rod.of(chain), PHASES / 10.0)
    exact = lattice_rates(chain, PHASES / 10.0)[:, Branch.STRETCH]
    assert_order(np.abs(exact / law - 1.0), order, 1e-4)


@pytest.mark.parametrize("mode", MODES)
def test_longitudinal_passive_waves_and_twist(mode):
    """The stencils over four spheres make stretch exact to fourth order; twist is of second."""
    chain, rod = scene(mode, stiffness=50.0), Rod.of(scene(mode, stiffness=50.0))
    active = longitudinal(Rod.of(scene(mode, stiffness=0.0)), PHASES / 10.0)
    active_exact = lattice_rates(scene(mode, stiffness=0.0), PHASES / 10.0)[:, Branch.STRETCH]
    passive = longitudinal(rod, PHASES / 10.0) - active
    rates = lattice_rates(chain, PHASES / 10.0)
    assert_order(np.abs((rates[:, Branch.STRETCH] - active_exact) / passive - 1.0), 4.0, 5e-9)
    twist = np.abs(rates[:, Branch.TWIST] / twisting(rod, PHASES / 10.0) - 1.0)
    assert_order(twist, 2.0, 4e-5)


@pytest.mark.parametrize("mode", MODES)
def test_optical_gap(mode):
    chain = scene(mode, stiffness=50.0)
    rates = lattice_rates(chain, PHASES / 10.0)
    for hand, branch in ((1, Branch.SHEAR_PLUS), (-1, Branch.SHEAR_MINUS)):
        gap = optical(Rod.of(chain), hand)
        at_zero = lattice_rates(chain, 0.0)[branch]
        assert at_zero == pytest.approx(gap, rel=1e-13)
        assert np.all(np.abs(rates[:, branch] - gap) < 0.02 * abs(gap))


def test_steady_motion():
    chain = scene(*MODES)
    velocity, spin = steady_motion(Rod.of(chain))
    assert velocity == pytest.approx(steady_velocity(chain)[0], rel=1e-14)
    assert spin == pytest.approx(steady_rotation(chain)[0], rel=1e-14)


def test_hands_are_plus_or_minus_one():
    with pytest.raises(SceneError, match="hand"):
        transverse(Rod(), [0.1], 0)


@pytest.mark.parametrize(
    "changes",
    [{"field.body_torque": [1.0, 0.0, 0.0]}, {"flow.gradient": [[0, 1, 0], [0, 0, 0], [0, 0, 0]]}],
)
def test_the_theory_refuses_effects_that_it_does_not_cover(changes):
    (key,) = changes
    with pytest.raises(SceneError, match=rf"{key.partition('.')[0]}.* not part of the theory"):
        Rod.of(scene(**changes))
    repelling = {"steric.kind": "wca", "steric.strength": 1.0}
    assert Rod.of(scene(**repelling)) == Rod.of(scene())
