"""⟨l_{i−1} × l_i · l_{i+1}⟩/d³: the hand of a coil, its size and the error of the size.

l_i are the links of a chain of rest spacing d. Three in a row span a volume. It is positive on a
right-handed coil, negative on a left-handed one and 0 on a plane curve, however the chain lies in
space. On a helix (i d, A cos iθ, ±A sin iθ) each is ±8 (A/d)² sin²(θ/2) sin θ (1 − cos θ) d³, which
tends to ±(A/d)² θ⁵ d³ for small θ, as the curvature Aq² squared and the torsion q = θ/d say.

With independent noise ε in each coordinate, the volume V = Σ l_i·(b_i × b_{i+1}),
b_i = l_i − l_{i−1}, has the variance Σ_m ε^{2m} |∇^m V|²/m!, m = 1, 2, 3, where the derivatives are
those of the chain without noise: V is harmonic, and its mean is not shifted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.analysis.measured_chain import NOISE, Array, links_of, positions_of, real_number
from nrchain.notebook import record_html
from nrchain.scene.scene import Scene
from nrchain.trajectory.trajectory import Trajectory
from nrchain.wording import brief

FEWEST = 4
"""The fewest spheres of an open chain that need not lie in one plane."""

SURE = 5.0
"""Standard errors by which a size must differ from 0 to have a hand. The volume of a straight chain
of four spheres with noise has a Laplace distribution, and exceeds this once in a thousand times."""


@dataclass(frozen=True, slots=True, eq=False)
class Handedness:
    """The hand of a chain over time.

    Attributes
    ----------
    time
        (T,).
    hand
        (T,) Σ v_i/Σ |v_i| of the volumes v_i: 1 if the whole coil is right-handed, −1 if it is
        left-handed, in between if it is mixed, and nan if ``size`` is not above :data:`SURE` times
        its ``error``.
    size
        (T,) ⟨v_i⟩/d³, with the sign of the hand.
    error
        (T,) standard error of the size.
    """

    time: Array
    hand: Array
    size: Array
    error: Array

    __repr__ = brief
    _repr_html_ = record_html


def handedness(trajectory: Trajectory, *, noise: float | None = None) -> Handedness:
    """⟨l_{i−1} × l_i · l_{i+1}⟩/d³ with its error, and the hand where it is significant.

    Parameters
    ----------
    noise
        Standard deviation of each coordinate, a length. When None, the uncertainty from the
        tolerances of the run: :data:`~nrchain.analysis.measured_chain.NOISE` times (``atol`` a +
        ``rtol`` times the distance of the spheres from a line). Rounding is added to it.

    The result does not depend on how the chain lies in space. Open chains of fewer than four
    spheres have no hand. The error assumes independent noise of all coordinates; spheres that move
    together bend the chain less.

    Raises :class:`~nrchain.analysis.measured_chain.MeasurementError` for noise that is not a finite
    number of at least 0.

    >>> found = handedness(nrchain.simulate(nrchain.load_scene("helix-right")))
    >>> found.hand[0], found.size[0] > 5 * found.error[0]
    (1.0, True)
    """
    links, scene = links_of(trajectory), trajectory.scene
    positions = positions_of(trajectory)
    given = _noise_of(scene, positions) if noise is None else real_number("noise", noise, least=0.0)
    scatter = given + np.spacing(np.abs(positions).max(axis=(1, 2)))
    periodic = scene.chain.ends == "periodic"
    snapshots, spheres = positions.shape[:2]
    if not periodic and spheres < FEWEST:
        nothing = np.zeros(snapshots)
        return Handedness(trajectory.time, nothing + math.nan, nothing, nothing)
    triples = _triples(links, periodic)
    a, b, c = triples
    # in terms of the bends: on a nearly straight chain a·(b × c) would be rounding
    volumes = np.einsum("tik,tik->ti", b, np.cross(b - a, c - b))
    unit = volumes.shape[1] * scene.chain.spacing**3
    size = volumes.sum(axis=1) / unit
    error = np.sqrt(_variance(triples, scatter, spheres)) / unit
    sure = np.abs(size) > SURE * error
    total = np.abs(volumes).sum(axis=1)
    hand = np.divide(volumes.sum(axis=1), total, out=np.full(snapshots, math.nan), where=sure)
    return Handedness(trajectory.time, hand, size, error)


def _noise_of(scene: Scene, positions: Array) -> Array:
    """(T,) uncertainty of the coordinates from the tolerances of the run."""
    centred = positions - positions.mean(axis=1, keepdims=True)
    if scene.chain.ends == "periodic":
        square = (centred[..., 1:] ** 2).sum(axis=(1, 2))
    else:
        # the largest of the three principal extents is along the chain
        square = (np.linalg.svd(centred, compute_uv=False)[:, 1:] ** 2).sum(axis=1)
    across = np.sqrt(square / positions.shape[1])
    return NOISE * (scene.run.atol * scene.chain.radius + scene.run.rtol * across)


def _triples(links: Array, periodic: bool) -> tuple[Array, Array, Array]:
    """(T, K, 3) each: the links a, b, c of every volume, those over the seam included."""
    if periodic:
        links = np.concatenate([links, links[:, :2]], axis=1)
    return links[:, :-2], links[:, 1:-1], links[:, 2:]


def _variance(links: tuple[Array, Array, Array], noise: Array, spheres: int) -> Array:
    """(T,) variance of Σ v_i from noise (T,) of each coordinate, by the equation of the module."""
    count, square = links[0].shape[1], noise**2
    first = square * _slope_square(links, spheres)
    second = 2.0 * square**2 * _curvature_square(links, spheres)
    # n·(n × n) of three spheres: two terms a volume remain, since neighbours share two that cancel;
    # around a ring of up to five spheres those two cancel as well
    ring = 2 * count if spheres > 5 else 0
    third = 6.0 * square**3 * (ring if count == spheres else 2 * count + 2)
    # noise in the measured chain changes the first term, on average by twice the second
    return np.maximum(first - second, second) + third


def _slope_square(links: tuple[Array, Array, Array], spheres: int) -> Array:
    """(T,) Σ_i |∂V/∂r_i|², where V = Σ a·(b × c) with a = r₁ − r₀ and so on."""
    a, b, c = links
    from_a, from_b, from_c = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    slopes = np.zeros((len(a), spheres, 3))
    first = np.arange(a.shape[1])
    for place, slope in enumerate((-from_a, from_a - from_b, from_b - from_c, from_c)):
        slopes[:, (first + place) % spheres] += slope
    return (slopes**2).sum(axis=(1, 2))


def _curvature_square(links: tuple[Array, Array, Array], spheres: int) -> Array:
    """(T,) Σ_{i<j} |W_ij|² of V's second order Σ_{i<j} W_ij·(n_i × n_j) in displacements n."""
    a, b, c = links
    first = np.arange(a.shape[1])
    of_pairs = {(0, 1): c, (1, 2): a + b + c, (2, 3): a, (0, 2): -b - c, (1, 3): -a - b, (0, 3): b}
    ends = [((first + i) % spheres, (first + j) % spheres) for i, j in of_pairs]
    i, j = (np.concatenate(end) for end in zip(*ends, strict=True))
    terms = np.concatenate(list(of_pairs.values()), axis=1)
    # around a short ring a pair occurs from both sides; n × n of one sphere is 0
    terms = terms * np.sign(j - i)[:, None]
    pairs, places = np.unique(np.minimum(i, j) * spheres + np.maximum(i, j), return_inverse=True)
    total = np.zeros((len(a), len(pairs), 3))
    for term, place in zip(terms.transpose(1, 0, 2), places.ravel(), strict=True):
        total[:, place] += term
    return (total**2).sum(axis=(1, 2))
