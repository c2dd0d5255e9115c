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


class CutFriction:
    """The friction of a scene that acts between spheres up to ``neighbours`` places apart.

    ``neighbours`` is that of the scene unless given. The friction must be cut, see :func:`is_cut`:
    the mobility of all pairs is always positive definite.
    """

    def __init__(self, scene: Scene, neighbours: int | None = None) -> None:
        chain = scene.chain
        reach = scene.friction.neighbours if neighbours is None else neighbours
        assert isinstance(reach, int)
        self.neighbours, self._count = reach, chain.particles
        self._friction = PairFriction(
            chain.particles, reach, chain.radius, chain.viscosity, scene.period
        )
        self._scale = np.sqrt(np.repeat(scene.drag, 3))

    def least_mobility(self, positions: np.ndarray) -> float:
        """The least eigenvalue of μ at positions (N, 3); 1 for spheres far from each other."""
        scale, count = self._scale, self._count
        if count <= DIRECT:
            matrix = self._friction.matrix(positions).reshape(-1, 6, count, 6)
            scaled = (scale[:, None, None] * matrix * scale).reshape(6 * count, -1)
            return float(np.linalg.eigvalsh(0.5 * (scaled + scaled.T))[0])

        def apply(vector: np.ndarray) -> np.ndarray:
            twists = np.zeros((count, 6))
            self._friction.apply(positions, vector.reshape(-1, 6) * scale, twists)
            return (twists * scale).ravel()

        return _least_ritz_value(apply, 6 * count)


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
