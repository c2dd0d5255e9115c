"""The matrix of small changes of all pairs, from blocks of pairs and column by column."""

import numpy as np
import pytest

import nrchain
from nrchain.comoving.relative import RelativeChain
from nrchain.scene.poses import initial_poses

MODES = {"slip.2s": 30.0, "slip.3a": 50.0, "slip.3t": 70.0, "slip.4a": 90.0}


@pytest.mark.parametrize(
    "changes",
    [
        {"chain.ends": "clamped"},
        {"chain.ends": "free", "chain.radius": 1.25, "chain.viscosity": 0.5},
        {"chain.ends": "free", "field.force": [0.0, 0.3, 0.0], "chain.spacing": 8.0},
        {"chain.ends": "free", "slip.neighbours": 9},
    ],
)
def test_blocks_of_pairs_are_the_matrix_of_products(changes):
    base = {"chain.particles": 12, "start.amplitude": 0.4, "slip.neighbours": "all"}
    scene = nrchain.load_scene("buckling", **{**base, **MODES, **changes})
    poses = initial_poses(scene)
    point = RelativeChain(scene, poses).at(poses)
    assert not point.is_banded
    assert point.has_blocks
    columns = [point._product(unit) for unit in np.eye(point.chain.dimension)]
    scale = np.abs(columns).max()
    assert point.matrix == pytest.approx(np.transpose(columns), abs=1e-12 * scale)


def test_friction_between_spheres_and_images_have_no_such_blocks():
    for changes in ({"friction": "pairwise"}, {"chain.ends": "periodic"}):
        scene = nrchain.load_scene(
            "buckling", **{"chain.particles": 8, "slip.neighbours": "all", **changes}
        )
        poses = initial_poses(scene)
        assert not RelativeChain(scene, poses).at(poses).has_blocks
