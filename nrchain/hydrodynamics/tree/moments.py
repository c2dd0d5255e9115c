"""φ, ψ of one sphere: its slip, force and torque as multipoles about its own centre.

Lengths are in radii and flows are those of :mod:`nrchain.hydrodynamics.tree.passes`,
u = 2φ − ∇(x·φ) + ∇ψ. With Φ_l = P_l(e·n)/ρ^(l+1), whose multipoles are R_a(e) of degree l, a
uniaxial flow is a sum of three kinds of terms for each power k of 1/ρ:

    "along"      φ = e Φ_(k−1)             u = [l c P_l + c (c P_l)′] n + [P_l − c P_l′] e
    "gradient"   ψ = Φ_(k−2)               u = −P_(l+1)′ n + P_l′ e
    "swirl"      φ = ½ e × ∇Φ_(k−2)        u = −P_(l+1)′ e × n

A force f = F/6πηa and a torque τ = T/8πηa² have, with all of Rotne, Prager and Yamakawa's terms for
spheres apart, φ = ¾ f/ρ + ½ τ × x/ρ³ and ψ = ½ f·x/ρ³. At a point of the fluid ψ is half as large.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import leg2poly

from nrchain._compile import kernel
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.flow_tables import FlowTable
from nrchain.hydrodynamics.pair_law import PairLaw
from nrchain.hydrodynamics.tree.harmonics import UNITS, coupling, fill_regular

ALONG, GRADIENT, SWIRL = range(3)

HIGHEST_POWER = 6
"""Highest power of a/r of flows that the tree sums."""

FRICTION_DEGREE = 1
"""Highest degree of the multipoles of a force and a torque."""


class Terms(NamedTuple):
    """One row for each term: axis, mode, kind and degree l, and its factor; by axis."""

    rows: np.ndarray
    factors: np.ndarray

    @property
    def degree(self) -> int:
        """Highest degree of the multipoles."""
        return int(max(self._degrees))

    @property
    def lowest(self) -> int:
        """Lowest degree of the multipoles."""
        return int(min(self._degrees))

    @property
    def _degrees(self) -> np.ndarray:
        """The degree of each term; a swirl has that of ∇Φ_l."""
        return self.rows[:, 3] + (self.rows[:, 2] == SWIRL)


def slip_terms(law: PairLaw) -> Terms | None:
    """The terms of the modes of a law; None if a flow has a power of a/r that is too high."""
    found = []
    for mode, (label, axis) in enumerate(zip(law.labels, law.axis_of, strict=True)):
        flow = law.flow_of(slip_modes.find(label))
        if max(power for _, power in flow) > HIGHEST_POWER:
            return None
        found += [(axis, mode, *term) for term in _terms_of(flow)]
    found.sort(key=lambda term: term[0])
    rows = np.array([term[:4] for term in found], np.int64).reshape(-1, 4)
    return Terms(rows, np.array([term[4] for term in found], float))


def _terms_of(flow: FlowTable) -> list[tuple[int, int, float]]:
    """Kind, degree and factor of each term of a flow, power by power."""
    found = []
    for power in sorted({power for _, power in flow}):
        rows = [[float(q) for q in flow.get((basis, power), ())] for basis in "nex"]
        kinds = [(SWIRL, power - 2)] if rows[2] else [(ALONG, power - 1), (GRADIENT, power - 2)]
        kinds = [(kind, degree) for kind, degree in kinds if degree >= 0]
        columns = np.stack([_stack(_flow_of(*kind)) for kind in kinds], axis=1)
        factors = np.linalg.lstsq(columns, _stack(rows), rcond=None)[0]
        found += [(*kind, f) for kind, f in zip(kinds, factors, strict=True) if abs(f) > 1e-14]
    return found


def _flow_of(kind: int, degree: int) -> list[np.ndarray]:
    """Coefficients along n, e and e × n, in powers of c, of one term."""
    c, p, above = Polynomial([0, 1]), _legendre(degree), _legendre(degree + 1)
    if kind == ALONG:
        return [(degree * c * p + c * (c * p).deriv()).coef, (p - c * p.deriv()).coef, np.zeros(1)]
    if kind == GRADIENT:
        return [(-above.deriv()).coef, p.deriv().coef, np.zeros(1)]
    return [np.zeros(1), np.zeros(1), (-above.deriv()).coef]


def _legendre(degree: int) -> Polynomial:
    return Polynomial(leg2poly([0.0] * degree + [1.0]))


def _stack(rows: list) -> np.ndarray:
    """The three polynomials as one column."""
    return np.concatenate([np.pad(row, (0, HIGHEST_POWER + 2 - len(row))) for row in rows])


@kernel
def _add_term(G, kind, degree, factor, e, zonal, out):
    """out (rows, 4) += one term with the axis e and the multipoles ``zonal`` (n, 1) of Φ_l."""
    for b in range(degree * degree, (degree + 1) * (degree + 1)):
        if kind == ALONG:
            for k in range(3):
                out[b, k] += factor * e[k] * zonal[b, 0]
        elif kind == GRADIENT:
            out[b, 3] += factor * zonal[b, 0]
    if kind == SWIRL:
        first, second, first_weight, second_weight = G
        for k in range(3):
            a, slope = UNITS[k]
            i, j = (k + 1) % 3, (k + 2) % 3
            for b in range(degree * degree, (degree + 1) * (degree + 1)):
                value = -0.5 * factor * slope * zonal[b, 0]
                for c, weight in (
                    (first[a, b], first_weight[a, b]),
                    (second[a, b], second_weight[a, b]),
                ):
                    out[c, j] -= weight * value * e[i]
                    out[c, i] += weight * value * e[j]


@kernel
def _fill_turned(G, degree, turn, zonal, out):
    """out (n, 1) = the change of R_a(e) with a change ``turn`` of e."""
    first, second, first_weight, second_weight = G
    out[:] = 0.0
    for k in range(3):
        a, slope = UNITS[k]
        for b in range(degree * degree):
            value = slope * turn[k] * zonal[b, 0]
            out[first[a, b], 0] += first_weight[a, b] * value
            out[second[a, b], 0] += second_weight[a, b] * value


@kernel
def fill_slip(sources, axes, rows, factors, degree, G, own):
    """own (N, n, 4) = the multipoles of the slip of each sphere; sources as in ``pairs``."""
    zonal, e = np.empty(((degree + 1) ** 2, 1)), np.empty(3)
    own[:] = 0.0
    for j in range(own.shape[0]):
        last = -1
        for term in range(rows.shape[0]):
            axis, mode, kind, ell = rows[term]
            if axis != last:
                e[:] = sources[3 + 3 * axis : 6 + 3 * axis, j]
                fill_regular(e[0], e[1], e[2], degree, zonal[:, 0])
                last = axis
            factor = factors[term] * sources[3 + 3 * axes + mode, j]
            _add_term(G, kind, ell, factor, e, zonal, own[j])


@kernel
def fill_slip_changes(sources, changes, axes, rows, factors, degree, G, own):
    """own (N, n, 4) = the change of :func:`fill_slip` as the axes turn, without displacements."""
    zonal, turned = np.empty(((degree + 1) ** 2, 1)), np.empty(((degree + 1) ** 2, 1))
    e, turn = np.empty(3), np.empty(3)
    own[:] = 0.0
    for j in range(own.shape[0]):
        last = -1
        for term in range(rows.shape[0]):
            axis, mode, kind, ell = rows[term]
            if axis != last:
                e[:] = sources[3 + 3 * axis : 6 + 3 * axis, j]
                turn[:] = changes[3 + 3 * axis : 6 + 3 * axis, j]
                fill_regular(e[0], e[1], e[2], degree, zonal[:, 0])
                _fill_turned(G, degree, turn, zonal, turned)
                last = axis
            factor = factors[term] * sources[3 + 3 * axes + mode, j]
            if kind != GRADIENT:
                _add_term(G, kind, ell, factor, turn, zonal, own[j])
            if ell:
                _add_term(G, kind, ell, factor, e, turned, own[j])


@kernel
def fill_wrenches(vectors, size, own):
    """own (N, n, 4) = the multipoles of f and τ, the rows 3 to 8 of ``vectors``.

    ``size`` is the factor of f·x/ρ³ in ψ: ½ for what a sphere feels, ¼ at a point of the fluid.
    """
    own[:] = 0.0
    for j in range(own.shape[0]):
        for k in range(3):
            p, q = (k + 1) % 3, (k + 2) % 3
            force, torque = vectors[3 + k, j], vectors[6 + k, j]
            own[j, 0, k] = 0.75 * force
            a, slope = UNITS[k]
            own[j, a, 3] = size * slope * force
            a, slope = UNITS[p]
            own[j, a, q] += 0.5 * slope * torque
            a, slope = UNITS[q]
            own[j, a, p] -= 0.5 * slope * torque


@kernel
def add_displaced(G, degree, moves, source, own):
    """own += the change of multipoles ``source`` (N, n, 4) as their spheres move."""
    first, second, first_weight, second_weight = G
    for j in range(own.shape[0]):
        for b in range((degree + 1) * (degree + 1)):
            for k in range(3):
                own[j, b, 3] += moves[k, j] * source[j, b, k]
                a, slope = UNITS[k]
                c1, c2 = first[a, b], second[a, b]
                w1, w2 = first_weight[a, b] * slope, second_weight[a, b] * slope
                for column in range(4):
                    value = moves[k, j] * source[j, b, column]
                    own[j, c1, column] += w1 * value
                    own[j, c2, column] += w2 * value


def strain_multipoles(leading: bool, strain: np.ndarray) -> np.ndarray:
    """(n, 4) of a rigid sphere in the strain ``strain`` = a E, of its stresslet or finite size.

    u = −(5/2) x (x·aE·x)/ρ⁵ has φ = −(5/6) aE·x/ρ³, and u = −(4/3) ∇(x·aE·x/ρ⁵) has
    ψ = −(4/9) aE : ∇∇(1/ρ).
    """
    table = coupling(2)
    own = np.zeros((4 if leading else 9, 4))
    for k, (a, slope) in enumerate(UNITS):
        if leading:
            own[a, :3] = -5 / 6 * slope * strain[:, k]
            continue
        for other, (b, turn) in enumerate(UNITS):
            value = -4 / 9 * slope * turn * strain[k, other]
            own[table.first[a, b], 3] += table.first_weight[a, b] * value
            own[table.second[a, b], 3] += table.second_weight[a, b] * value
    return own
