"""From the table of modes to straight-line code: the twist one sphere induces at another.

The modes a scene names become one function of the unit vector n, of s = a/r and of the acting
sphere's axes and strengths, with every coefficient a constant in the text. For 2s alone::

    def pair_twist(law, n0, n1, n2, s1, axes, strengths, j):
        s2 = s1 * s1
        s3 = s2 * s1
        u0 = u1 = u2 = w0 = w1 = w2 = 0.0
        e0, e1, e2 = axes[0, 0, j], axes[0, 1, j], axes[0, 2, j]
        c = e0 * n0 + e1 * n1 + e2 * n2
        x0, x1, x2 = e1 * n2 - e2 * n1, e2 * n0 - e0 * n2, e0 * n1 - e1 * n0
        u_n = strengths[0, j] * s2 * (-1.1666666666666667 + c * c * 3.5)
        ...

so that the compiler sees only the work of those modes. The text is passed to the kernels as a
literal: it is the key under which numba keeps their machine code on disk, and a changed law can
never meet stale code.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import types
from numba.extending import overload

from nrchain import slip_modes
from nrchain._compile import ARITHMETIC
from nrchain.slip_modes import BASIS, PairTable, Polynomial


@dataclass(frozen=True)
class PairLaw:
    """The modes of a scene: labels, one body axis each, and whether sizes are finite.

    Modes that share an axis share the geometry of a pair. ``axes`` lists the distinct unit
    vectors (body components) and ``axis_of[m]`` says which one mode m uses.
    """

    labels: tuple[str, ...]
    axes: tuple[tuple[float, float, float], ...]
    axis_of: tuple[int, ...]
    finite_size: bool = False

    @classmethod
    def of(
        cls, labels: Sequence[str], axes: Sequence[Sequence[float]], finite_size: bool = False
    ) -> PairLaw:
        """The law of modes with the given body axes, which need not be of unit length."""
        units: list[tuple[float, float, float]] = []
        axis_of = []
        for axis in axes:
            vector = np.asarray(axis, float)
            scaled = vector / np.abs(vector).max()
            unit = tuple(float(x) for x in scaled / np.linalg.norm(scaled))
            if unit not in units:
                units.append(unit)
            axis_of.append(units.index(unit))
        return cls(tuple(labels), tuple(units), tuple(axis_of), finite_size)

    @cached_property
    def source(self) -> str:
        """The text of ``pair_twist`` and ``pair_derivative`` for these modes."""
        flows, spins = [], []
        for label in self.labels:
            mode = slip_modes.find(label)
            flows.append(mode.flow(self.finite_size))
            spins.append(mode.spin(self.finite_size))
        return _twist_source(self.axis_of, flows, spins) + _derivative_source(
            self.axis_of, flows, spins
        )


def _powers(tables: Sequence[PairTable]) -> list[str]:
    highest = max((k for table in tables for _, k in table), default=1)
    return [f"s{k} = s{k - 1} * s1" for k in range(2, highest + 1)]


def _polynomial(p: Polynomial) -> str:
    """Horner's form in c, without the terms that are absent."""
    text = ""
    for coefficient in reversed(p):
        if text:
            text = "c * " + text
        if coefficient:
            text = f"({float(coefficient)!r} + {text})" if text else repr(float(coefficient))
    return text


def _sum(tables: Sequence[tuple[int, PairTable]], basis: str, part: str) -> str:
    """Σ_modes V s^k P(c) along one basis vector: the value, −r∂/∂r of it, or ∂/∂c."""
    terms = []
    for mode, table in tables:
        for (b, k), p in table.items():
            if b != basis:
                continue
            row = tuple(m * q for m, q in enumerate(p))[1:] if part == "c" else p
            if part == "k":
                row = tuple(k * q for q in p)
            if any(row):
                terms.append(f"strengths[{mode}, j] * s{k} * {_polynomial(row)}")
    return " + ".join(terms)


def _groups(axis_of: Sequence[int], flows, spins):
    """For each distinct axis: its index and the (mode, table) pairs of u and of a w."""
    for group in range(max(axis_of, default=-1) + 1):
        members = [m for m, g in enumerate(axis_of) if g == group]
        yield (
            group,
            (("u", [(m, flows[m]) for m in members]), ("w", [(m, spins[m]) for m in members])),
        )


_VECTORS = {"n": ("n0", "n1", "n2"), "e": ("e0", "e1", "e2"), "x": ("x0", "x1", "x2")}

