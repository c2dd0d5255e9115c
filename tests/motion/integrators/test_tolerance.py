"""Error against tolerance: what a step is allowed, and what is left of it at the end of a run.

Free spheres in a flow forget nothing: every step leaves its error. What their paths are is known
without charts, from plain positions and one angle, by an explicit scheme of order 8.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from support.stepping import angles, small

import nrchain
from nrchain.motion.integrators import INTEGRATORS, find_integrator
from nrchain.motion.model import Model
from nrchain.scene.poses import initial_poses

NAMES = list(INTEGRATORS)
SLACK = {"stretch": 0.0, "shear": 0.0, "twist": 0.0, "bend": 0.0}
RATE = 0.5
SHEAR = [[0.0, RATE, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
START = np.array([[0.0, 0.0, 0.0], [10.0, 3.0, 0.0]])


def sheared(end, integrator="cvode", tolerance=1e-7, **changes):
    table = {
        "chain": {"particles": 2},
        "elasticity": SLACK,
        "flow": {"gradient": SHEAR},
        "run": {"end": end, "snapshots": 3, "integrator": integrator},
    }
    keys = {"run.rtol": tolerance, "run.atol": tolerance}
    return nrchain.load_scene(table, **keys, **changes)


def unturned(count):
    return np.broadcast_to(np.eye(3), (count, 3, 3)).copy()


@cache
def path_of_pair(end):
    """Positions (2, 3) and angles about z (2,) at the end, without charts."""
    model, frames = Model(sheared(end)), unturned(2)

    def rates(time, state):
        twists = model.twists(state[:6].reshape(2, 3).copy(), frames)
        return np.concatenate([twists[:, :3].ravel(), twists[:, 5]])

    start = np.concatenate([START.ravel(), np.zeros(2)])
    last = solve_ivp(rates, (0.0, end), start, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return last[:6].reshape(2, 3), last[6:]


def errors_of_pair(end, integrator, tolerance):
    """Largest error along the flow, across it, and of a frame."""
    run = nrchain.simulate(sheared(end, integrator, tolerance), positions=START, frames=unturned(2))
    positions, turned = path_of_pair(end)
    frames = Rotation.from_euler("z", turned[:, None]).as_matrix().transpose(0, 2, 1)
    off = np.abs(run.positions[-1] - positions).max(axis=0)
    return off[0], max(off[1:]), float(angles(run.frames[-1], frames).max())


@pytest.mark.parametrize("end", [20.0, 200.0, 2000.0])
@pytest.mark.parametrize("name", NAMES)
def test_a_pair_in_shear_is_off_by_tens_of_tolerances_times_the_shear(name, end):
    """δx = γ t δy is the flow's: it carries two spheres that are δy apart by that much."""
    tolerance = 1e-7
    along, across, frame = errors_of_pair(end, name, tolerance)
    assert across < 60 * tolerance
    assert along < 60 * tolerance * (1.0 + RATE * end)
    assert frame < 100 * tolerance


@pytest.mark.parametrize("name", NAMES)
def test_its_error_is_in_proportion_to_the_tolerance(name):
    tolerances = np.array([1e-5, 1e-7, 1e-9]) / find_integrator(name).share
    errors = [errors_of_pair(200.0, name, tolerance)[0] for tolerance in tolerances]
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert 0.7 < slope < 1.35


@pytest.mark.parametrize("name", NAMES)
def test_a_straight_path_is_exact_however_the_spheres_turn(name):
    """Lines in a shear without disturbance, while torques of their own turn them across e₁."""
    count, end, tolerance = 4, 60.0, 1e-6
    rng = np.random.default_rng(5)
    positions = 5.0 * rng.standard_normal((count, 3))
    frames = Rotation.random(count, random_state=5).as_matrix().transpose(0, 2, 1).copy()
    case = sheared(
        end,
        name,
        tolerance,
        **{"chain.particles": count, "flow.disturbance": False, "field.body_torque": [9, 20, -14]},
    )
    run = nrchain.simulate(case, positions=positions, frames=frames)
    expected = positions + end * positions @ np.array(SHEAR).T
    assert np.abs(run.positions[-1] - expected).max() < 10 * tolerance
    # they have turned against their bases, and charts have been left
    assert name == "radau" or run.counters["restarts"] > 3


TUMBLING = {
    "chain.particles": 4,
    "chain.spacing": 4.0,
    "elasticity": {"stretch": 50.0, "shear": 50.0, "twist": 3000.0, "bend": 3000.0},
    "start": {"shape": "random", "amplitude": 0.2},
}


@cache
def exact_tumbling():
    return nrchain.simulate(sheared(200.0, "radau", 1e-10, **TUMBLING))


@pytest.mark.parametrize(("name", "share"), [("cvode", 2000), ("radau", 5), ("scipy-bdf", 2000)])
def test_a_chain_that_tumbles_does_not_lever_errors_of_turning(name, share):
    """Twenty half turns of a chain of four; what is left is a lag of all of it."""
    run = nrchain.simulate(sheared(200.0, name, **TUMBLING))
    apart = np.linalg.norm(run.positions[-1] - exact_tumbling().positions[-1], axis=-1).max()
    assert apart < share * 1e-7


@pytest.mark.parametrize("name", NAMES)
def test_the_centre_of_a_free_passive_chain_rests_to_rounding(name):
    """Internal forces add up to nothing, and positions are coordinates: the sum is linear."""
    scene = small("passive", 6, 100.0, **{"chain.ends": "free", "start.amplitude": 1.0})
    keys = {"run.integrator": name, "run.rtol": 1e-4, "run.atol": 1e-4}
    run = nrchain.simulate(nrchain.load_scene(scene, **keys))
    centre = initial_poses(scene)[0].mean(axis=0)
    assert np.abs(run.positions.mean(axis=1) - centre).max() < 1e-8


@pytest.mark.parametrize("name", nrchain.scene_names())
def test_shipped_scenes_end_within_hundreds_of_tolerances(name):
    """The error that docs/accuracy.md states, at the default tolerances, against Radau IIA."""
    scene = nrchain.load_scene(name)
    run = nrchain.simulate(scene)
    keys = {"run.integrator": "radau", "run.rtol": 1e-9, "run.atol": 1e-9}
    exact = nrchain.simulate(nrchain.load_scene(scene, **keys))
    apart = np.linalg.norm(run.positions - exact.positions, axis=-1).max() / scene.chain.radius
    assert apart < 500 * scene.run.atol
    assert angles(run.frames, exact.frames).max() < 50 * scene.run.atol


@pytest.mark.parametrize("name", NAMES)
def test_a_run_of_free_spheres_goes_on_with_the_same_bits(name, tmp_path):
    """The bases of each sphere are found again from the poses of its last checkpoint."""
    frames = Rotation.random(2, random_state=5).as_matrix().transpose(0, 2, 1).copy()
    torque = {"field.body_torque": [9, 20, -14]}
    whole = nrchain.simulate(sheared(60.0, name, **torque), positions=START, frames=frames)
    half = {"run.max_steps": int(0.7 * whole.counters["steps"])}
    path = tmp_path / "run.h5"
    scene = sheared(60.0, name, **torque, **half)
    begun = nrchain.simulate(scene, positions=START, frames=frames, output=path)
    assert begun.status == "stopped"
    assert name == "radau" or begun.counters["restarts"] >= 2
    done = nrchain.resume(path)
    assert done.status == "completed"
    assert np.array_equal(done.positions[-1], whole.positions[-1])
    assert np.array_equal(done.frames[-1], whole.frames[-1])
