"""Banded and matrix-free Jacobians: (I − cJ)⁻¹ and J itself, against dense algebra."""

import numpy as np
import pytest
from support.stepping import periodic, prepare, small

from nrchain.motion.integrators.linear import (
    RESIDUAL,
    BandedJacobian,
    KrylovJacobian,
    SingularMatrix,
    jacobian_of,
)

SCENES = {
    "open": lambda: small("wave", 6, 1.0),
    "clamped": lambda: small("buckling", 5, 1.0),
    "periodic": periodic,
    "all pairs": lambda: small("spiral-left", 12, 1.0, **{"slip.neighbours": "all"}),
}


def linearised(scene):
    """A chain's Jacobian at a point away from the base, and the same from the chain's products."""
    chain, _ = prepare(SCENES[scene](), "cvode", 1e-6)
    jacobian = jacobian_of(chain, np.ones(chain.dimension))
    jacobian.update(0.3, 0.1 * np.random.default_rng(5).standard_normal(chain.dimension))
    return jacobian, chain.jacobian()


@pytest.mark.parametrize("scene", SCENES)
def test_kind(scene):
    jacobian, _ = linearised(scene)
    assert isinstance(jacobian, KrylovJacobian if scene == "all pairs" else BandedJacobian)


def left_over(jacobian, dense, scale, found, right):
    """What is left of a right-hand side, in units of what GMRES may leave."""
    rest = right - (found - scale * dense @ found)
    if isinstance(jacobian, BandedJacobian):
        return np.abs(rest).max() / 1e-11
    precondition = jacobian._near.shifted_inverse(scale)
    sizes = (np.linalg.norm(precondition(vector)) for vector in (rest, right))
    return np.divide(*sizes) / RESIDUAL


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("scale", [0.02, 0.02 - 0.03j])
def test_shifted_inverse(scene, scale):
    jacobian, dense = linearised(scene)
    right = np.random.default_rng(6).standard_normal(len(dense)).astype(type(scale))
    found = jacobian.shifted_inverse(scale)(right)
    assert left_over(jacobian, dense, scale, found, right) <= 1.0


@pytest.mark.parametrize("scene", SCENES)
def test_real_and_complex_factors_live_side_by_side(scene):
    jacobian, dense = linearised(scene)
    right = np.ones(len(dense))
    real = jacobian.shifted_inverse(0.02)
    jacobian.shifted_inverse(0.01 + 0.01j)
    assert left_over(jacobian, dense, 0.02, real(right), right) <= 1.0


@pytest.mark.parametrize("scene", [name for name in SCENES if name != "all pairs"])
def test_matrix(scene):
    jacobian, dense = linearised(scene)
    assert jacobian.matrix().format == "csc"
    assert jacobian.matrix().toarray() == pytest.approx(dense, rel=1e-14, abs=0.0)


def test_singular_matrices_are_recognised():
    chain, _ = prepare(small("passive", 3, 1.0, **{"chain.ends": "clamped"}), "cvode", 1e-6)
    jacobian = BandedJacobian(chain)
    chain.linearise(0.0, np.zeros(chain.dimension))
    chain._blocks[:] = np.eye(6)
    with pytest.raises(SingularMatrix):
        jacobian.shifted_inverse(1.0)
