"""v = A f + B n (n·f) + C τ × n, a ω = ¾C f × n + D τ + E n (n·τ): the mobility of two spheres.

The mobilities are those of Rotne, Prager and Yamakawa for equal spheres, with ρ = r/a, n the unit
vector from the acting to the feeling sphere, f = F/6πηa and τ = T/8πηa²:

           ρ > 2               ρ < 2 (overlapping)
    A      3/4ρ + 1/2ρ³        1 − 9ρ/32
    B      3/4ρ − 3/2ρ³        3ρ/32
    C      1/ρ²                ρ/2 − 3ρ²/16
    D      −1/2ρ³              1 − 27ρ/32 + 5ρ³/64
    E      3/2ρ³               9ρ/32 − 3ρ³/64

A single sphere has v = f and a ω = τ, the limit ρ → 0. All five coefficients have a continuous
slope at ρ = 2.

Source: Wajnryb, Mizerski, Zuk & Szymczak, J. Fluid Mech. 731 (2013) R3. Pair terms are exact to
(a/r)³; lubrication and reflections add terms of order (a/r)⁴.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import kernel, part

COINCIDENT = 1e-80
"""Added to (r/a)²: coincident spheres get a finite distance; rounding hides it for all others."""


@kernel
def coefficients(s, rho):
    """A, B, C, D, E at ρ = 1/s. Both columns are evaluated, which keeps loops free of branches."""
    s2, rho2 = s * s, rho * rho
    s3, rho3 = s2 * s, rho2 * rho
    apart = rho > 2.0
    return (
        0.75 * s + 0.5 * s3 if apart else 1.0 - 9 / 32 * rho,
        0.75 * s - 1.5 * s3 if apart else 3 / 32 * rho,
        s2 if apart else 0.5 * rho - 3 / 16 * rho2,
        -0.5 * s3 if apart else 1.0 - 27 / 32 * rho + 5 / 64 * rho3,
        1.5 * s3 if apart else 9 / 32 * rho - 3 / 64 * rho3,
    )


@part
def coefficient_slopes(s, rho):
    """ρ ∂/∂ρ of A, B, C, D, E."""
    s2, rho2 = s * s, rho * rho
    s3, rho3 = s2 * s, rho2 * rho
    apart = rho > 2.0
    return (
        -0.75 * s - 1.5 * s3 if apart else -9 / 32 * rho,
        -0.75 * s + 4.5 * s3 if apart else 3 / 32 * rho,
        -2.0 * s2 if apart else 0.5 * rho - 3 / 8 * rho2,
        1.5 * s3 if apart else -27 / 32 * rho + 15 / 64 * rho3,
        -4.5 * s3 if apart else 9 / 32 * rho - 9 / 64 * rho3,
    )


@part
def apply_pair(a, b, c, n, own, other):
    """a own + b n (n·own) + c other × n."""
    along = b * (n[0] * own[0] + n[1] * own[1] + n[2] * own[2])
    return (
        a * own[0] + along * n[0] + c * (other[1] * n[2] - other[2] * n[1]),
        a * own[1] + along * n[1] + c * (other[2] * n[0] - other[0] * n[2]),
        a * own[2] + along * n[2] + c * (other[0] * n[1] - other[1] * n[0]),
    )


@part
def apply_change(terms, slopes, n, d, own, d_own, other, d_other):
    """Change of :func:`apply_pair` when r changes by r d: n by d − (n·d) n, and ρ by ρ n·d."""
    a, b, c = terms
    stretch = n[0] * d[0] + n[1] * d[1] + n[2] * d[2]
    da, db, dc = slopes[0] * stretch, (slopes[1] - 2.0 * b) * stretch, (slopes[2] - c) * stretch
    n_own = n[0] * own[0] + n[1] * own[1] + n[2] * own[2]
    along = db * n_own + b * (d[0] * own[0] + d[1] * own[1] + d[2] * own[2])
    along += b * (n[0] * d_own[0] + n[1] * d_own[1] + n[2] * d_own[2])
    across = b * n_own
    p0, p1, p2 = c * other[0], c * other[1], c * other[2]
    q0, q1, q2 = c * d_other[0], c * d_other[1], c * d_other[2]
    q0, q1, q2 = q0 + dc * other[0], q1 + dc * other[1], q2 + dc * other[2]
    r0 = q1 * n[2] - q2 * n[1] + p1 * d[2] - p2 * d[1]
    r1 = q2 * n[0] - q0 * n[2] + p2 * d[0] - p0 * d[2]
    r2 = q0 * n[1] - q1 * n[0] + p0 * d[1] - p1 * d[0]
    return (
        a * d_own[0] + da * own[0] + along * n[0] + across * d[0] + r0,
        a * d_own[1] + da * own[1] + along * n[1] + across * d[1] + r1,
        a * d_own[2] + da * own[2] + along * n[2] + across * d[2] + r2,
    )


@kernel(alone=True)
def sum_twists(sources, radius, me, first, last):
    """Σ_j (v, a ω) at sphere ``me``, over 0 ≤ first ≤ j < last; rows of ``sources``: r, f and τ.

    j is unsigned: an index never counts from the end, and the compiler vectorises the loop.
    """
    shrink, nowhere = 1.0 / radius, COINCIDENT * radius * radius
    v0 = v1 = v2 = w0 = w1 = w2 = 0.0
    for j in range(np.uint64(first), np.uint64(last)):
        x0, x1 = sources[0, me] - sources[0, j], sources[1, me] - sources[1, j]
        x2 = sources[2, me] - sources[2, j]
        distance = np.sqrt(x0 * x0 + x1 * x1 + x2 * x2 + nowhere)
        inverse = 1.0 / distance
        n = (x0 * inverse, x1 * inverse, x2 * inverse)
        a, b, c, d, e = coefficients(radius * inverse, distance * shrink)
        f = (sources[3, j], sources[4, j], sources[5, j])
        t = (sources[6, j], sources[7, j], sources[8, j])
        v, w = apply_pair(a, b, c, n, f, t), apply_pair(d, e, 0.75 * c, n, t, f)
        v0, v1, v2 = v0 + v[0], v1 + v[1], v2 + v[2]
        w0, w1, w2 = w0 + w[0], w1 + w[1], w2 + w[2]
    return v0, v1, v2, w0, w1, w2


@kernel(alone=True)
def sum_changes(sources, changes, radius, me, first, last):
    """Change of :func:`sum_twists` with ``changes`` of the rows of ``sources``."""
    shrink, nowhere = 1.0 / radius, COINCIDENT * radius * radius
    v0 = v1 = v2 = w0 = w1 = w2 = 0.0
    for j in range(np.uint64(first), np.uint64(last)):
        x0, x1 = sources[0, me] - sources[0, j], sources[1, me] - sources[1, j]
        x2 = sources[2, me] - sources[2, j]
        distance = np.sqrt(x0 * x0 + x1 * x1 + x2 * x2 + nowhere)
        inverse = 1.0 / distance
        n = (x0 * inverse, x1 * inverse, x2 * inverse)
        y0, y1 = changes[0, me] - changes[0, j], changes[1, me] - changes[1, j]
        y2 = changes[2, me] - changes[2, j]
        dr = (y0 * inverse, y1 * inverse, y2 * inverse)
        s, rho = radius * inverse, distance * shrink
        a, b, c, d, e = coefficients(s, rho)
        da, db, dc, dd, de = coefficient_slopes(s, rho)
        f = (sources[3, j], sources[4, j], sources[5, j])
        df = (changes[3, j], changes[4, j], changes[5, j])
        t = (sources[6, j], sources[7, j], sources[8, j])
        dt = (changes[6, j], changes[7, j], changes[8, j])
        v = apply_change((a, b, c), (da, db, dc), n, dr, f, df, t, dt)
        w = apply_change((d, e, 0.75 * c), (dd, de, 0.75 * dc), n, dr, t, dt, f, df)
        v0, v1, v2 = v0 + v[0], v1 + v[1], v2 + v[2]
        w0, w1, w2 = w0 + w[0], w1 + w[1], w2 + w[2]
    return v0, v1, v2, w0, w1, w2
