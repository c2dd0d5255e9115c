"""The rival of the benchmarks has the same equations: twists to 1e-10, and the same trajectory."""

import numpy as np
import pytest
from support.poses import random_chain

from nrchain import load_scene, simulate
from nrchain.motion.model import Model
from nrchain.scene.poses import initial_poses
from validation.performance import recipe
from validation.performance.recipe import Recipe, solve_compiled, solve_recipe
from validation.report import threads
from validation.report.threads import one_thread

SLIPS = {"slip.3a": 3.0, "slip.3t": -2.0, "slip.4a": 1.5}


def scene_of(count, **changes):
    table = {
        "chain.particles": count,
        "chain.radius": 0.9,
        "chain.spacing": 2.5,
        "chain.viscosity": 0.7,
        "elasticity.stretch": 30.0,
        "elasticity.shear": 20.0,
        "elasticity.twist": 7.0,
        "elasticity.bend": 9.0,
        "slip.2s": list(np.linspace(1.0, 2.0, count)),
        "run.end": 1.0,
    }
    return load_scene(table | SLIPS, **changes)


def twists_of(scene, positions, frames):
    rival = Recipe(scene, positions, frames)
    velocities, spins = rival.twists(*rival.poses(rival.start))
    return np.concatenate([velocities.T, spins.T], axis=1)


@pytest.mark.parametrize("count", [2, 3, 4, 11])
@pytest.mark.parametrize("neighbours", [1, 2, "all"])
@pytest.mark.parametrize("friction", ["one-body", "pairwise"])
@pytest.mark.parametrize("finite_size", [False, True])
def test_twists_are_those_of_the_model(count, neighbours, friction, finite_size):
    options = {
        "slip.neighbours": neighbours,
        "slip.finite_size": finite_size,
        "friction": friction,
    }
    scene = scene_of(count, **options)
    positions, frames = random_chain(count, noise=0.1, seed=count)
    expected = Model(scene).twists(positions, frames)
    found = twists_of(scene, positions, frames)
    for part in (slice(0, 3), slice(3, 6)):
        error = np.abs(found[:, part] - expected[:, part]).max()
        assert error < 1e-10 * np.abs(expected[:, part]).max()


def test_a_modulus_off_by_a_millionth_is_found():
    positions, frames = random_chain(6, noise=0.1)
    expected = Model(scene_of(6)).twists(positions, frames)
    for modulus in ("stretch", "shear", "twist", "bend"):
        value = getattr(scene_of(6).elasticity, modulus)
        off = scene_of(6, **{f"elasticity.{modulus}": value * (1 + 1e-6)})
        found = twists_of(off, positions, frames)
        assert np.abs(found - expected).max() > 1e-10 * np.abs(expected).max()


def test_rates_are_the_derivative_of_poses():
    positions, frames = random_chain(5, noise=0.1)
    rival = Recipe(scene_of(5), positions, frames)
    y = rival.start + 0.3 * np.random.default_rng(1).standard_normal(30)
    rates, step = rival.rates(0.0, y), 1e-6
    (ahead, turned), (behind, back) = (rival.poses(y + s * step * rates) for s in (1, -1))
    velocities, spins = rival.twists(*rival.poses(y))
    np.testing.assert_allclose((ahead - behind) / (2 * step), velocities, rtol=1e-6, atol=1e-6)
    slope = (turned - back) / (2 * step)
    expected = np.cross(spins[:, None], rival.poses(y)[1], axis=0)
    np.testing.assert_allclose(slope, expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("solve", [solve_recipe, solve_compiled])
@pytest.mark.parametrize(
    "options", [{}, {"slip.neighbours": "all", "friction": "pairwise"}], ids=["near", "far"]
)
@pytest.mark.parametrize("careful", [False, True])
def test_a_short_run_ends_where_nrchain_does(solve, options, careful):
    table = {"chain.particles": 5, "slip.2s": 100.0, "slip.4a": 50.0, "start.shape": "random"}
    run = {"run.end": 20.0, "run.snapshots": 3, "run.rtol": 1e-8, "run.atol": 1e-8}
    scene = load_scene(table | run, **options)
    expected = simulate(scene)
    with one_thread():
        found = solve(scene, *initial_poses(scene), expected.time, 1e-8, 1e-8, careful)
    np.testing.assert_allclose(found.positions, expected.positions, atol=1e-5)
    np.testing.assert_allclose(found.frames, expected.frames, atol=1e-5)
    assert found.jacobians > 0
    assert found.evaluations > 31 * found.jacobians


def test_quotients_are_the_jacobian():
    matrix = np.random.default_rng(0).standard_normal((4, 4))
    found = recipe.difference_quotients(lambda t, y: matrix @ y, 0.0, np.array([0.0, 1, 600, -2]))
    np.testing.assert_allclose(found, matrix, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(
    "options",
    [
        {"chain.ends": "clamped"},
        {"elasticity.measure": "isotropic"},
        {"slip.4a": {"strength": 1.0, "axis": [0.0, 1.0, 0.0]}},
        {"friction": {"kind": "pairwise", "neighbours": 2}},
    ],
)
def test_other_scenes_are_refused(options):
    scene = scene_of(5, **options)
    with pytest.raises(ValueError, match="the recipe has"):
        Recipe(scene, *initial_poses(scene))


def test_the_numbers_of_threads_are_put_back():
    def numbers():
        return [get() for get, _ in (*threads._openmp(), *threads._openblas())]

    before = numbers()
    with one_thread():
        assert set(numbers()) <= {1}
    assert numbers() == before
