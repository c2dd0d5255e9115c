"""u = Σ V (a/r)^k P(c) b: a flow as a table of polynomials, and its curl, divergence and Laplacian.

A sphere of radius a whose slip is uniaxial about the unit vector e sets up, at x = r n from its
centre and with c = e·n, a flow along three vectors only,

    u = u_n n + u_e e + u_x (e × n),      u_b = V Σ_k (a/r)^k P_bk(c),

with polynomials P in rational numbers. The table {(b, k): P_bk} is the flow, and vector calculus on
it is exact.
"""

from __future__ import annotations

from fractions import Fraction

BASIS = ("n", "e", "x")
"""The three vectors of a flow: n, e and x = e × n."""

Polynomial = tuple[Fraction, ...]
"""Coefficients of 1, c, c², …"""

FlowTable = dict[tuple[str, int], Polynomial]
"""The polynomial in c for each basis vector and power of a/r."""


def curl(table: FlowTable) -> FlowTable:
    """a ∇ × (u_n n + u_e e + u_x e × n), term by term, on a table in powers of s = a/r.

    With ∇c = (e − c n)/r:
        ∇ × (f n)     = (f_c / r) e × n
        ∇ × (g e)     = (c g_c / r − g_r) e × n
        ∇ × (h e × n) = (h_r + h/r) e + [c h/r − c h_r − (1 − c²) h_c / r] n
    and a monomial s^k has r ∂/∂r = −k.
    """
    result: FlowTable = {}
    for (basis, k), p in table.items():
        slope = _derivative(p)
        if basis == "n":
            _accumulate(result, ("x", k + 1), slope)
        elif basis == "e":
            _accumulate(result, ("x", k + 1), _shift(slope, 1))
            _accumulate(result, ("x", k + 1), tuple(k * q for q in p))
        else:
            _accumulate(result, ("e", k + 1), tuple((1 - k) * q for q in p))
            _accumulate(result, ("n", k + 1), tuple((1 + k) * q for q in _shift(p, 1)))
            _accumulate(result, ("n", k + 1), tuple(-q for q in slope))
            _accumulate(result, ("n", k + 1), _shift(slope, 2))
    return clean(result)


def divergence(table: FlowTable) -> FlowTable:
    """a ∇·u, keyed ("n", k): ∇·(f n) = f_r + 2f/r and ∇·(g e) = c g_r + (1 − c²) g_c/r."""
    result: FlowTable = {}
    for (basis, k), p in table.items():
        slope = _derivative(p)
        if basis == "n":
            _accumulate(result, ("n", k + 1), tuple((2 - k) * q for q in p))
        elif basis == "e":
            _accumulate(result, ("n", k + 1), tuple(-k * q for q in _shift(p, 1)))
            _accumulate(result, ("n", k + 1), slope)
            _accumulate(result, ("n", k + 1), tuple(-q for q in _shift(slope, 2)))
    return clean(result)


def laplacian(table: FlowTable) -> FlowTable:
    """a²∇²u = −a² ∇ × (∇ × u) of a flow without divergence."""
    return scale(curl(curl(table)), Fraction(-1))


def _derivative(p: Polynomial) -> Polynomial:
    return tuple(m * q for m, q in enumerate(p))[1:]


def _shift(p: Polynomial, by: int) -> Polynomial:
    return (Fraction(0),) * by + tuple(p)


def _accumulate(table: FlowTable, key: tuple[str, int], p: Polynomial) -> None:
    old = table.get(key, ())
    longest = max(len(old), len(p))
    pad = [tuple(q) + (Fraction(0),) * (longest - len(q)) for q in (old, p)]
    table[key] = tuple(a + b for a, b in zip(*pad, strict=True))


def add(first: FlowTable, second: FlowTable) -> FlowTable:
    """The sum of two flows."""
    result = dict(first)
    for key, p in second.items():
        _accumulate(result, key, p)
    return clean(result)


def scale(table: FlowTable, factor: Fraction) -> FlowTable:
    """The flow times a number."""
    return {key: tuple(factor * q for q in p) for key, p in table.items()}


def clean(table: FlowTable) -> FlowTable:
    """The table without trailing zeros and without rows that vanish."""
    result: FlowTable = {}
    for key, p in table.items():
        while p and p[-1] == 0:
            p = p[:-1]
        if p:
            result[key] = p
    return result


def flux(flow: FlowTable) -> Fraction:
    """∫ u·n dΩ/2πV at r = a of a flow without divergence: only terms in 1/r² contribute."""
    along = ((flow.get(("n", 2), ()), 0), (flow.get(("e", 2), ()), 1))
    terms = [(m + shift, q) for row, shift in along for m, q in enumerate(row)]
    return sum((2 * q / (m + 1) for m, q in terms if m % 2 == 0), Fraction(0))
