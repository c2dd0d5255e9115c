"""The charted ODE against the motion it stands for, and its Jacobian against differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.configurations import ENDS, MODULI, each
from support.poses import random_chain

import nrchain
from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model

MODES = {"2s": 3.0, "3a": 2.0, "3t": -4.0, "4a": {"strength": 5.0, "axis": [0.0, 1.0, 1.0]}}


def scene(
    ends="free", count=6, slip=MODES, neighbours=1, moduli=MODULI, friction="one-body", **run
):
    return nrchain.load_scene(
        {
            "chain": {"particles": count, "spacing": 4.0, "ends": ends},
            "elasticity": moduli,
            "slip": {"neighbours": neighbours, **slip},
            "friction": friction,
            "run": {"end": 1.0, **run},
        }
    )


def charted(scene, seed=0):
    """A chart with moving bases, and a point of it away from the origin."""
    model = Model(scene)
    chain = ChartedChain(model)
    rng = np.random.default_rng(seed)
    moves = 0.0 if model.held.any() else 1.0
    poses = random_chain(model.count, spacing=4.0, seed=seed)
    chain.set_base(0.2, *poses, moves * rng.standard_normal(3), moves * 0.7)
    return chain, 0.3 * rng.standard_normal(chain.dimension)


def rates(chain, time, y):
    out = np.empty(chain.dimension)
    chain.rates(time, y, out)
    return out


@each(lambda c: c.effect is None and c.radius == 1.0)
def test_jacobian_against_differences(configuration):
    chain, y = charted(configuration.scene())
    chain.linearise(0.6, y)
    step = 1e-5
    numeric = np.stack(
        [
            (rates(chain, 0.6, y + step * e) - rates(chain, 0.6, y - step * e)) / (2 * step)
            for e in np.eye(chain.dimension)
        ],
        axis=1,
    )
    assert chain.jacobian() == pytest.approx(numeric, abs=1e-8 * np.abs(numeric).max())


@pytest.mark.parametrize("ends", ENDS)
def test_rates_are_the_motion_of_the_poses(ends):
    chain, y = charted(scene(ends))
    time, step = 0.9, 1e-6
    ydot = rates(chain, time, y)
    positions, frames = (array.copy() for array in chain.poses(time, y))
    twists = chain.model.twists(positions, frames)
    ahead = [array.copy() for array in chain.poses(time + step, y + step * ydot)]
    behind = [array.copy() for array in chain.poses(time - step, y - step * ydot)]
    velocity = (ahead[0] - behind[0]) / (2 * step)
    turning = (ahead[1] - behind[1]) / (2 * step)
    assert velocity == pytest.approx(twists[:, :3], abs=1e-8)
    assert turning == pytest.approx(np.cross(twists[:, None, 3:], frames), abs=1e-8)


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("count", [2, 3, 4, 7])
def test_solve_inverts_the_newton_matrix(ends, count):
    chain, y = charted(scene(ends, count))
    if chain.dimension == 0:
        return
    chain.linearise(0.0, y)
    chain.factorise(0.01)
    right = np.random.default_rng(1).standard_normal(chain.dimension)
    out = np.empty_like(right)
    chain.solve(right, out)
    newton = np.eye(chain.dimension) - 0.01 * chain.jacobian()
    assert newton @ out == pytest.approx(right, abs=1e-12)


def test_clamped_spheres_have_no_coordinates_and_keep_their_pose():
    chain, y = charted(scene("clamped"))
    assert chain.dimension == 6 * 4
    positions, frames = chain.poses(5.0, y)
    assert np.array_equal(positions[[0, -1]], chain.base_positions[[0, -1]])
    assert np.array_equal(frames[[0, -1]], chain.base_frames[[0, -1]])


def test_rebasing_keeps_the_poses_and_orthonormalises():
    chain, y = charted(scene())
    positions, frames = (array.copy() for array in chain.poses(0.5, y))
    frames[0] *= 1 + 1e-9
    chain.rebase(0.5, positions, frames)
    again = chain.poses(0.5, np.zeros(chain.dimension))
    # kept about an origin of their own: one rounding there and one back
    assert again[0] == pytest.approx(positions, rel=0, abs=2e-16 * np.abs(positions).max())
    assert again[1][1:] == pytest.approx(frames[1:], abs=1e-15)
    gram = np.einsum("nak,nbk->nab", again[1], again[1])
    assert np.abs(gram - np.eye(3)).max() < 1e-15


def test_bases_follow_a_chain_that_swims_and_spins():
    straight = scene(slip={"3t": 100.0, "4a": 300.0}, count=8, moduli=dict.fromkeys(MODULI, 1.0))
    chain = ChartedChain(Model(straight))
    positions = 4.0 * np.arange(8.0)[:, None] * [1.0, 0, 0]
    frames = np.broadcast_to(np.eye(3), (8, 3, 3)).copy()
    chain.rebase(0.0, positions, frames)
    # the inner spheres feel two neighbours, those at the ends one
    share = 7 / 8
    assert chain.drift[0] == pytest.approx(share * 4 / 5 * 100 / 4.0**3)
    assert chain.spin == pytest.approx(-share * 363 / 5 * 300 / 4.0**5)


def free_spheres():
    """Spheres without elasticity, each turned in its own way by a flow, slip and its own torque."""
    slack = dict.fromkeys(MODULI, 0.0)
    return nrchain.load_scene(
        scene(slip={"4a": {"strength": 50.0, "axis": [0.0, 1.0, 1.0]}}, moduli=slack),
        flow={"gradient": [[0.0, 0.3, 0.1], [0.0, 0.1, 0.4], [0.2, -0.3, -0.1]]},
        field={"force": [1.0, 2.0, 3.0], "body_torque": [3.0, -5.0, 4.0]},
        steric={"kind": "harmonic", "strength": 5.0, "range": 4.0},
    )


def test_bases_of_free_spheres_turn_as_each_of_them_does():
    # what spheres do to the flow is not what carries them
    undisturbed = nrchain.load_scene(free_spheres(), **{"flow.disturbance": False})
    chain, _ = charted(undisturbed)
    chain.rebase(0.3, *random_chain(6, spacing=4.0))
    still = np.zeros(chain.dimension)
    assert rates(chain, 0.3, still).reshape(-1, 6)[:, 3:] == pytest.approx(0.0, abs=1e-14)
    twists = chain.model.twists(chain.base_positions, chain.base_frames)
    assert np.linalg.norm(twists[:, 3:], axis=1).min() > 0.05
    # at rest in the chart they turn as rigid bodies do, by the exponential of their spin
    later = chain.poses(1.7, still)[1].copy()
    spins = chain.model.carrying_twists(chain.base_positions, chain.base_frames)[:, 3:]
    for before, after, spin in zip(chain.base_frames, later, spins, strict=True):
        assert after == pytest.approx(Rotation.from_rotvec(1.4 * spin).apply(before), abs=1e-13)


def test_motion_and_jacobian_about_bases_of_free_spheres():
    chain, y = charted(free_spheres())
    time, step = 0.9, 1e-6
    ydot = rates(chain, time, y)
    positions, frames = (array.copy() for array in chain.poses(time, y))
    twists = chain.model.twists(positions, frames)
    ahead = [array.copy() for array in chain.poses(time + step, y + step * ydot)]
    behind = [array.copy() for array in chain.poses(time - step, y - step * ydot)]
    assert (ahead[0] - behind[0]) / (2 * step) == pytest.approx(twists[:, :3], abs=1e-8)
    turning = (ahead[1] - behind[1]) / (2 * step)
    assert turning == pytest.approx(np.cross(twists[:, None, 3:], frames), abs=1e-8)

    chain.linearise(time, y)
    step = 1e-5
    units = step * np.eye(chain.dimension)
    numeric = [(rates(chain, time, y + e) - rates(chain, time, y - e)) / (2 * step) for e in units]
    numeric = np.array(numeric).T
    assert chain.jacobian() == pytest.approx(numeric, abs=1e-8 * np.abs(numeric).max())


@pytest.mark.parametrize(
    ("changes", "tied"),
    [
        ({}, True),
        ({"elasticity": dict.fromkeys(MODULI, 0.0)}, False),
        ({"elasticity": dict.fromkeys(MODULI, 0.0) | {"stretch": 1.0}}, True),
        ({"elasticity": dict.fromkeys(MODULI, 0.0), "field": {"body_torque": [1, 0, 0]}}, False),
    ],
)
def test_frames_are_tied_by_what_turns_spheres_against_each_other(changes, tied):
    assert Model(nrchain.load_scene(scene(), **changes)).ties_frames is tied


def test_a_base_is_outrun_by_more_than_the_chain_is_long():
    chain, _ = charted(scene())
    shifts = np.zeros((6, 6))
    extent = np.ptp(chain.base_positions, axis=0).max()
    shifts[:, 1] = 0.9 * extent
    assert not chain.has_outrun_base(shifts.ravel())
    shifts[:, 1] = 1.1 * extent
    assert chain.has_outrun_base(shifts.ravel())
    # a chain that is drawn out grows with its displacements
    shifts[:, 1] = np.linspace(-50.0, 50.0, 6) * extent
    assert not chain.has_outrun_base(shifts.ravel())
    clamped, _ = charted(scene("clamped"))
    assert not clamped.has_outrun_base(1e3 * np.ones(clamped.dimension))