_FRAME = (
    "e0, e1, e2 = axes[{group}, 0, j], axes[{group}, 1, j], axes[{group}, 2, j]",
    "c = e0 * n0 + e1 * n1 + e2 * n2",
    "x0, x1, x2 = e1 * n2 - e2 * n1, e2 * n0 - e0 * n2, e0 * n1 - e1 * n0",
)


def _twist_source(axis_of, flows, spins) -> str:
    lines = [*_powers([*flows, *spins]), "u0 = u1 = u2 = w0 = w1 = w2 = 0.0"]
    for group, fields in _groups(axis_of, flows, spins):
        lines += [line.format(group=group) for line in _FRAME]
        for field, tables in fields:
            for basis in BASIS:
                if value := _sum(tables, basis, "value"):
                    lines.append(f"f = {value}")
                    lines += [
                        f"{field}{k} += f * {vector}" for k, vector in enumerate(_VECTORS[basis])
                    ]
    lines.append("return u0, u1, u2, w0, w1, w2")
    head = "def pair_twist(law, n0, n1, n2, s1, axes, strengths, j):\n"
    return head + "".join(f"    {line}\n" for line in lines)


_DERIVATIVE_HEAD = (
    # d is the change of the separation x over r and t the rotation of the acting sphere
    "stretch = n0 * d0 + n1 * d1 + n2 * d2",
    "dn0, dn1, dn2 = d0 - stretch * n0, d1 - stretch * n1, d2 - stretch * n2",
)

_DERIVATIVE_FRAME = (
    "de0, de1, de2 = t1 * e2 - t2 * e1, t2 * e0 - t0 * e2, t0 * e1 - t1 * e0",
    "dc = e0 * dn0 + e1 * dn1 + e2 * dn2 + n0 * de0 + n1 * de1 + n2 * de2",
    "dx0 = de1 * n2 - de2 * n1 + e1 * dn2 - e2 * dn1",
    "dx1 = de2 * n0 - de0 * n2 + e2 * dn0 - e0 * dn2",
    "dx2 = de0 * n1 - de1 * n0 + e0 * dn1 - e1 * dn0",
)


def _derivative_source(axis_of, flows, spins) -> str:
    lines = [*_powers([*flows, *spins]), *_DERIVATIVE_HEAD]
    lines.append("u0 = u1 = u2 = w0 = w1 = w2 = 0.0")
    for group, fields in _groups(axis_of, flows, spins):
        lines += [line.format(group=group) for line in _FRAME]
        lines += _DERIVATIVE_FRAME
        for field, tables in fields:
            for basis in BASIS:
                if not (value := _sum(tables, basis, "value")):
                    continue
                along_c = _sum(tables, basis, "c")
                lines.append(f"f = {value}")
                lines.append(f"df = -stretch * ({_sum(tables, basis, 'k')})")
                if along_c:
                    lines.append(f"df += dc * ({along_c})")
                lines += [
                    f"{field}{k} += df * {vector} + f * d{vector}"
                    for k, vector in enumerate(_VECTORS[basis])
                ]
    lines.append("return u0, u1, u2, w0, w1, w2")
    arguments = "law, n0, n1, n2, s1, d0, d1, d2, t0, t1, t2, axes, strengths, j"
    return f"def pair_derivative({arguments}):\n" + "".join(f"    {line}\n" for line in lines)


def pair_twist(law, n0, n1, n2, s1, axes, strengths, j):
    """(u, a w) at a sphere n/s away (in radii) from sphere j; compiled from ``law``, its text."""
    raise NotImplementedError("compiled code only")


def pair_derivative(law, n0, n1, n2, s1, d0, d1, d2, t0, t1, t2, axes, strengths, j):
    """Change of :func:`pair_twist` when the separation changes by r d and sphere j turns by t."""
    raise NotImplementedError("compiled code only")


def _compile_from_law(placeholder):
    """Make a placeholder callable from kernels, its body taken from the literal ``law``."""

    def implementation(law, *_):
        if not isinstance(law, types.StringLiteral):
            return None
        namespace: dict = {}
        exec(law.literal_value, namespace)
        return namespace[placeholder.__name__]

    # numba matches the signatures of placeholder and implementation, names included
    arguments = ", ".join(placeholder.__code__.co_varnames[: placeholder.__code__.co_argcount])
    namespace = {"implementation": implementation}
    exec(f"def typed({arguments}):\n    return implementation({arguments})", namespace)
    options = {"fastmath": set(ARITHMETIC), "error_model": "numpy"}
    overload(placeholder, jit_options=options, prefer_literal=True)(namespace["typed"])


_compile_from_law(pair_twist)
_compile_from_law(pair_derivative)
