"""1/|x − y| = Σ_a R_a(y) S_a(x) for |y| < |x|: real solid harmonics and how they shift.

R_a are the regular and S_a the irregular solid harmonics of degree l and order m,

    R_lm = r^l P_l^m(cos θ) e^{imφ}/(l + m)!,      S_lm = (l − m)! P_l^m(cos θ) e^{imφ}/r^(l+1),

split into their real and imaginary parts, with S doubled where m > 0. The index a is l² for m = 0,
l² + 2m − 1 for the real and l² + 2m for the imaginary part, so that degrees up to p are the first
(p + 1)² entries. One table of small integers G holds every shift:

    R_c(x + y)  = Σ_ab G_cab R_a(x) R_b(y),
    1/|X + x − y| = Σ_ab R_a(x) R_b(y) (−1)^l_a Σ_c G_cab S_c(X),      l_c = l_a + l_b.

For each a and b, G_cab differs from zero for two c at most.

Source: Hobson, *The Theory of Spherical and Ellipsoidal Harmonics*, Sec. 88; Dehnen, Comput.
Astrophys. Cosmol. 1 (2014) 1, Sec. 3, for this scaling and its recurrences.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from nrchain._compile import kernel

LANES = 32
"""Sources whose irregular harmonics are computed side by side."""

UNITS = ((2, -0.5), (3, -0.5), (1, 1.0))
"""∂_k R_a of the three harmonics of degree 1: the index a and the slope, for k = x, y, z."""


class Coupling(NamedTuple):
    """G_cab up to a degree: c and G_cab of the two terms of each a and b, (n, n) each."""

    first: np.ndarray
    second: np.ndarray
    first_weight: np.ndarray
    second_weight: np.ndarray


@cache
def coupling(degree: int) -> Coupling:
    """The table G of harmonics a and b up to this degree."""
    count = (degree + 1) ** 2
    table = Coupling(
        *(np.zeros((count, count), np.int32) for _ in range(2)),
        *(np.zeros((count, count)) for _ in range(2)),
    )
    _fill_coupling(degree, *table)
    return table


@kernel
def _index(ell, m, part):
    """The place of a harmonic; part 0 is real and 1 imaginary."""
    return ell * ell if m == 0 else ell * ell + 2 * m - 1 + part


@kernel
def _fill_coupling(degree, first, second, first_weight, second_weight):
    """From R_lm(x + y) = Σ R_l′m′(x) R_l″m″(y) over all m′ + m″ = m, and R_l−m = (−1)^m R_lm*."""
    for ell in range(degree + 1):
        for m in range(ell + 1):
            for part in range(1 if m == 0 else 2):
                a = _index(ell, m, part)
                for k in range(degree + 1):
                    for n in range(k + 1):
                        for other in range(1 if n == 0 else 2):
                            b = _index(k, n, other)
                            kind = (part + other) % 2
                            first[a, b] = _index(ell + k, m + n, kind)
                            first_weight[a, b] = -1.0 if part + other == 2 else 1.0
                            if m == 0 or n == 0:
                                continue
                            sign = -1.0 if min(m, n) % 2 else 1.0
                            if m == n:
                                sign = 0.0 if kind else 2.0 * sign
                            elif kind and (part == 0) == (m > n):
                                sign = -sign
                            if sign != 0.0:
                                second[a, b] = _index(ell + k, abs(m - n), kind)
                                second_weight[a, b] = sign


@kernel(alone=True)
def fill_regular(x, y, z, degree, out):
    """out[a] = R_a(x, y, z) up to a degree."""
    square, re, im = x * x + y * y + z * z, 1.0, 0.0
    for m in range(degree + 1):
        if m:
            re, im = -(x * re - y * im) / (2 * m), -(x * im + y * re) / (2 * m)
        below_re, below_im, this_re, this_im = 0.0, 0.0, re, im
        for ell in range(m, degree + 1):
            if ell > m:
                scale = 1.0 / (ell * ell - m * m)
                next_re = ((2 * ell - 1) * z * this_re - square * below_re) * scale
                next_im = ((2 * ell - 1) * z * this_im - square * below_im) * scale
                below_re, below_im, this_re, this_im = this_re, this_im, next_re, next_im
            out[_index(ell, m, 0)] = this_re
            if m:
                out[_index(ell, m, 1)] = this_im


@kernel(alone=True)
def fill_irregular(points, degree, out):
    """out[a, lane] = S_a of the ``points`` (3, LANES) up to a degree, m > 0 doubled."""
    lanes = points.shape[1]
    for lane in range(lanes):
        x, y, z = points[0, lane], points[1, lane], points[2, lane]
        inverse = 1.0 / (x * x + y * y + z * z)
        points[0, lane], points[1, lane], points[2, lane] = x * inverse, y * inverse, z * inverse
        points[3, lane] = inverse
        out[0, lane] = np.sqrt(inverse)
    for m in range(degree + 1):
        re, im = _index(m, m, 0), _index(m, m, 1)
        if m:
            old_re, old_im = _index(m - 1, m - 1, 0), _index(m - 1, m - 1, 1)
            factor = -(2.0 * m - 1.0) * (2.0 if m == 1 else 1.0)
            for lane in range(lanes):
                x, y, a = points[0, lane], points[1, lane], out[old_re, lane]
                b = out[old_im, lane] if m > 1 else 0.0
                out[re, lane] = factor * (x * a - y * b)
                out[im, lane] = factor * (x * b + y * a)
        for ell in range(m + 1, degree + 1):
            first, second = 2.0 * ell - 1.0, float((ell - 1) * (ell - 1) - m * m)
            for part in range(1 if m == 0 else 2):
                new, old = _index(ell, m, part), _index(ell - 1, m, part)
                if ell == m + 1:
                    for lane in range(lanes):
                        out[new, lane] = first * points[2, lane] * out[old, lane]
                else:
                    oldest = _index(ell - 2, m, part)
                    for lane in range(lanes):
                        out[new, lane] = (
                            first * points[2, lane] * out[old, lane]
                            - second * points[3, lane] * out[oldest, lane]
                        )
