"""Held and pushed spheres in a flow: the warning states what one-body friction leaves out."""

import math

import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneWarning
from nrchain.motion.model import Model
from nrchain.planning.choice import Choice
from nrchain.planning.regime import warnings

RADIUS, VISCOSITY, D, COUNT, RATE = 1.3, 0.7, 8.0, 5, 0.2
EXTENSION = np.diag([RATE, -RATE / 2, -RATE / 2])
SLACK = {"stretch": 0.0, "shear": 0.0, "twist": 0.0, "bend": 0.0}
HELD = {"chain.ends": "clamped"}
PUSHED = {"field.force": [20.0, 0.0, 0.0]}
GAMMA = 6 * math.pi * VISCOSITY * RADIUS


def make(**changes):
    chain = {"particles": COUNT, "spacing": D, "radius": RADIUS, "viscosity": VISCOSITY}
    base = {"chain": chain, "elasticity": SLACK, "run": {"end": 0.1, "snapshots": 2}}
    return nrchain.load_scene(base, **changes)


def stokeslet_warnings(scene):
    return [text for text in warnings(scene) if "one-body friction drops" in text]


@pytest.mark.parametrize("cause", [HELD, PUSHED], ids=["held", "pushed"])
def test_held_and_pushed_spheres_are_warned_of_until_the_advice_is_followed(cause):
    scene = make(**cause, **{"flow.gradient": EXTENSION})
    (text,) = stokeslet_warnings(scene)
    assert "friction = 'pairwise' keeps both" in text
    with pytest.warns(SceneWarning, match="one-body friction drops"):
        nrchain.simulate(scene)
    mended = nrchain.load_scene(scene, friction="pairwise")
    assert not stokeslet_warnings(mended)
    nrchain.simulate(mended)


@pytest.mark.parametrize("cause", [HELD, PUSHED], ids=["held", "pushed"])
def test_the_advice_brings_what_a_sum_of_stokeslets_says(cause):
    """Along x: μ = (3a/2r − a³/r³)/γ between spheres of finite size, written out independently."""
    flow = {"flow.gradient": EXTENSION}
    x = D * np.arange(COUNT)
    gaps = x[:, None] - x
    r = np.where(np.eye(COUNT, dtype=bool), np.inf, np.abs(gaps))
    mobility = (1.5 * RADIUS / r - RADIUS**3 / r**3) / GAMMA + np.eye(COUNT) / GAMMA
    strain = -2.5 * RADIUS**3 * RATE * (np.sign(gaps) / r**2).sum(axis=1)
    carried = RATE * x + strain
    if cause is HELD:
        ends = [0, COUNT - 1]
        forces = np.zeros(COUNT)
        forces[ends] = np.linalg.solve(mobility[np.ix_(ends, ends)], -carried[ends])
    else:
        forces = np.full(COUNT, 20.0)
    positions, frames = x[:, None] * [1.0, 0.0, 0.0], np.tile(np.eye(3), (COUNT, 1, 1))
    with_friction = Model(make(**cause, **flow, friction="pairwise")).twists(positions, frames)
    without = Model(make(**cause, **flow)).twists(positions, frames)
    expected = carried + mobility @ forces
    assert with_friction[:, 0] == pytest.approx(expected, abs=1e-12)
    # it is larger than what one-body friction keeps
    assert np.abs(with_friction - without)[:, 0].max() > np.abs(strain).max()


@pytest.mark.parametrize(
    ("cause", "velocity"),
    [(PUSHED, 20.0 / GAMMA), (HELD, RATE * D * (COUNT - 1))],
    ids=["pushed", "held"],
)
def test_the_numbers_are_those_of_a_neighbour(cause, velocity):
    (text,) = stokeslet_warnings(make(**cause, **{"flow.gradient": EXTENSION}))
    dropped = 1.5 * RADIUS / D * velocity
    kept = 2.5 * RADIUS**3 / D**2 * RATE
    assert f"up to v = {dropped:.2g} at a neighbour and of order a/r" in text
    assert f"up to v = {kept:.2g} and of order (a/r)²" in text


def test_a_run_whose_effects_were_chosen_is_not_warned_of_what_the_choice_bounds():
    scene = make(**HELD, **{"flow.gradient": EXTENSION})
    choice = Choice(0.1, (), 0.0, 0.0, (), (), "chosen")
    assert nrchain.simulate(scene, choice=choice).status == "completed"


@pytest.mark.parametrize(
    "changes",
    [
        {"flow.gradient": EXTENSION},
        {"flow.gradient": EXTENSION, "field.torque": [1e3, 0.0, 0.0]},
        {"flow.gradient": EXTENSION, "field.force": [1e-3, 0.0, 0.0]},
        HELD | {"flow.gradient": EXTENSION, "flow.disturbance": False},
        HELD | {"slip.2s": 10.0},
        HELD | PUSHED,
        PUSHED | {"flow.gradient": EXTENSION, "friction": "pairwise"},
    ],
)
def test_nothing_is_said_where_nothing_larger_is_dropped(changes):
    assert not stokeslet_warnings(make(**changes))


def test_where_all_pairs_of_friction_would_drag_the_chain_the_advice_is_a_cut():
    shear = {"flow.gradient": [[0.0, 0.2, 0.0], [0.0] * 3, [0.0] * 3], "chain.ends": "periodic"}
    scene = make(**PUSHED, **shear)
    (text,) = stokeslet_warnings(scene)
    assert "friction.kind = 'pairwise' with a number for friction.neighbours keeps both" in text
    cut = {"friction.kind": "pairwise", "friction.neighbours": 3}
    mended = nrchain.load_scene(scene, **cut)
    assert not stokeslet_warnings(mended)
    assert nrchain.simulate(mended).status == "completed"
