"""Which modes bend a chain and grow, and how much of each is in its poses: J v = λ v.

A mode k is present with the amplitude c_k = |w_k·f| max|v_k| / |λ_k w_k·v_k|, with f the velocity
and w_k, v_k the left and right eigenvectors of the Jacobian J. Of chains too long for all
eigenvalues those nearest to given rates are found, by the part of J near the diagonal: what spheres
farther apart do to each other is not in them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain.charts import ChartedChain

DENSE = 130
"""Coordinates up to which all eigenvalues are taken: 20 ms, where 400 would take a second."""

NEAREST = 6
"""Eigenvalues found about each of the rates that matter on longer chains."""

ACROSS = 1e-3
"""A mode bends the chain if more than this part of it is neither along it nor a rigid motion."""

FROZEN = 2.0
"""Rates this many times that of the state which they are taken about are of that state."""

TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Growth:
    """Rates μ (K,) of the modes that bend the chain and grow, and the amplitudes (K,) present."""

    rates: np.ndarray
    amplitudes: np.ndarray


def growth_about_base(
    chain: ChartedChain, axis: np.ndarray, least: float, fast: float, bend: float
) -> Growth:
    """The modes about the base of a chain, nearly straight along ``axis``, faster than ``least``.

    Also faster than ``FROZEN`` times the rate at which links stretch or shorten: offsets grow with
    a chain that is stretched, as it takes its direction from how it lay, and nothing bends.
    On a long chain those near the rates ``least`` and ``fast``, with ``bend`` for the amplitude of
    each; none where the Jacobian is not finite or its eigenvalues are not found.
    """
    from scipy.sparse.linalg import ArpackError

    try:
        return _growth(chain, axis, least, fast, bend)
    except (ArpackError, ArithmeticError, np.linalg.LinAlgError):
        return Growth(np.empty(0), np.empty(0))


def _growth(
    chain: ChartedChain, axis: np.ndarray, least: float, fast: float, bend: float
) -> Growth:
    still = np.zeros(chain.dimension)
    bound = max(least, FROZEN * _stretching(chain, axis))
    chain.linearise(chain.time, still)
    if chain.dimension > DENSE:
        values, shapes = _nearest(chain, (least, fast))
        grows = (values.real > bound) & _bends(chain, shapes, axis)
        return Growth(values.real[grows], np.full(grows.sum(), bend))
    from scipy.linalg import eig

    matrix = chain.jacobian()
    if not np.isfinite(matrix).all():
        return Growth(np.empty(0), np.empty(0))
    values, duals, shapes = eig(matrix, left=True)
    grows = (values.real > bound) & _bends(chain, shapes, axis)
    values, duals, shapes = values[grows], duals[:, grows], shapes[:, grows]
    velocity = np.empty(chain.dimension)
    chain.rates(chain.time, still, velocity)
    overlap = np.abs((duals.conj() * shapes).sum(axis=0) * values)
    sizes = np.abs(duals.conj().T @ velocity) * np.abs(shapes).max(axis=0, initial=0.0)
    return Growth(values.real, sizes / np.maximum(overlap, TINY))


def _stretching(chain: ChartedChain, axis: np.ndarray) -> float:
    """max |d ln l/dt| of the links, each of length l along the axis, about the base."""
    positions = chain.base_positions
    twists = chain.model.twists(positions, chain.base_frames)
    apart, parting = (np.diff(rows @ axis) for rows in (positions, twists[:, :3]))
    return float(np.abs(parting / np.where(apart == 0.0, TINY, apart)).max())


def _bends(chain: ChartedChain, shapes: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Which modes (6N, K) are more across the axis than a shift and a turn of the whole chain."""
    modes = shapes.T.reshape(shapes.shape[1], len(chain.order), 2, 3)
    across = modes - (modes @ axis)[..., None] * axis
    places = chain.base_positions[chain.order] @ axis
    places = places - places.mean()
    across[:, :, 0] -= across[:, :, 0].mean(axis=1, keepdims=True)
    turn = np.einsum("n,knc->kc", places, across[:, :, 0]) / max(float(places @ places), TINY)
    across[:, :, 0] -= places[:, None] * turn[:, None]
    across[:, :, 1] -= np.cross(axis, turn)[:, None]
    most = np.abs(modes).max(axis=(1, 2, 3), initial=0.0)
    return np.abs(across).max(axis=(1, 2, 3), initial=0.0) > ACROSS * most


def _nearest(chain: ChartedChain, rates: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and eigenvectors about these rates, of the Jacobian near its diagonal."""
    from scipy.linalg import lapack
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

    size, width = chain.dimension, chain.bandwidth
    begin = np.random.default_rng(0).standard_normal(size)
    found = []
    for rate in rates:
        band = np.zeros((3 * width + 1, size), order="F")
        chain.fill_band(band, -rate, 1.0)
        factors, pivots, info = lapack.dgbtrf(band, width, width, overwrite_ab=True)
        if info > 0:
            continue

        def inverse(vector: np.ndarray, factors=factors, pivots=pivots) -> np.ndarray:
            return lapack.dgbtrs(factors, width, width, vector, pivots)[0]

        operator = LinearOperator((size, size), matvec=inverse, dtype=float)
        try:
            values, shapes = eigs(operator, k=NEAREST, v0=begin, tol=1e-3, maxiter=20)
        except ArpackNoConvergence as short:
            values, shapes = short.eigenvalues, short.eigenvectors
        found.append((rate + 1.0 / values, shapes))
    if not found:
        return np.empty(0), np.empty((size, 0))
    return np.concatenate([f[0] for f in found]), np.hstack([f[1] for f in found])
