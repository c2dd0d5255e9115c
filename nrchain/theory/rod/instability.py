"""Λ*(q*) with dΛ/dq = 0: is an instability absolute, convective, or is the rod stable?

The response of an infinite rod to a push at one point is ∫ exp(iqs + Λ(q)t) dq. At a fixed point it
grows as exp(Λ* t), where q* is the saddle of Λ in the complex plane with the largest Re Λ* through
which the integral can be led. That is a pinch (Briggs, 1964): two wavenumbers of D(Λ, q) = 0 that
merge at q* for Λ = Λ* come from opposite halves of the plane as Re Λ falls from values above all
growth of real q. With Re Λ* > 0 the push grows where it was given, and the instability is absolute.
Otherwise it is convective if waves of some real q grow: packets grow while they leave.

Which it is depends on the observer. Λ is that at a fixed point of the material; an observer who
moves at v along the rod sees Λ + iqv.

Source: P. Huerre and P. A. Monkewitz, Annu. Rev. Fluid Mech. 22, 473 (1990).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, NamedTuple, get_args

import numpy as np

from nrchain.errors import SceneError
from nrchain.notebook import record_html
from nrchain.theory.eigenvalues import follow
from nrchain.theory.lattice import Frame
from nrchain.theory.rod.material import Material
from nrchain.theory.rod.symbol import Complex, Symbol, beam_symbol, rod_symbol
from nrchain.wording import brief

Kind = Literal["stable", "convective", "absolute"]
KINDS = get_args(Kind)

STARTS = 8
"""Starts of Newton's method along each axis of complex q, within :data:`WIDTH` growing bands."""

WIDTH = 1.5

NEWTON = 40
"""Most steps of Newton's method."""

CONVERGED = 1e-11
"""Newton's method ends at steps of this size relative to q, or where rounding stops it."""

SAME = 1e-6
"""Saddles nearer than this, relative to the scale of q, are one."""

ROUNDING = 1e-13
"""Error of a rate, relative to the largest at its wavenumber."""

MARGIN = 1e-9
"""Part of the largest growth by which that of a pinch may exceed it."""

NEAR = 0.01
"""Start of that path: the root of its height, over that of its end."""

TINY = 1e-300

FAR = 1e3
"""Wavenumber at which growth must fall, over that beyond which the highest derivatives rule."""

HEIGHTS = 60
"""Points of the path along which merging wavenumbers are led apart."""


@dataclass(frozen=True)
class Instability:
    """Where a push grows: at its place, only as it leaves, or not at all.

    Attributes
    ----------
    kind
        "stable", "convective" or "absolute".
    growth, fastest
        The largest Re Λ of real q, and its q.
    rate, wavenumber
        Λ* and q* of the pinch; NaN for a stable rod.
    slope
        |q* dΛ/dq| over |Λ*|, which vanishes at a saddle.
    residual
        The smallest singular value of W − Λ*Γ over the largest, which vanishes on a branch.
    apart
        Im q of the two wavenumbers that merge, led to Re Λ above all growth: of opposite signs.
    """

    kind: Kind
    growth: float
    fastest: float
    rate: complex = complex(math.nan, math.nan)
    wavenumber: complex = complex(math.nan, math.nan)
    slope: float = math.nan
    residual: float = math.nan
    apart: tuple[float, float] = (math.nan, math.nan)

    __repr__ = brief
    _repr_html_ = record_html


def rod_instability(
    material: Material, *, velocity: float = 0.0, beam: bool = True, frame: Frame = "lab"
) -> Instability:
    """Whether the straight rod of a material is absolutely or convectively unstable.

    ``velocity`` is that of the observer along the material: 0 moves with the spheres, −V⁰ is at
    rest in the lab. ``beam`` takes the beam limit. q* has a real part of 0 or more; the wave of the
    other hand has −q̄* and Λ̄*.

    Raises :class:`~nrchain.errors.SceneError` as :func:`nrchain.rod.rod_waves`, and for a rod whose
    growth has no bound as q → ∞.
    """
    symbol = (beam_symbol if beam else rod_symbol)(material, frame=frame).moving(velocity)
    parts = _uncoupled(symbol) if material.symmetry.isotropic else [symbol]
    found = max(map(instability, parts), key=_rank)
    if found.wavenumber.real >= 0.0 or found.kind == "stable":
        return found
    # displacements are real: with (q, Λ) also (−q̄, Λ̄) is a wave, of the other hand
    q, rate = -found.wavenumber.conjugate(), found.rate.conjugate()
    return replace(found, fastest=-found.fastest, wavenumber=q, rate=rate)


def _rank(found: Instability) -> tuple[int, float]:
    """The part that rules the response: absolute first, then by the growth of its pinch."""
    stable = found.kind == "stable"
    return KINDS.index(found.kind), found.growth if stable else found.rate.real


