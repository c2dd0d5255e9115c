"""J x = Λ x, ℓᴴ J = Λ ℓᴴ, ℓᴴ x = 1: right and left modes of given rates, modulo motions as a whole.

Each group of equal rates is found by inverse iteration with J − σ and its adjoint, bordered by the
motions as a whole. The Rayleigh quotients of right and left modes are the rates to second order.
The error of a rate Λ has three parts: rounding of the entries of J, ε |ℓ|ᵀ|J||x|; that of the
quotient, sᴴ (J − Λ)⁻¹ r with the residuals r and s of x and ℓ; and the change of Λ over the last
correction of the state.

Beyond :data:`nrchain.comoving.relative.DENSE` spheres with interactions of all pairs there are no
left modes: they and κ are NaN, and the residual stands for the second part of the error, as for
modes that are orthogonal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from nrchain.comoving.bordered import Bordered
from nrchain.comoving.dense import EPSILON
from nrchain.comoving.relative import Point
from nrchain.notebook import record_html
from nrchain.wording import brief

ITERATIONS = 4
"""Inverse iterations: each gains the ratio of distances from the shift, more than 1e3 here."""

EQUAL = 1e-7
"""Rates that differ by less than this fraction are one rate with several modes."""

NEAR, NOISE = 1e-5, 2e-15
"""Inverse iteration takes rates together that differ by less than this fraction, or by rounding, as
a fraction of the largest rate."""

OFF = 1e-9, 1e-3
"""Distance of a shift from its rate, as a fraction: with factors, and with products."""

GUARD = 4
"""Vectors beside those of a group in inverse iteration, which take up modes that are near."""


@dataclass(frozen=True)
class Mode:
    """Λ and its right and left modes; several if the rate is repeated.

    Attributes
    ----------
    rate
        Λ: its real part is the growth rate, its imaginary part the frequency, in 1/time and
        rad/time.
    error
        Estimate of |Λ − Λ_exact|, see :mod:`nrchain.states.modes`.
    right
        (k, N, 6): (u, φ) of every sphere in the lab, modulo motions of the chain as a whole, with
        ‖(u, φ)‖ = 1.
    left
        (k, N, 6): a small change (u, φ) of the state has the amplitude Σ left* · (u, φ) of the
        mode.
    condition
        κ = ‖ℓ‖ ‖x‖ ≥ 1: how much a perturbation of J may change Λ; 1 if modes are orthogonal.
    residual
        ‖J x − Λ x‖.
    vectors
        x and ℓ (n, k) in the coordinates of :mod:`nrchain.comoving.relative`.

    >>> from nrchain import load_scene, spectrum
    >>> leading = spectrum(load_scene("buckling", **{"slip.2s": 40.0})).leading
    >>> bool(leading.rate.real < 0.0), leading.right.shape
    (True, (2, 20, 6))
    """

    rate: complex
    error: float
    right: np.ndarray
    left: np.ndarray
    condition: float
    residual: float
    vectors: tuple[np.ndarray, np.ndarray] = field(repr=False)

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def growth(self) -> float:
        """Re Λ."""
        return self.rate.real

    @property
    def frequency(self) -> float:
        """Im Λ."""
        return self.rate.imag

    @property
    def multiplicity(self) -> int:
        """Number of modes with this rate; of a pair Λ, Λ* that of one of the two."""
        return len(self.right)


def modes_of(point: Point, rates: np.ndarray, number: int) -> tuple[Mode, ...]:
    """The modes of the first rates, at least ``number`` of them with the conjugate ones.

    ``rates`` go from the largest real part on. Of a pair only Im Λ > 0 is given.
    """
    found: list[Mode] = []
    corrected = _corrected(point)
    noise = NOISE * float(np.abs(rates).max(initial=0.0))
    for group in _groups(rates, number, noise):
        found += _refine(point, corrected, group, noise)
    found.sort(key=lambda mode: (-mode.growth, mode.frequency))
    return tuple(found)


def _corrected(point: Point) -> Point:
    """The point after one more correction of the state, where there is one."""
    if not point.largest:
        return point
    return point.moved(-Bordered(point).solve(point.residual))


def _groups(rates: np.ndarray, number: int, noise: float) -> list[np.ndarray]:
    """Rates with Im ≥ 0 in groups that inverse iteration takes together."""
    groups: list[np.ndarray] = []
    counted, left = 0, list(rates[rates.imag >= -EQUAL * np.abs(rates) - noise])
    while left and counted < number:
        first = left[0]
        together = [abs(rate - first) <= NEAR * abs(first) + noise for rate in left]
        group = np.array([rate for rate, near in zip(left, together, strict=True) if near])
        left = [rate for rate, near in zip(left, together, strict=True) if not near]
        groups.append(group)
        counted += len(group) * (1 if _is_real(group, noise) else 2)
    return groups


def _is_real(rates: np.ndarray, noise: float) -> bool:
    return bool(np.all(np.abs(rates.imag) <= EQUAL * np.abs(rates) + noise))


def _refine(point: Point, corrected: Point, group: np.ndarray, noise: float) -> list[Mode]:
    """Modes of a group of near rates."""
    is_real = _is_real(group, noise)
    center = complex(group.mean())
    # off the rates, where the matrix is singular
    off = OFF[point.matrix is None]
    shift = (center.real if is_real else center) * (1.0 + off) + 0.1 * noise
    solver = Bordered(point, shift)
    right, left = _invariant(point, solver, len(group), is_real)
    overlap = left.conj().T @ right
    left = left @ np.linalg.inv(overlap).conj().T
    values, turned = np.linalg.eig(left.conj().T @ point.product(right))
    duals = np.linalg.inv(turned).conj().T
    chosen = np.argsort(np.abs(values - center), kind="stable")[: len(group)]
    right, left, values = right @ turned[:, chosen], left @ duals[:, chosen], values[chosen]
    found = []
    for same in _equal(values, 10.0 * _rounding(point, right, left)):
        rate = complex(values[same].mean())
        turns = not is_real or abs(rate.imag) > EQUAL * abs(rate)
        if is_real and turns and rate.imag < 0.0:
            continue
        pair = _dual_bases(right[:, same], left[:, same], not turns)
        rate = rate if turns else complex(rate.real)
        found.append(_mode(point, corrected, solver, rate, *pair))
    return found


def _invariant(
    point: Point, solver: Bordered, count: int, is_real: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal bases (n, k) of spaces that hold the right and the left modes of a group."""
    generator = np.random.default_rng(3)
    basis, n = point.neutral, point.chain.dimension
    size = n, min(count + GUARD, n - basis.shape[1])
    begin = generator.standard_normal(size)
    if not is_real:
        begin = begin + 1j * generator.standard_normal(size)
    spaces = []
    solves = (solver.solve, solver.solve_adjoint) if solver.is_direct else (solver.solve,)
    for solve in solves:
        space = begin - basis @ (basis.T @ begin)
        for _ in range(ITERATIONS):
            space = np.linalg.qr(solve(space))[0]
        spaces.append(space)
    return spaces[0], spaces[-1]


