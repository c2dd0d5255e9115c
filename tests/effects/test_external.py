"""Uniform fields and background flows against motions that are known in closed form."""

import numpy as np
import pytest
from support.poses import random_chain

import nrchain
from nrchain.effects.registry import acting
from nrchain.errors import SceneError
from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model

SLACK = {"stretch": 0.0, "shear": 0.0, "twist": 0.0, "bend": 0.0}
SHEAR = [[0.0, 0.5, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
EXTENSION = [[0.2, 0.0, 0.0], [0.0, -0.1, 0.0], [0.0, 0.0, -0.1]]


def make(count=4, **changes):
    base = {"chain.particles": count, "elasticity": SLACK, "run": {"end": 2.0, "snapshots": 3}}
    return nrchain.load_scene(base, **changes)


def test_spheres_fall_and_turn_by_stokes_law():
    scene = make(**{"field.force": [0, 0, -5.0], "field.torque": [0, 3.0, 0]})
    trajectory = nrchain.simulate(scene)
    fallen = trajectory.positions[-1] - trajectory.positions[0]
    assert fallen == pytest.approx(np.tile([0, 0, -5.0 * 2.0 / (6 * np.pi)], (4, 1)), abs=1e-7)
    angle = 3.0 * 2.0 / (8 * np.pi)
    assert trajectory.frames[-1][:, 0] == pytest.approx(
        np.tile([np.cos(angle), 0, -np.sin(angle)], (4, 1)), abs=100 * scene.run.rtol
    )
    # the base falls with the chain, so that nothing is left to step over
    assert trajectory.counters["steps"] < 40


def test_body_forces_follow_the_sphere():
    """f along e₁ with a torque across it: circles of radius v/ω."""
    speed, rate = 5.0 / (6 * np.pi), 3.0 / (8 * np.pi)
    changes = {"field.body_force": [5.0, 0, 0], "field.body_torque": [0, 0, 3.0], "run.end": 10.0}
    trajectory = nrchain.simulate(make(**changes))
    moved = trajectory.positions[-1] - trajectory.positions[0]
    angle = rate * 10.0
    circle = speed / rate * np.array([np.sin(angle), 1.0 - np.cos(angle), 0.0])
    assert moved == pytest.approx(np.tile(circle, (4, 1)), abs=1e-4)


@pytest.mark.parametrize("gradient", [SHEAR, EXTENSION])
def test_spheres_follow_a_background_flow(gradient):
    from scipy.linalg import expm

    flow = {"gradient": gradient, "disturbance": False}
    start = random_chain(4, spacing=10.0, bend=0.0)
    trajectory = nrchain.simulate(make(flow=flow), positions=start[0], frames=start[1])
    expected = start[0] @ expm(2.0 * np.array(gradient)).T
    assert trajectory.positions[-1] == pytest.approx(expected, abs=1e-4)
    spin = 0.5 * (gradient[1][0] - gradient[0][1])
    e1 = trajectory.frames[-1][:, 0]
    assert e1 == pytest.approx(np.tile([np.cos(2 * spin), np.sin(2 * spin), 0], (4, 1)), abs=1e-5)


@pytest.mark.parametrize("friction", ["one-body", "pairwise"])
def test_the_disturbance_is_that_of_all_pairs_and_asks_nothing_of_the_slip(friction):
    """20 passive spheres in an extension: sphere k is slowed by (5a³/2d²) E Σ ± 1/m²."""
    count, d, radius, rate = 20, 5.0, 1.2, 0.8
    gradient = np.diag([rate, -rate / 2, -rate / 2])
    changes = {"chain.spacing": d, "chain.radius": radius, "friction": friction}
    scene = make(count, **changes, **{"flow.gradient": gradient})
    x, frames = d * np.arange(count), np.broadcast_to(np.eye(3), (count, 3, 3)).copy()

    def slowed(scene):
        """In units of what one neighbour does."""
        twists = Model(scene).twists(x[:, None] * [1.0, 0.0, 0.0], frames)
        return (rate * x - twists[:, 0]) / (2.5 * radius**3 * rate / d**2)

    places = range(count)
    sums = [sum(np.sign(k - m) / (k - m) ** 2 for m in places if m != k) for k in places]
    assert slowed(scene) == pytest.approx(np.array(sums), abs=1e-12 * count * d**3)
    # ζ(2), less its tail, at the end; nearest neighbours alone give 1 there, and 0 beside it
    assert slowed(scene)[[-1, -2]] == pytest.approx([1.5936, 0.5909], abs=1e-4)
    near = slowed(nrchain.load_scene(scene, **{"flow.neighbours": 1}))
    assert near[[-1, -2]] == pytest.approx([1.0, 0.0], abs=1e-10)


@pytest.mark.parametrize("friction", ["one-body", "pairwise"])
def test_finite_size_takes_its_part_off_the_relative_velocity_of_a_pair(friction):
    """Batchelor & Green: A = 5/ρ³ − 8/ρ⁵ along the line, B = 16/3ρ⁵ across it, in a whole model."""
    radius, rho = 1.5, 4.0
    separation = rho * radius * np.array([2.0, 3.0, 6.0]) / 7.0
    strain = np.array([[0.2, 0.3, 0.1], [0.3, -0.1, 0.0], [0.1, 0.0, -0.1]])
    changes = {"chain.radius": radius, "friction": friction, "flow.finite_size": True}
    model = Model(make(2, **changes, **{"flow.gradient": strain}))
    frames = np.broadcast_to(np.eye(3), (2, 3, 3)).copy()
    twists = model.twists(np.array([np.zeros(3), separation]), frames)
    pulled = strain @ separation
    lengthwise = separation * (separation @ pulled) / (separation @ separation)
    lost = (5 / rho**3 - 8 / rho**5) * lengthwise + 16 / 3 / rho**5 * (pulled - lengthwise)
    relative = twists[1, :3] - twists[0, :3]
    assert relative == pytest.approx(pulled - lost, rel=1e-12)


def test_the_scale_of_a_disturbance_is_what_one_neighbour_does_along_the_line():
    rate, d = 0.3, 6.0
    gradient = np.diag([rate, -rate / 2, -rate / 2])
    changes = {"chain.spacing": d, "chain.radius": 1.5, "flow.finite_size": True}
    scene = make(2, **changes, **{"flow.gradient": gradient})
    positions, frames = np.array([[0.0, 0, 0], [d, 0, 0]]), np.tile(np.eye(3), (2, 1, 1))
    for effect in acting(scene):
        if effect.name != "flow":
            twists = np.zeros((2, 6))
            effect(scene).add_twists(positions, frames, twists)
            assert effect.scale(scene) == pytest.approx(abs(twists[1, 0]), rel=1e-12)


def test_a_rigid_rotation_is_not_disturbed():
    rotation = [[0.0, 0.4, 0.0], [-0.4, 0.0, 0.0], [0.0, 0.0, 0.0]]
    scene = make(**{"flow.gradient": rotation})
    assert [effect.name for effect in Model(scene).effects] == ["flow"]


@pytest.mark.parametrize("ends", ["free", "clamped", "periodic"])
@pytest.mark.parametrize("friction", ["one-body", "pairwise"])
@pytest.mark.parametrize("reach", [2, "all"])
@pytest.mark.parametrize("size", [False, True])
def test_they_enter_the_model_with_their_derivatives(ends, friction, reach, size):
    scene = make(
        6,
        **{"chain.ends": ends, "chain.spacing": 4.0, "chain.radius": 1.3, "friction": friction},
        elasticity={"stretch": 2.0, "shear": 3.0},
        flow={
            "gradient": [[0, 0.3, 0.1], [0, 0.2, 0.4], [0, -0.3, -0.2]],
            "neighbours": reach,
            "finite_size": size,
        },
        field={"torque": [1.0, 2.0, 3.0], "body_torque": [3.0, -1.0, 2.0]},
    )
    chain = ChartedChain(Model(scene))
    still = chain.model.held.any()
    chain.set_base(0.0, *random_chain(6, spacing=4.0), [0.0 if still else 0.3, 0, 0], 0.0)
    y = 0.2 * np.random.default_rng(1).standard_normal(chain.dimension)
    chain.linearise(0.5, y)
    ahead, behind, step = np.empty(len(y)), np.empty(len(y)), 1e-5
    direction, product = np.random.default_rng(2).standard_normal(len(y)), np.empty(len(y))
    chain.product(direction, product)
    chain.rates(0.5, y + step * direction, ahead)
    chain.rates(0.5, y - step * direction, behind)
    numeric = (ahead - behind) / (2 * step)
    assert product == pytest.approx(numeric, abs=1e-7 * np.abs(numeric).max())
    endless = ends == "periodic" and reach == "all"
    assert chain.model.is_banded == (friction == "one-body" and not endless)


def test_bases_fall_with_the_chain_through_the_fluid():
    """With friction between spheres a chain falls faster than its spheres do, and its base too."""
    scene = make(6, **{"field.force": [0, 0, -5.0], "friction": "pairwise"})
    chain = ChartedChain(Model(scene))
    poses = random_chain(6, spacing=10.0, noise=0.0, bend=0.0)
    chain.rebase(0.0, *poses)
    assert chain.drift == pytest.approx(Model(scene).twists(*poses)[:, :3].mean(axis=0))
    assert chain.drift[2] < -1.2 * 5.0 / (6 * np.pi)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"flow.gradient": EXTENSION, "chain.ends": "periodic"}, "flow.gradient"),
        (
            {"flow.gradient": SHEAR, "chain.ends": "periodic", "flow.neighbours": 10**6},
            "flow.neighbours",
        ),
    ],
)
def test_what_has_no_meaning_is_refused(changes, key):
    with pytest.raises(SceneError) as caught:
        make(**changes)
    assert caught.value.key == key


