"""dδ/dt = J(t) δ: how small changes of all poses grow along a motion, by its snapshots.

In axes at rest J = ∂w/∂(u, φ) + [ω_i×] on φ, with the twists w = (v, ω) of the spheres. J is the
exact derivative of the model at the snapshots. Steps go from one snapshot to the next by backward
differences of order 2, which need J nowhere else: no mean of two J has the directions in which a
bent chain is stiff in between. After each step the motions of the chain as a whole are taken out of
δ, and it is made as long as at first; the logarithms of the factors add up to the largest Lyapunov
exponent (Benettin et al., Meccanica 15, 9, 1980). It is 0 on a cycle that attracts, and the growth
rate of the leading mode about a state.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from nrchain.comoving.motions import fields
from nrchain.comoving.relative import DENSE, Point, RelativeChain
from nrchain.effects.base import cross_matrix

RANK = 1e-9
"""Known solutions are independent of others if more than this part of them is not along those."""

FORGOTTEN = 0.2
"""Part of the time after which δ lies along the direction of fastest growth."""

BLOCKS = 8
"""Parts of the rest of the time, whose means scatter as the error says."""

PERIODS = BLOCKS / (1.0 - FORGOTTEN)
"""Periods along which parts are of one period each."""

FEWEST = 5 * BLOCKS
"""Snapshots that are needed."""


def largest_exponent(
    chain: RelativeChain,
    time: np.ndarray,
    positions: np.ndarray,
    frames: np.ndarray,
    beside: bool = False,
) -> tuple[float, float]:
    """λ and its error, from at least :data:`FEWEST` snapshots.

    With ``beside``, of changes beside the motion itself: what only shifts the time is taken out of
    δ as well. On a cycle λ is then ln|μ|/P with the largest multiplier μ but that of time. The
    parts that give the error are of one period if the time is :data:`PERIODS` periods.

    Raises FloatingPointError for tangents that leave the range of floats, and ValueError for
    interactions of all pairs among more than :data:`DENSE` spheres.
    """
    points = [chain.at(poses) for poses in zip(positions, frames, strict=True)]
    tangents = [_tangent(point) for point in points]
    known = [_known(point, beside) for point in points]
    fine = _growth(time, known, tangents)
    coarse = _growth(time[::2], known[::2], tangents[::2])
    rates = [_mean(time, fine, *ends) for ends in _parts(time)]
    value = _mean(time, fine, *_whole(time))
    scatter = float(np.std(rates, ddof=1)) / math.sqrt(BLOCKS)
    step = abs(value - _mean(time[::2], coarse, *_whole(time))) / 3.0
    return value, math.hypot(scatter, step)


def _tangent(point: Point) -> Any:
    """J (n, n) in the coordinates of :mod:`nrchain.comoving.relative`, in axes at rest."""
    from scipy.sparse import block_diag, issparse

    chain = point.chain
    if point.matrix is None:
        raise ValueError(f"more than {DENSE} spheres with interactions of all pairs")
    twists = chain.model.twists(*point.poses)
    own = np.zeros((chain.model.count, 6, 6))
    own[:, :3, :3] = cross_matrix(point.motion.rotation[None])
    own[:, 3:, 3:] = cross_matrix(twists[:, 3:] - point.motion.turn * point.frames[:, 0])
    blocks = block_diag(list(own[chain.free]), format="csc")
    return point.matrix + (blocks if issparse(point.matrix) else blocks.toarray())


def _known(point: Point, beside: bool) -> np.ndarray:
    """(n, k) known solutions δ(t): motions of the chain as a whole, and its motion in time."""
    chain = point.chain
    elementary = fields(*point.poses, chain.origin, chain.length)
    columns = [chain.coordinates(one) for one in elementary]
    known = np.stack(columns, axis=1) @ chain.allowed
    if not beside:
        return known
    return np.column_stack([known, chain.coordinates(chain.model.twists(*point.poses))])


def _growth(time: np.ndarray, known: list[np.ndarray], tangents: list[Any]) -> np.ndarray:
    """(T,) ln of the growth of δ up to each time.

    (1 + 2r) δ₂ − (1 + r)² δ₁ + r² δ₀ = (1 + r) h J₂ δ₂ with steps h and h/r; the first is implicit
    Euler. What δ₂ holds of known solutions is taken out of δ₁ as well.
    """
    here = np.random.default_rng(5).standard_normal(len(known[0]))
    before, last = np.zeros_like(here), math.inf
    total, grown = 0.0, [0.0]
    for k, step in enumerate(np.diff(time)):
        r = step / last
        right = ((1.0 + r) ** 2 * here - r**2 * before) / (1.0 + 2.0 * r)
        ahead = _solve(tangents[k + 1], (1.0 + r) / (1.0 + 2.0 * r) * step, right)
        if known[k].shape[1]:
            parts = np.linalg.lstsq(known[k + 1], ahead, RANK)[0]
            ahead, here = ahead - known[k + 1] @ parts, here - known[k] @ parts
        length = float(np.linalg.norm(ahead))
        if not 0.0 < length < math.inf:
            raise FloatingPointError(f"tangents leave the range of floats at t = {time[k]:.6g}")
        before, here, last = here / length, ahead / length, step
        total += math.log(length)
        grown.append(total)
    return np.array(grown)


def _solve(matrix: Any, step: float, right: np.ndarray) -> np.ndarray:
    """(1 − h J)⁻¹ right."""
    from scipy.sparse import identity, issparse
    from scipy.sparse.linalg import splu

    if issparse(matrix):
        found: np.ndarray = splu((identity(len(right)) - step * matrix).tocsc()).solve(right)
        return found
    return np.linalg.solve(np.eye(len(right)) - step * matrix, right)


def _whole(time: np.ndarray) -> tuple[float, float]:
    """The time that counts."""
    return float(time[0] + FORGOTTEN * (time[-1] - time[0])), float(time[-1])


def _parts(time: np.ndarray) -> list[tuple[float, float]]:
    """Equal parts of the time that counts."""
    ends = np.linspace(*_whole(time), BLOCKS + 1)
    return list(pairwise(ends.tolist()))


def _mean(time: np.ndarray, grown: np.ndarray, begin: float, end: float) -> float:
    """The mean growth rate between two times."""
    return float(np.diff(np.interp([begin, end], time, grown))[0]) / (end - begin)
