"""dΛ/dp = ℓᴴ (dJ/dp) x, ℓᴴ x = 1: how a rate changes with each number of a scene.

The state changes with p as well: J(X(p), p). Its change η solves J η = −∂G/∂p in the gauge of the
state. Along this path ℓᴴ P J P x is differentiated by central differences, with ℓ and x the left
and right modes of the unchanged scene: no further eigenvalue is computed. For a rate with several
modes the derivatives are the eigenvalues of the matrix ℓᴴ (dJ/dp) x; the one of largest real part
is given.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nrchain.comoving.bordered import Bordered
from nrchain.comoving.motions import fields, moved
from nrchain.comoving.relative import Point, RelativeChain
from nrchain.scene.scene import Scene
from nrchain.states.modes import Mode, shape_product
from nrchain.states.parameters import Parameter
from nrchain.types import Poses

STEP = 1e-4
"""Relative change of p."""

Carry = Callable[[Scene], Poses]
"""The poses that go with a changed scene before Newton's method: held spheres in their places."""


def derivative(
    point: Point, factors: Bordered, mode: Mode, parameter: Parameter, carry: Carry
) -> complex:
    """dΛ/dp of a mode, by central differences along the path of the state."""
    step = STEP * parameter.scale
    sides = [parameter.changed(parameter.value + sign * step) for sign in (1.0, -1.0)]
    poses = [carry(scene) for scene in sides]
    chains = [RelativeChain(scene, given) for scene, given in zip(sides, poses, strict=True)]
    slopes = [_left_over(chain, given, point) for chain, given in zip(chains, poses, strict=True)]
    change = -factors.solve((slopes[0] - slopes[1]) / (2.0 * step) * point.chain.units)
    direction = point.chain.poses(change)
    right, left = mode.vectors
    ends = []
    for chain, given, sign in zip(chains, poses, (1.0, -1.0), strict=True):
        reached = chain.at(moved(*given, sign * step * direction))
        ends.append(left.conj().T @ shape_product(reached, right))
    values = np.linalg.eigvals((ends[0] - ends[1]) / (2.0 * step))
    return complex(values[np.lexsort((values.imag, values.real))[-1]])


def _left_over(chain: RelativeChain, poses: Poses, point: Point) -> np.ndarray:
    """w − g (n,) of a changed scene, with the motion g of the unchanged one; per unit of time."""
    elementary = fields(*poses, point.chain.origin, point.chain.length)
    twists = chain.model.twists(*poses) - np.tensordot(point.elementary, elementary, 1)
    return twists[chain.free].ravel()