@pytest.mark.parametrize(
    "changes",
    [
        {"flow.gradient": SHEAR, "chain.ends": "periodic"},
        {"flow.gradient": SHEAR, "chain.ends": "periodic", "flow.finite_size": True},
        {"field.force": [1, 0, 0], "chain.ends": "periodic"},
        {"field.torque": [1, 0, 0], "chain.ends": "periodic", "friction": "pairwise"},
        {"field.force": [1, 0, 0], "chain.ends": "clamped", "friction": "pairwise"},
        {
            "flow.gradient": EXTENSION,
            "chain.ends": "clamped",
            "friction": "pairwise",
            "run.end": 0.5,
        },
    ],
)
def test_what_has_a_meaning_runs(changes):
    assert nrchain.simulate(make(**changes)).status == "completed"


def test_plane_waves_know_of_uniform_fields():
    """Lattice rates against a difference of twists, and V₀ and Ω₀."""
    field = {"force": [3.0, 0, 1.0], "torque": [2.0, 0, 0], "body_force": [5.0, 0, 0]}
    elasticity = {"stretch": 2.0, "shear": 3.0, "twist": 40.0, "bend": 40.0}
    count = 12
    scene = make(count, **{"chain.ends": "periodic"}, elasticity=elasticity, field=field)
    q = 2 * np.pi / (count * scene.chain.spacing)
    assert nrchain.steady_velocity(scene) == pytest.approx(np.array([8.0, 0, 1.0]) / (6 * np.pi))
    assert nrchain.steady_rotation(scene) == pytest.approx([2.0 / (8 * np.pi), 0, 0])
    operator = nrchain.lattice_operator(scene, q)
    model = Model(scene)
    positions = scene.chain.spacing * np.arange(count)[:, None] * [1.0, 0, 0]
    frames = np.broadcast_to(np.eye(3), (count, 3, 3)).copy()
    blocks = np.zeros((count, 2 * model.reach + 1, 6, 6))
    model.linearise(positions, frames, blocks)
    places = np.arange(2 * model.reach + 1) - model.reach
    phases = np.exp(1j * q * scene.chain.spacing * places)
    expected = np.einsum("m,mpq->pq", phases, blocks[0])
    expected[4, 5] -= 2.0 / (8 * np.pi)
    expected[5, 4] += 2.0 / (8 * np.pi)
    assert operator == pytest.approx(expected, abs=1e-12)
    rates = nrchain.lattice_rates(scene, q)
    eigenvalues = np.linalg.eigvals(operator)
    assert np.sort_complex(rates) == pytest.approx(np.sort_complex(eigenvalues), abs=1e-9)
    with pytest.raises(SceneError, match="across"):
        nrchain.lattice_rates(make(**{"field.torque": [0, 1.0, 0]}), q)
