"""Friction cut at a reach: its least eigenvalue, and what a passive chain does where it is lost."""

import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneError
from nrchain.hydrodynamics.friction import PairFriction
from nrchain.motion import definiteness
from nrchain.motion.definiteness import CutFriction, is_cut
from nrchain.planning.checked_start import starting_poses
from nrchain.theory.straight_chain import StraightChain


def chain(neighbours, spacing=2.2, **changes):
    friction = {"kind": "pairwise", "neighbours": neighbours}
    return nrchain.load_scene(
        "passive",
        **{"chain.spacing": spacing, "start.amplitude": 0.01},
        friction=friction,
        **changes,
    )


def line(count, spacing):
    return spacing * np.arange(count)[:, None] * np.eye(3)[0]


@pytest.mark.parametrize("spacing", [2.2, 2.5, 3.0])
@pytest.mark.parametrize("neighbours", [1, 2, 3])
def test_the_least_eigenvalue_of_a_long_chain_is_the_least_of_its_symbol(spacing, neighbours):
    scene = chain(neighbours, spacing, chain={"particles": 300})
    phases = np.linspace(0.0, np.pi, 2001)
    scale = np.sqrt(np.repeat(scene.drag, 3))
    symbol = scale[:, None] * StraightChain(scene).mobility(phases) * scale
    least = np.linalg.eigvalsh(symbol).min()
    assert CutFriction(scene).least_mobility(line(300, spacing)) == pytest.approx(least, abs=1e-3)


def test_dense_and_lanczos_eigenvalues_agree_on_a_bent_chain(monkeypatch):
    scene = chain(2, chain={"particles": 30})
    positions = line(30, 2.2) + 0.05 * np.random.default_rng(1).standard_normal((30, 3))
    direct = CutFriction(scene).least_mobility(positions)
    monkeypatch.setattr(definiteness, "DIRECT", 0)
    assert CutFriction(scene).least_mobility(positions) == pytest.approx(direct, abs=1e-3)


def test_a_negative_eigenvalue_is_that_of_the_mobility_matrix():
    scene = chain(1)
    positions = line(20, 2.2)
    assert CutFriction(scene).least_mobility(positions) < -0.1
    matrix = PairFriction(20, 1, 1.0, 1.0).matrix(positions)
    assert np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min() < 0.0


@pytest.mark.parametrize("ends", ["free", "clamped", "periodic"])
def test_a_cut_that_is_not_positive_definite_is_refused_with_one_that_is(ends):
    with pytest.raises(SceneError, match="must be 'all', or 2, which is enough here") as caught:
        nrchain.simulate(chain(1, **{"chain.ends": ends}))
    assert caught.value.key == "friction.neighbours"
    assert caught.value.value == 1
    starting_poses(chain(2, **{"chain.ends": ends}))
    starting_poses(chain("all", **{"chain.ends": ends}))


def test_a_curled_start_is_judged_as_it_is():
    """Eight neighbours hold on a straight chain; on a coil they leave spheres that touch out."""
    scene = chain(8, chain={"particles": 40, "ends": "free"})
    angle = 2.2 / 3.0 * np.arange(40)
    coil = np.stack([2.3 / (2 * np.pi) * angle, 3 * np.cos(angle), 3 * np.sin(angle)], axis=1)
    starting_poses(scene)
    with pytest.raises(SceneError, match="positive definite"):
        starting_poses(scene, positions=coil)


def test_only_friction_between_some_neighbours_is_cut():
    assert not is_cut(nrchain.load_scene("passive"))
    assert not is_cut(chain("all"))
    assert not is_cut(chain(19))
    assert is_cut(chain(18))
    assert is_cut(chain(19, **{"chain.ends": "periodic"}))


def test_a_passive_chain_with_definite_friction_loses_energy():
    scene = chain(2, **{"run.end": 20.0, "run.snapshots": 11, "chain.particles": 8})
    run = nrchain.simulate(scene)
    moduli = scene.moduli._asdict()
    energy = [
        nrchain.elastic_energy(r, e, spacing=2.2, **moduli)
        for r, e in zip(run.positions, run.frames, strict=True)
    ]
    assert run.status == "completed"
    assert np.all(np.diff(energy) < 1e-9 * energy[0])
