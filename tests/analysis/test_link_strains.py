"""Strains of links: those whose energy is the elastic energy, and angles of known shapes."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import nrchain
from nrchain.analysis.link_strains import link_strains

D = 10.0


def scene(count, ends="free"):
    base = {"chain.particles": count, "chain.ends": ends, "run.end": 1.0}
    return nrchain.load_scene(base)


def crooked(count, seed=0):
    """A chain along x whose positions and frames are disturbed."""
    generator = np.random.default_rng(seed)
    positions = generator.normal(0.0, 0.5, (count, 3))
    positions[:, 0] += D * np.arange(count)
    turned = Rotation.from_rotvec(generator.normal(0.0, 0.2, (count, 3)))
    return positions, turned.as_matrix()


@pytest.mark.parametrize(
    ("count", "ends"),
    [(2, "free"), (3, "free"), (4, "free"), (7, "free"), (4, "periodic"), (7, "periodic")],
)
def test_stretch_and_shear_have_the_elastic_energy(count, ends):
    positions, frames = crooked(count)
    found = link_strains(scene(count, ends), positions, frames)
    for strain, name in ((found.stretch, "stretch"), (found.shear, "shear")):
        moduli = {"stretch": 0.0, "shear": 0.0, "twist": 0.0, "bend": 0.0, name: 1.0}
        energy = nrchain.elastic_energy(positions, frames, spacing=D, ends=ends, **moduli)
        assert len(strain) == (count if ends == "periodic" else count - 1)
        assert np.sum(D**2 / 2 * strain**2) == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("angle", [1e-9, 0.1, 2.5])
def test_bend_and_twist_are_the_angles_of_each_link(angle):
    positions = D * np.arange(5)[:, None] * np.array([1.0, 0.0, 0.0])
    for axis, name in (([1.0, 0, 0], "twist"), ([0, 0.6, 0.8], "bend")):
        turns = Rotation.from_rotvec(angle * np.arange(5)[:, None] * np.array(axis))
        # rows are e1, e2, e3
        frames = np.swapaxes(turns.as_matrix(), 1, 2)
        found = link_strains(scene(5), positions, frames)
        assert getattr(found, name) * D == pytest.approx(np.full(4, angle), rel=1e-6)
        other = found.bend if name == "twist" else found.twist
        assert np.abs(other).max() < 1e-12


def test_strains_of_many_snapshots_are_those_of_each():
    chains = [crooked(6, seed) for seed in range(3)]
    positions, frames = (np.array(part) for part in zip(*chains, strict=True))
    together = link_strains(scene(6), positions, frames)
    for row, chain in enumerate(chains):
        for whole, part in zip(together, link_strains(scene(6), *chain), strict=True):
            assert np.array_equal(whole[row], part)


def test_a_wrapped_periodic_chain_has_the_strains_of_the_unwrapped_one():
    positions, frames = crooked(6)
    wrapped = positions.copy()
    wrapped[4:, 0] -= 6 * D
    for one, other in zip(
        link_strains(scene(6, "periodic"), positions, frames),
        link_strains(scene(6, "periodic"), wrapped, frames),
        strict=True,
    ):
        assert one == pytest.approx(other, abs=1e-12)
