"""``nrchain.flow``: the fluid about a chain, against the motion of its spheres."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, ClassVar

import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneError
from nrchain.hydrodynamics import lamb
from nrchain.motion.model import Model
from nrchain.scene.poses import initial_poses

EVERYTHING = {
    "chain.particles": 5,
    "chain.radius": 1.3,
    "chain.viscosity": 0.7,
    "chain.ends": "free",
    "friction": "pairwise",
    "slip.neighbours": "all",
    "slip.finite_size": True,
    "slip.2s": 40.0,
    "slip.3a": [3.0, -2.0, 1.0, 5.0, 4.0],
    "slip.3t": {"strength": 11.0, "axis": [0.0, 1.0, 0.5]},
    "slip.4a": 200.0,
    "flow.gradient": [[0.0, 0.3, -0.1], [0.0, 0.2, 0.4], [0.0, -0.3, -0.2]],
    "flow.finite_size": True,
    "field": {"force": [1.0, -2.0, 3.0], "body_torque": [4.0, 5.0, -2.0]},
    "steric": {"kind": "wca", "strength": 50.0},
    "start.shape": "random",
    "start.amplitude": 0.8,
}

LEVI_CIVITA = np.zeros((3, 3, 3))
LEVI_CIVITA[[0, 1, 2], [1, 2, 0], [2, 0, 1]] = 1.0
LEVI_CIVITA[[0, 1, 2], [2, 0, 1], [1, 2, 0]] = -1.0


def scene(**changes):
    return nrchain.load_scene("passive", **{**EVERYTHING, **changes})


def surface_motion(given, sphere):
    """v = ⟨u⟩ and ω = (3/2a)⟨n × u⟩ over the surface of a sphere."""
    normals, weights = lamb.sphere_grid(10)
    centre, a = initial_poses(given)[0][sphere], given.chain.radius
    u = nrchain.flow(given, centre + a * normals).velocity
    return np.concatenate([weights @ u, 1.5 / a * weights @ np.cross(normals, u)])


@pytest.mark.parametrize("ends", ["free", "clamped", "periodic"])
def test_the_fluid_at_a_sphere_moves_as_the_sphere_does_on_average(ends):
    """With all that the model has, sphere and fluid agree: Faxén's laws, in every effect."""
    field = {"body_torque": [4.0, 5.0, -2.0]}
    if ends != "periodic":
        field["force"] = [1.0, -2.0, 3.0]
    given = scene(**{"chain.ends": ends, "field": field})
    twists = Model(given).twists(*initial_poses(given))
    size = np.abs(twists).max()
    for sphere in range(given.chain.particles):
        assert np.abs(surface_motion(given, sphere) - twists[sphere]).max() <= 1e-9 * size


@pytest.mark.parametrize("ends", ["free", "periodic"])
@pytest.mark.parametrize("part", ["slip", "torques", "background", None])
def test_vorticity_is_the_curl_of_the_velocity(ends, part):
    """Against central differences, near spheres, beyond the last one and over the seam."""
    given = scene(**{"chain.ends": ends, "field": {"body_torque": [4.0, 5.0, -2.0]}})
    positions, step = initial_poses(given)[0], 1e-3
    points = positions + np.array([[3.0, 2.0, -1.5]]) * np.array(
        [[1.0], [-1.0], [2.0], [1.0], [3.0]]
    )
    shifts = step * np.concatenate([np.eye(3), -np.eye(3)])
    chosen = None if part is None else [part]
    u = nrchain.flow(given, points[:, None] + shifts, parts=chosen).velocity
    gradient = (u[:, :3] - u[:, 3:]) / (2.0 * step)  # [point, j, i]: of u_i along j
    curl = np.einsum("kji,pji->pk", LEVI_CIVITA, gradient)
    found = nrchain.flow(given, points, parts=chosen).vorticity
    assert np.abs(found).max() > 0.0
    assert np.abs(found - curl).max() <= 1e-5 * np.abs(gradient).max()


def test_parts_add_up():
    given, points = scene(), np.random.default_rng(1).uniform(-30, 30, (4, 5, 3))
    whole = nrchain.flow(given, points)
    parts = [
        nrchain.flow(given, points, parts=[part])
        for part in ("slip", "forces", "torques", "background")
    ]
    assert whole.velocity.shape == whole.vorticity.shape == (4, 5, 3)
    for name in ("velocity", "vorticity"):
        total, found = sum(getattr(part, name) for part in parts), getattr(whole, name)
        assert np.abs(total - found).max() <= 1e-12 * np.abs(found).max()


