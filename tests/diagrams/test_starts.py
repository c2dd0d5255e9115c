"""Starts: their shapes, ends and frames."""

import numpy as np
import pytest

import nrchain
from nrchain.diagrams.starts import start_poses


def scene(**changes):
    given = {"chain.particles": 12, "start.amplitude": 0.5, "start.seed": 4}
    return nrchain.load_scene("buckling", **given | changes)


@pytest.mark.parametrize("ends", ["free", "clamped", "periodic"])
@pytest.mark.parametrize("name", ["random", "random:7", "planar", "helix-left", "helix-right"])
def test_starts_are_of_the_amplitude_and_clamps_stay_straight(ends, name):
    positions, frames = start_poses(scene(**{"chain.ends": ends}), name)
    assert 0.2 < np.abs(positions[:, 1:]).max() < 2.0
    assert np.einsum("nij,nkj->nik", frames, frames) == pytest.approx(
        np.broadcast_to(np.eye(3), (12, 3, 3)), abs=1e-14
    )
    if ends == "clamped":
        assert np.abs(positions[[0, -1], 1:]).max() == 0.0
        assert frames[[0, -1]] == pytest.approx(np.broadcast_to(np.eye(3), (2, 3, 3)), abs=1e-14)


def test_a_planar_start_is_the_random_one_in_its_plane():
    planar, frames = start_poses(scene(), "planar:4")
    random, _ = start_poses(scene(), "random:4")
    assert np.array_equal(planar[:, :2], random[:, :2])
    assert planar[:, 2] == pytest.approx(1e-3 * random[:, 2], abs=1e-15)
    assert np.abs(frames[:, 0, 2]).max() < 1e-3


def test_helices_have_a_hand():
    for name, hand in (("helix-left", -1), ("helix-right", 1)):
        positions, frames = start_poses(scene(**{"chain.ends": "periodic"}), name)
        y, z = positions[:, 1], positions[:, 2]
        turned = np.unwrap(np.arctan2(z, y))
        assert np.all(np.sign(np.diff(turned)) == hand)
        assert np.sign(frames[0, 0, 2]) == hand


def test_the_start_of_the_scene_is_a_start():
    given = scene(**{"start.shape": "sine"})
    positions, _ = start_poses(given, "scene")
    assert np.array_equal(
        positions,
        nrchain.simulate(
            nrchain.load_scene(given, **{"run.end": 1e-9, "run.snapshots": 2})
        ).positions[0],
    )
