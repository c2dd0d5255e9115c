"""min x·μx / x·x: whether friction between spheres dissipates energy for all wrenches.

The mobility of all pairs is positive definite. A mobility cut at a number of neighbours may not be:
if spheres are close, some wrenches gain energy from the fluid, and a passive chain is unstable.
Eigenvalues are in units of the mobility of a single sphere: the diagonal of μ is 1.
"""

from __future__ import annotations

import numpy as np

from nrchain.hydrodynamics.friction import PairFriction
from nrchain.scene.scene import Scene

DEFINITE = 1e-3
"""Smallest eigenvalue of the mobility at which a run may start; motion changes it."""

DIRECT = 50
"""Largest number of spheres for which all eigenvalues are computed."""

STEPS = 100
"""Lanczos steps for longer chains. Ritz values bound the smallest eigenvalue from above, to within
about (π / 2 STEPS)² of the width of the spectrum: below :data:`DEFINITE`."""


def is_cut(scene: Scene) -> bool:
    """Whether friction acts between spheres, and not between all of them."""
    friction, chain = scene.friction, scene.chain
    if friction.kind == "one-body" or friction.neighbours == "all":
        return False
    return chain.ends == "periodic" or friction.neighbours < chain.particles - 1


def least_mobility(scene: Scene, positions: np.ndarray, neighbours: int | None = None) -> float:
    """The least eigenvalue of μ at these positions (N, 3); 1 for spheres far from each other.

    ``neighbours`` replaces the scene's ``friction.neighbours``. The friction must be cut, see
    :func:`is_cut`: the mobility of all pairs is always positive definite.
    """
    chain = scene.chain
    reach = scene.friction.neighbours if neighbours is None else neighbours
    assert isinstance(reach, int)
    period = scene.length if chain.ends == "periodic" else 0.0
    friction = PairFriction(chain.particles, reach, chain.radius, chain.viscosity, period)
    scale = np.sqrt(np.repeat(scene.drag, 3))
    if chain.particles <= DIRECT:
        matrix = friction.matrix(positions).reshape(-1, 6, len(positions), 6)
        scaled = (scale[:, None, None] * matrix * scale).reshape(6 * len(positions), -1)
        return float(np.linalg.eigvalsh(0.5 * (scaled + scaled.T))[0])

    def apply(vector: np.ndarray) -> np.ndarray:
        twists = np.zeros((chain.particles, 6))
        friction.apply(positions, vector.reshape(-1, 6) * scale, twists)
        return (twists * scale).ravel()

    return _least_ritz_value(apply, 6 * chain.particles)


def _least_ritz_value(apply, size: int) -> float:
    """The smallest eigenvalue of the tridiagonal matrix of Lanczos's recurrence."""
    from scipy.linalg import eigvalsh_tridiagonal

    before, now = np.zeros(size), np.random.default_rng(0).standard_normal(size)
    now /= np.linalg.norm(now)
    diagonal, beside = np.empty(STEPS), np.zeros(STEPS)
    for step in range(STEPS):
        image = apply(now)
        diagonal[step] = now @ image
        image -= diagonal[step] * now + beside[step - 1] * before
        beside[step] = np.linalg.norm(image)
        before, now = now, image / beside[step]
    return float(eigvalsh_tridiagonal(diagonal, beside[:-1])[0])