def _equal(values: np.ndarray, rounding: float) -> list[np.ndarray]:
    """Indices of values that are equal to :data:`EQUAL`, or to rounding."""
    sets: list[list[int]] = []
    for k, value in enumerate(values):
        for one in sets:
            if abs(values[one[0]] - value) <= EQUAL * abs(value) + rounding:
                one.append(k)
                break
        else:
            sets.append([k])
    return [np.array(one) for one in sets]


def _rounding(point: Point, right: np.ndarray, left: np.ndarray) -> float:
    """ε |ℓ|ᵀ|J||x|, the largest of all pairs: what rounding of the entries of J changes."""
    sizes = np.abs(left).T @ (abs(point.near) @ np.abs(right))
    return EPSILON * float(sizes.max(initial=0.0))


def _dual_bases(
    right: np.ndarray, left: np.ndarray, is_real: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Bases (n, k) of the same spaces, the right one orthonormal and the left one dual to it.

    Those of a real rate are real: real and imaginary part of its modes are modes.
    """
    if is_real:
        right, left = _real_span(right), _real_span(left)
    right = np.linalg.qr(right)[0]
    return right, left @ np.linalg.inv(right.conj().T @ left)


def _real_span(vectors: np.ndarray) -> np.ndarray:
    """A real basis (n, k) of a space that holds the conjugate of each of its vectors."""
    parts = np.hstack([vectors.real, vectors.imag])
    return np.linalg.svd(parts, full_matrices=False)[0][:, : vectors.shape[1]]


def _mode(
    point: Point,
    corrected: Point,
    solver: Bordered,
    rate: complex,
    right: np.ndarray,
    left: np.ndarray,
) -> Mode:
    """The mode of a rate with its error; right and left are biorthonormal (n, k)."""
    rest = shape_product(point, right) - rate * right
    rounding = _rounding(point, right, left)
    drift = left.conj().T @ (shape_product(corrected, right) - shape_product(point, right))
    residual, chain = float(np.linalg.norm(rest, 2)), point.chain
    if solver.is_direct:
        quotient = _error_of_quotient(point, solver, rate, rest, right, left)
    else:
        quotient, left = residual, np.full_like(left, np.nan)
    return Mode(
        rate=rate,
        error=rounding + quotient + float(np.abs(drift).max()),
        right=np.stack([chain.poses(x) for x in right.T]),
        left=np.stack([chain.poses(x * chain.units**2) for x in left.T]),
        condition=float(np.linalg.norm(left, 2)) if solver.is_direct else math.nan,
        residual=residual,
        vectors=(right, left),
    )


def _error_of_quotient(
    point: Point,
    solver: Bordered,
    rate: complex,
    rest: np.ndarray,
    right: np.ndarray,
    left: np.ndarray,
) -> float:
    """|sᴴ (J − Λ)⁻¹ r|: the part of the Rayleigh quotient that is of second order in both modes."""
    answer = solver.solve(rest)
    answer -= right @ (left.conj().T @ answer)
    left_rest = point.matrix.conj().T @ left - np.conj(rate) * left
    return float(np.abs(left_rest.conj().T @ answer).max())


def shape_product(point: Point, vectors: np.ndarray) -> np.ndarray:
    """P J P · vectors."""
    basis = point.neutral
    vectors = point.product(vectors - basis @ (basis.T @ vectors))
    return vectors - basis @ (basis.T @ vectors)
