"""The model of every configuration: gradient, symmetry, derivative, rigid motion, and PyStokes."""

import numpy as np
import pytest
from support.configurations import SLACK, each
from support.poses import dense, pose_derivative, rigid_motion

from nrchain import load_scene
from nrchain.effects.registry import acting
from nrchain.motion.model import Model


def is_elastic(configuration):
    """Whether elasticity is all that acts; effects by themselves are in effects/test_registry."""
    alone = configuration.effect is None and not configuration.slip
    return alone and configuration.ends != "clamped"


@each(is_elastic)
def test_wrenches_are_minus_the_gradient_of_the_energy(configuration):
    scene, poses = configuration.scene(), configuration.poses()
    terms = [effect(scene) for effect in acting(scene) if effect.gives == "wrench"]
    slope = pose_derivative(lambda r, e: sum(term.energy(r, e) for term in terms), *poses)
    assert Model(scene).wrenches(*poses) == pytest.approx(-slope, rel=1e-6, abs=1e-6)


@each(lambda c: is_elastic(c) and c.friction["kind"] == "one-body")
def test_forces_of_an_energy_have_a_symmetric_derivative(configuration):
    model, count = Model(configuration.scene()), configuration.count
    blocks = np.zeros((count, 2 * model.reach + 1, 6, 6))
    model.linearise(*configuration.poses(), blocks)
    matrix = dense(blocks, configuration.ends == "periodic")[:, :3, :, :3]
    matrix = matrix.reshape(3 * count, 3 * count)
    assert matrix == pytest.approx(matrix.T, rel=1e-10, abs=1e-10 * np.abs(matrix).max())


@each(lambda c: c.friction["kind"] == "pairwise" and c.ends != "periodic")
def test_the_mobility_is_symmetric_and_that_of_all_pairs_positive(configuration):
    model, count, a = Model(configuration.scene()), configuration.count, configuration.radius
    positions, _ = configuration.poses()
    columns = [model.mobile_twists(positions, unit.reshape(-1, 6)) for unit in np.eye(6 * count)]
    # in radii, so that translation and rotation are alike
    scale = np.tile([1.0, 1.0, 1.0, a, a, a], count)
    matrix = np.reshape(columns, (6 * count, 6 * count)) * np.outer(scale, scale)
    assert matrix == pytest.approx(matrix.T, rel=0, abs=1e-13 * np.abs(matrix).max())
    if configuration.friction.get("neighbours", "all") == "all":
        assert np.linalg.eigvalsh(matrix).min() > 0.0


@each(lambda c: c.ends != "clamped")
def test_blocks_or_products_are_the_derivative_of_the_twists(configuration):
    """Blocks where they are the whole derivative, products where they are not."""
    model, count = Model(configuration.scene()), configuration.count
    poses = configuration.poses()
    numeric = pose_derivative(model.twists, *poses)
    scale = np.abs(numeric).max()
    blocks = np.zeros((count, 2 * model.reach + 1, 6, 6))
    model.linearise(*poses, blocks)
    if model.is_banded:
        found = dense(blocks, configuration.ends == "periodic")
        assert found == pytest.approx(numeric, abs=1e-7 * scale)
        return
    # evaluations elsewhere leave the derivative what it was
    model.twists(*configuration.poses(seed=1, apart=5.0))
    moves, product = np.random.default_rng(2).normal(size=(count, 6)), np.zeros((count, 6))
    model.add_product(moves, product)
    expected = np.einsum("npmq,mq->np", numeric, moves)
    assert product == pytest.approx(expected, abs=1e-7 * scale * count)


@each(lambda c: c.ends == "free" and (c.effect is None or c.effect.covariant))
def test_a_rigid_motion_carries_the_twists_along(configuration):
    model, poses = Model(configuration.scene()), configuration.poses()
    positions, frames, turn = rigid_motion(*poses)
    here, there = model.twists(*poses), model.twists(positions, frames)
    turned = np.concatenate([here[:, :3] @ turn.T, here[:, 3:] @ turn.T], axis=1)
    assert there == pytest.approx(turned, rel=0, abs=1e-11 * np.abs(here).max())


def has_backends(configuration):
    pairs = configuration.slip or configuration.friction["kind"] == "pairwise"
    return pairs and configuration.ends == "free" and configuration.effect is None


@each(has_backends)
def test_native_and_pystokes_agree(configuration):
    backends = {"slip.backend": "pystokes"} if configuration.slip else {}
    if configuration.friction["kind"] == "pairwise":
        backends["friction.backend"] = "pystokes"
    else:
        # slip by itself, beside which elastic velocities would be large
        backends |= SLACK
    poses = configuration.poses()
    scene = configuration.scene(**backends)
    native = load_scene(scene, **{"slip.backend": "native", "friction.backend": "native"})
    native, other = (Model(one).twists(*poses) for one in (native, scene))
    # in radii, so that velocities and spins are alike
    for part in (slice(0, 3), slice(3, 6)):
        scale = np.abs(native[:, part]).max()
        assert other[:, part] == pytest.approx(native[:, part], rel=0, abs=1e-11 * scale)