def _uncoupled(symbol: Symbol) -> Iterator[Symbol]:
    """The symbols of the waves of a transversely isotropic rod: both hands, and along its axis."""
    k = symbol.wrench.shape[1]
    across, along = ([(0, 1)], [2]) if k == 3 else ([(1, 2), (4, 5)], [0, 3])
    for hand in (1.0, -1.0):
        basis = np.zeros((k, len(across)), complex)
        for n, (y, z) in enumerate(across):
            basis[[y, z], n] = np.sqrt(0.5) * np.array([1.0, -1j * hand])
        yield symbol.between(basis.conj()[None], basis[None])
    axis = np.eye(k)[None, :, along]
    yield symbol.between(axis, axis)


def instability(symbol: Symbol) -> Instability:
    """Whether waves of a symbol are absolutely or convectively unstable.

    >>> from nrchain import rod
    >>> swept = rod.Symbol([[[1.0]], [[-3.0]], [[1.0]]], [[[1.0]]])  # Λ = 1 − 3iq − q²
    >>> rod.instability(swept).kind
    'convective'
    """
    scale = _scale(symbol)
    growth, fastest, band, size = _fastest(symbol, scale)
    if growth <= ROUNDING * size:
        return Instability("stable", growth, fastest)
    found = []
    for q, rate, bend in _saddles(symbol, band):
        if rate.real <= growth * (1.0 + MARGIN) + ROUNDING * size:
            apart = _led_apart(symbol, q, rate, bend, growth)
            if apart[0] * apart[1] < 0.0:
                found.append((rate.real, q, rate, apart))
    if not found:
        allowed = "has no pinch among the saddles that were found: it cannot be classified"
        raise SceneError("symbol", f"growth {growth:.3g} at q = {fastest:.3g}", allowed)
    # of saddles of equal growth, the one of positive q
    _, q, rate, apart = max(found, key=lambda f: (round(f[0] / growth, 6), f[1].real))
    values, slopes = _branches(symbol, q)
    slope = abs(slopes[np.argmin(np.abs(values - rate))] * q) / max(abs(rate), growth)
    wrench, drag = symbol.at(q)
    singular = np.linalg.svd(wrench - rate * drag, compute_uv=False)
    largest = max(float(np.abs(wrench).max()), float(np.abs(rate * drag).max()))
    kind: Kind = "absolute" if rate.real > ROUNDING * size else "convective"
    residual = float(singular[-1]) / largest
    return Instability(kind, growth, fastest, rate, q, float(slope), residual, apart)


def _scale(symbol: Symbol) -> float:
    """A wavenumber beyond which the highest derivatives rule; refuse growth without bound there."""
    sizes = [float(np.abs(part).max()) for part in symbol.wrench]
    orders = [n for n, size in enumerate(sizes) if size > 0.0]
    if not orders or orders[-1] == 0:
        raise SceneError("wrench", symbol.wrench.tolist(), "has no derivatives: no wave travels")
    *lower, top = orders
    scale = max(((sizes[n] / sizes[top]) ** (1.0 / (top - n)) for n in lower), default=1.0)
    nearer, far = (
        max(_branches(symbol, sign * q)[0].real.max() for sign in (1.0, -1.0))
        for q in (FAR * scale / 2.0, FAR * scale)
    )
    if far > 0.0 and far > nearer:
        allowed = "grows without bound as q → ∞: the rod is no theory of waves this short"
        raise SceneError("growth", float(far), allowed)
    return scale


def _fastest(symbol: Symbol, scale: float) -> tuple[float, float, float, float]:
    """The largest growth of real q, its q, the largest growing |q|, and the size of the rates."""
    from scipy.optimize import minimize_scalar

    waves = np.geomspace(1e-4 * scale, 10.0 * scale, 400)
    waves = np.concatenate([-waves[::-1], [0.0], waves])
    wrench = np.linalg.eigvals(symbol.operator(waves))
    growth = wrench.real.max(axis=-1)
    best = int(np.argmax(growth))
    band = float(np.abs(waves[growth > MARGIN * growth[best]]).max(initial=0.0))
    low, high = waves[max(best - 1, 0)], waves[min(best + 1, len(waves) - 1)]
    refined = minimize_scalar(
        lambda q: -_branches(symbol, q)[0].real.max(),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-9 * (high - low)},
    )
    values = _branches(symbol, refined.x)[0]
    size = float(np.abs(values).max())
    return float(values.real.max()), float(refined.x), max(band, 1e-4 * scale), size


def _branches(symbol: Symbol, q: complex) -> tuple[Complex, Complex]:
    """Λ and dΛ/dq (k,) at one complex wavenumber."""
    (wrench, drag), (changed, dragged) = symbol.at(q), symbol.slopes(q)
    M = np.linalg.solve(drag, wrench)
    values, vectors = np.linalg.eig(M)
    change = np.linalg.solve(drag, changed - dragged @ M)
    try:
        slopes = np.diagonal(np.linalg.solve(vectors, change @ vectors))
    except np.linalg.LinAlgError:
        slopes = np.full(values.shape, complex(math.inf, 0.0))
    return values, slopes