def test_a_mode_of_ones_own_has_its_flow():
    """A potential flow −∇Φ/4π has no finite-size part: u of the table, and no vorticity."""
    mode = nrchain.SlipMode(
        "4p",
        "potential quadrupole",
        4,
        False,
        False,
        {("n", 4): ("-1/2", 0, "5/2"), ("e", 4): (0, -1)},
    )
    nrchain.register(mode)
    try:
        given = nrchain.load_scene(
            "passive", **{"chain.particles": 2, "chain.radius": 2.0, "slip.4p": [3.0, 0.0]}
        )
        points = np.array([[4.0, 5.0, -2.0], [-1.0, 3.0, 6.0]])
        found = nrchain.flow(given, points, parts=["slip"])
        r = np.linalg.norm(points, axis=1)[:, None]
        n, c = points / r, points[:, :1] / r
        expected = 3 * (2 / r) ** 4 * ((2.5 * c**2 - 0.5) * n - c * [1.0, 0, 0])
        assert np.abs(found.velocity - expected).max() <= 1e-14
        assert np.abs(found.vorticity).max() <= 1e-14
        assert mode.exterior_flow()["n", 4] == (Fraction(-1, 2), 0, Fraction(5, 2))
    finally:
        nrchain.slip_modes.unregister("4p")


def test_a_trajectory_has_the_flow_of_its_snapshots():
    trajectory = nrchain.simulate(scene(**{"run.end": 0.02, "run.snapshots": 3}))
    points = [[10.0, 3.0, 4.0]]
    first, last = (nrchain.flow(trajectory, points, frame=k).velocity for k in (0, -1))
    assert np.array_equal(first, nrchain.flow(trajectory.scene, points).velocity)
    assert np.array_equal(last, nrchain.flow(trajectory, points).velocity)
    assert np.array_equal(last, nrchain.flow(trajectory[-1], points).velocity)
    assert not np.array_equal(first, last)


def test_a_net_force_on_a_periodic_chain_is_refused_with_what_to_do():
    given = scene(**{"chain.ends": "periodic", "friction": "one-body"})
    with pytest.raises(SceneError, match=r"net force \(field\).*'slip', 'torques', 'background'"):
        nrchain.flow(given, [[0.0, 5.0, 0.0]])
    rest = nrchain.flow(given, [[0.0, 5.0, 0.0]], parts=("slip", "torques", "background"))
    assert np.isfinite(rest.velocity).all()


def test_an_effect_whose_flow_is_not_known_is_named():
    @dataclass(frozen=True, slots=True, kw_only=True)
    class DriftSpec(nrchain.Section):
        path: ClassVar[str] = "drift"
        speed: Annotated[float, nrchain.rules.number()] = 0.0

    class Drift(nrchain.OneBodyEffect):
        name = "drift"
        Section = DriftSpec
        summary = "one velocity"
        equation = "v = 1"
        gives = "twist"

        def add_twists(self, positions, frames, twists):
            twists[:, 0] += 1.0

        def derivative(self, positions, frames):
            return np.zeros((len(positions), 6, 6))

    nrchain.register_effect(Drift)
    try:
        given = scene(drift={"speed": 1.0})
        assert nrchain.flow(given, [[0.0, 9.0, 0.0]]).left_out == ("drift",)
    finally:
        nrchain.unregister_effect("drift")
    assert nrchain.flow(scene(), [[0.0, 9.0, 0.0]]).left_out == ()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"points": [[1.0, 2.0]]}, "points.*shape must be"),
        ({"points": [[1.0, 2.0, np.nan]]}, "finite"),
        ({"points": 3.0}, "points"),
        ({"parts": ["slips"]}, "did you mean 'slip'"),
        ({"parts": "slip"}, "must be a list"),
        ({"frame": 3}, "one pose"),
        ({"accuracy": -1.0}, "accuracy"),
        ({"source": "buckling"}, "must be a Scene, a Trajectory or a Snapshot"),
    ],
)
def test_bad_input_is_refused(changes, message):
    given = {"source": scene(), "points": [[0.0, 9.0, 0.0]]} | changes
    with pytest.raises(SceneError, match=message):
        nrchain.flow(given.pop("source"), given.pop("points"), **given)


def test_a_snapshot_that_is_not_there_is_refused():
    trajectory = nrchain.simulate(scene(**{"run.end": 0.01, "run.snapshots": 2}))
    with pytest.raises(SceneError, match="there are 2 snapshots"):
        nrchain.flow(trajectory, [[0.0, 9.0, 0.0]], frame=2)