class _Saddle(NamedTuple):
    """q*, Λ* and d²Λ/dq²."""

    wavenumber: complex
    rate: complex
    bend: complex


def _saddles(symbol: Symbol, band: float) -> list[_Saddle]:
    """The saddles that Newton's method finds from a grid of complex q."""
    ends = np.linspace(-WIDTH, WIDTH, STARTS) * band
    found: list[_Saddle] = []
    for start in (complex(x, y) for x in ends for y in ends):
        for branch in range(symbol.wrench.shape[1]):
            saddle = _newton(symbol, start, branch, band)
            if saddle is not None and not any(_same(saddle, other, band) for other in found):
                found.append(saddle)
    return found


def _same(one: _Saddle, other: _Saddle, band: float) -> bool:
    size = max(abs(one.rate), abs(other.rate), abs(one.bend) * band**2)
    near = abs(one.wavenumber - other.wavenumber) <= SAME * band
    return near and abs(one.rate - other.rate) <= SAME * size


def _newton(symbol: Symbol, q: complex, branch: int, band: float) -> _Saddle | None:
    """The saddle that Newton's method finds from q on one branch, or None."""
    values, slopes = _branches(symbol, q)
    rate, slope = values[branch], slopes[branch]
    step, last = 1e-4 * band, math.inf
    for _ in range(NEWTON):
        ahead, behind = (_on_branch(symbol, q + s, rate + slope * s) for s in (step, -step))
        bend = (ahead[1] - behind[1]) / (2.0 * step)
        if bend == 0.0 or not np.isfinite(bend):
            return None
        move = -slope / bend
        move *= min(1.0, 0.5 * band / max(abs(move), TINY))
        q, (rate, slope) = q + move, _on_branch(symbol, q + move, rate + slope * move)
        if abs(q) > 100.0 * band or not np.isfinite(slope):
            return None
        size = abs(move) / max(abs(q), band)
        if size <= CONVERGED or last <= size <= SAME:
            return _Saddle(q, rate, bend)
        last = size
    return None


def _on_branch(symbol: Symbol, q: complex, expected: complex) -> tuple[complex, complex]:
    """Λ and dΛ/dq of the branch nearest to an expected Λ."""
    values, slopes = _branches(symbol, q)
    nearest = int(np.argmin(np.abs(values - expected)))
    return complex(values[nearest]), complex(slopes[nearest])


def _led_apart(
    symbol: Symbol, q: complex, rate: complex, bend: complex, growth: float
) -> tuple[float, float]:
    """Im q of the two wavenumbers that merge at a saddle, at Re Λ above all growth of real q."""
    height = 2.0 * growth - rate.real
    heights = np.asarray(rate + height * np.linspace(NEAR, 1.0, HEIGHTS) ** 2, complex)
    # Λ − Λ* = ½ Λ″ (q − q*)²
    half = np.sqrt(2.0 * (heights[0] - rate) / bend)
    first = wavenumbers(symbol, heights[0])
    merged = [int(np.argmin(np.abs(first - (q + side)))) for side in (half, -half)]
    paths = follow(partial(wavenumbers, symbol), heights)
    low, high = paths[-1][merged].imag
    return float(low), float(high)


def wavenumbers(symbol: Symbol, rate: complex) -> Complex:
    """All q with D(Λ, q) = det(W(q) − Λ Γ(q)) = 0 at one Λ: a polynomial eigenproblem."""
    from scipy.linalg import eig

    size = max(len(symbol.wrench), len(symbol.drag))
    k = symbol.wrench.shape[1]
    terms = np.zeros((size, k, k), complex)
    terms[: len(symbol.wrench)] += symbol.wrench
    terms[: len(symbol.drag)] -= rate * symbol.drag
    unit = _unit(terms)
    terms *= (unit ** np.arange(size))[:, None, None]
    order = size - 1
    left, right = np.eye(order * k, dtype=complex), np.eye(order * k, k=k, dtype=complex)
    left[-k:, -k:] = terms[-1]
    right[-k:] = -np.concatenate(terms[:-1], axis=1)
    with np.errstate(all="ignore"):
        alpha, beta = eig(right, left, right=False, homogeneous_eigvals=True)
        finite = np.abs(beta) > 1e-13 * np.abs(alpha)
    return np.asarray(-1j * unit * alpha[finite] / beta[finite], complex)


def _unit(terms: np.ndarray) -> float:
    """A slope at which the first and the last term are of one size."""
    sizes = np.abs(terms).max(axis=(1, 2))
    kept = np.nonzero(sizes)[0]
    if len(kept) < 2:
        return 1.0
    return float((sizes[kept[0]] / sizes[kept[-1]]) ** (1.0 / (kept[-1] - kept[0])))
