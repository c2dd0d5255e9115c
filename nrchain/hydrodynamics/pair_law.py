"""Σ_j (u, a w)(r_i − r_j, e_j): code for the twist of one sphere, written from the table of modes.

The modes of a scene become one loop over the acting spheres, with every coefficient a constant in
the text. For 2s alone::

    def sum_twists(sources, radius, me, first, last):
        u0 = u1 = u2 = w0 = w1 = w2 = 0.0
        for j in range(np.uint64(first), np.uint64(last)):
            x0 = sources[0, me] - sources[0, j]
            ...
            c1 = e0 * n0 + e1 * n1 + e2 * n2
            p2 = v0 * (-1.1666666666666667 + c2 * 3.5)
            f = s2 * p2
            u0 += f * n0
            ...
        return u0, u1, u2, w0, w1, w2

The compiler sees the work of those modes alone and vectorises it: the loop calls no function,
writes no array and reads contiguous memory. (j is unsigned because a negative index would count
from the end, and the compiler would load every number separately.) Kernels take the text as a
literal: it is part of the key under which numba stores machine code on disk, and changed text is
always compiled anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numba
import numpy as np
from numba import types
from numba.extending import overload

from nrchain._compile import ARITHMETIC, rename
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.flow_tables import BASIS, FlowTable, Polynomial
from nrchain.hydrodynamics.slip_mode import SlipMode

_VECTOR = {"n": "n", "e": "e", "x": "m"}
_CHANGE = {"n": "d", "e": "t", "x": "y"}
"""Names of the basis vectors n, e and m = e × n in the text, and of their changes."""


@dataclass(frozen=True)
class PairLaw:
    """The modes of a sum over pairs: labels, body axes, and whether spheres have finite size.

    Modes with the same axis share the geometry of a pair. ``axes`` lists the distinct unit vectors
    (body components); mode m has the axis ``axes[axis_of[m]]``. With ``at_points`` the law is the
    exact flow about each sphere at a point of the fluid, in place of what another sphere feels.
    """

    labels: tuple[str, ...]
    axes: tuple[tuple[float, float, float], ...]
    axis_of: tuple[int, ...]
    finite_size: bool = False
    at_points: bool = False

    @classmethod
    def of(
        cls,
        labels: Sequence[str],
        axes: Sequence[Sequence[float]],
        finite_size: bool = False,
        at_points: bool = False,
    ) -> PairLaw:
        """The law of modes with the given body axes, of any length."""
        units: list[tuple[float, float, float]] = []
        axis_of = []
        for axis in axes:
            vector = np.asarray(axis, float)
            scaled = vector / np.abs(vector).max()
            x, y, z = (scaled / np.linalg.norm(scaled)).tolist()
            unit = (x, y, z)
            if unit not in units:
                units.append(unit)
            axis_of.append(units.index(unit))
        return cls(tuple(labels), tuple(units), tuple(axis_of), finite_size, at_points)

    def flow_of(self, mode: SlipMode) -> FlowTable:
        """u/V of a mode, in this law."""
        return mode.exterior_flow() if self.at_points else mode.flow(self.finite_size)

    @cached_property
    def source(self) -> str:
        """The text of ``sum_twists``, ``sum_changes`` and ``set_derivative`` for these modes."""
        return _text(self, tuple(map(slip_modes.find, self.labels)))

    def write(self) -> str:
        """Write this text anew."""
        return (
            _sum("sum_twists", ("sources",), self._twist_lines())
            + _sum("sum_changes", ("sources", "changes"), self._change_lines())
            + _function("set_derivative(sources, radius, me, j, out)", self._derivative_lines())
        )

    def _fields(self, group: int) -> Iterator[tuple[str, str, _Sum]]:
        """u and a w of the modes of one axis, by basis vector."""
        members = [m for m, g in enumerate(self.axis_of) if g == group]
        modes = {m: slip_modes.find(self.labels[m]) for m in members}
        flows = {m: self.flow_of(mode) for m, mode in modes.items()}
        spins = {m: mode.spin(self.finite_size) for m, mode in modes.items()}
        for field, tables in (("u", flows), ("w", spins)):
            for basis in BASIS:
                if total := _Sum.along(basis, tables):
                    yield field, basis, total

    def _geometry(self) -> list[str]:
        """n, the powers of s = a/r, and the strengths of the acting sphere j."""
        sums = [total for g in range(len(self.axes)) for _, _, total in self._fields(g)]
        highest = max((max(total.rows) for total in sums), default=1)
        strengths = 3 + 3 * len(self.axes)
        return [
            *(f"x{k} = sources[{k}, me] - sources[{k}, j]" for k in range(3)),
            "inverse = 1.0 / np.sqrt(x0 * x0 + x1 * x1 + x2 * x2)",
            *(f"n{k} = x{k} * inverse" for k in range(3)),
            "s1 = radius * inverse",
            *(f"s{k} = s{k - 1} * s1" for k in range(2, highest + 1)),
            *(f"v{m} = sources[{strengths + m}, j]" for m in range(len(self.labels))),
        ]

    def _axis(self, group: int) -> list[str]:
        """The axis e of sphere j, the powers of its cosine with n, and m = e × n."""
        highest = max(total.degree for _, _, total in self._fields(group))
        return [
            *(f"e{k} = sources[{3 + 3 * group + k}, j]" for k in range(3)),
            "c1 = e0 * n0 + e1 * n1 + e2 * n2",
            *(f"c{k} = c{k - 1} * c1" for k in range(2, highest + 1)),
            *(f"m{k} = {_cross('e', 'n', k)}" for k in range(3)),
        ]

    def _twist_lines(self) -> list[str]:
        lines = self._geometry()
        for group in range(len(self.axes)):
            lines += self._axis(group)
            for field, basis, total in self._fields(group):
                lines += total.at_each_power("p")
                lines.append(f"f = {total.over_powers('p')}")
                lines += [f"{field}{k} += f * {_VECTOR[basis]}{k}" for k in range(3)]
        return lines

    def _change_lines(self) -> list[str]:
        """The lines of ``sum_changes``: ∂(F n) = ∂(F/r) x + (F/r) ∂x, with F(s, c).

        With d = ∂x/r, ∂s = −s n·d. Likewise F e × n = (F/r) e × x, where t = ∂e is given.
        """
        lines = self._geometry()
        lines += [f"d{k} = (changes[{k}, me] - changes[{k}, j]) * inverse" for k in range(3)]
        lines.append("stretch = n0 * d0 + n1 * d1 + n2 * d2")
        for group in range(len(self.axes)):
            lines += self._axis(group)
            lines += [f"t{k} = changes[{3 + 3 * group + k}, j]" for k in range(3)]
            lines.append("dc = t0 * n0 + t1 * n1 + t2 * n2 - c1 * stretch")
            lines.append("dc += e0 * d0 + e1 * d1 + e2 * d2")
            lines += [f"y{k} = {_cross('t', 'n', k)} + {_cross('e', 'd', k)}" for k in range(3)]
            for field, basis, total in self._fields(group):
                lines += total.at_each_power("p")
                lines.append(f"f = {total.over_powers('p')}")
                lines.append(f"g = -stretch * {total.decay('p', own=int(basis != 'e'))}")
                if slope := total.slope():
                    lines += slope.at_each_power("q")
                    lines.append(f"g += dc * {slope.over_powers('q')}")
                lines += [
                    f"{field}{k} += g * {_VECTOR[basis]}{k} + f * {_CHANGE[basis]}{k}"
                    for k in range(3)
                ]
        return lines

    def _derivative_lines(self) -> list[str]:
        """The lines of ``set_derivative``: a field changes by X d + T φ for d = ∂x/r, ∂e = φ × e.

        With e^ the matrix of d ↦ e × d, sums over the basis vectors b, and g_b n·d + ∂F_b/∂c e·d
        the change of F_b with d,

            X = Σ b (g_b n + ∂F_b/∂c e)ᵀ + F_n + F_x e^,
            T = Σ b (∂F_b/∂c m)ᵀ − F_e e^ + F_x (e nᵀ − c).
        """
        lines = self._geometry()
        entries: dict[tuple[int, int], list[str]] = {(p, q): [] for p in range(6) for q in range(6)}
        for group in range(len(self.axes)):
            lines += self._axis(group)
            fields = list(self._fields(group))
            for field, first in (("u", 0), ("w", 3)):
                sums = {basis: total for of, basis, total in fields if of == field}
                lines += _coefficient_lines(sums)
                for (p, q), terms in _derivative_terms(sums).items():
                    name = f"{field}{group}{p}{q}"
                    if terms:
                        lines.append(f"{name} = " + " + ".join(terms))
                        entries[first + p, q].append(name)
        for (p, q), names in entries.items():
            scale = (" * inverse" if q < 3 else "") + (" / radius" if p > 2 else "")
            lines.append(f"out[{p}, {q}] = ({' + '.join(names) or '0.0'}){scale}")
        return lines


@lru_cache(maxsize=64)
def _text(law: PairLaw, modes: tuple[SlipMode, ...]) -> str:
    """The text of a law whose labels stand for these ``modes``. Many runs have the same law."""
    return law.write()


def _coefficient_lines(sums: Mapping[str, _Sum]) -> list[str]:
    """F_b, g_b and ∂F_b/∂c of a field along each basis vector, and Σ b g_b and Σ b ∂F_b/∂c."""
    lines = []
    for basis, total in sums.items():
        lines += total.at_each_power("p")
        lines.append(f"f{basis} = {total.over_powers('p')}")
        lines.append(f"g{basis} = -{total.decay('p', own=int(basis != 'e'))}")
        if slope := total.slope():
            lines += slope.at_each_power("q")
            lines.append(f"h{basis} = {slope.over_powers('q')}")
            lines.append(f"g{basis} -= c1 * h{basis}")
    sloped = [basis for basis, total in sums.items() if total.slope()]
    for letter, members in (("g", list(sums)), ("h", sloped)):
        for k in range(3) if members else ():
            terms = (f"{letter}{basis} * {_VECTOR[basis]}{k}" for basis in members)
            lines.append(f"{letter}{k} = " + " + ".join(terms))
    return lines


def _derivative_terms(sums: Mapping[str, _Sum]) -> dict[tuple[int, int], list[str]]:
    """The terms of the matrix (X, T) of a field, by row and column."""
    sloped = any(total.slope() for total in sums.values())
    found: dict[tuple[int, int], list[str]] = {}
    for p in range(3):
        for q in range(3):
            shift = [f"g{p} * n{q}"] if sums else []
            turn = [f"fx * e{p} * n{q}"] if "x" in sums else []
            if sloped:
                shift.append(f"h{p} * e{q}")
                turn.append(f"h{p} * m{q}")
            if p == q:
                shift += ["fn"] if "n" in sums else []
                turn += ["-fx * c1"] if "x" in sums else []
            else:
                # element p, q of the matrix of d ↦ e × d
                sign, k = ("-", (p + 2) % 3) if q == (p + 1) % 3 else ("", (p + 1) % 3)
                shift += [f"{sign}fx * e{k}"] if "x" in sums else []
                turn += [f"{'' if sign else '-'}fe * e{k}"] if "e" in sums else []
            found[p, q], found[p, 3 + q] = shift, turn
    return found


@dataclass(frozen=True)
class _Sum:
    """F = Σ_k s^k Σ_m V_m P_mk(c) as text; ``rows`` are {k: {mode m: P_mk}}."""

    rows: Mapping[int, Mapping[int, Polynomial]]

    @classmethod
    def along(cls, basis: str, tables: Mapping[int, FlowTable]) -> _Sum:
        """The rows of all modes along one basis vector."""
        rows: dict[int, dict[int, Polynomial]] = {}
        for mode, table in tables.items():
            for (b, k), p in table.items():
                if b == basis:
                    rows.setdefault(k, {})[mode] = p
        return cls(rows)

    def __bool__(self) -> bool:
        return bool(self.rows)

    @property
    def degree(self) -> int:
        """The highest power of c."""
        return max(len(p) - 1 for row in self.rows.values() for p in row.values())

    def slope(self) -> _Sum:
        """∂F/∂c."""
        rows: dict[int, dict[int, Polynomial]] = {}
        for k, row in self.rows.items():
            for mode, p in row.items():
                if len(p) > 1:
                    rows.setdefault(k, {})[mode] = tuple(m * q for m, q in enumerate(p))[1:]
        return _Sum(rows)

    def at_each_power(self, name: str) -> list[str]:
        """``name``k = Σ_m V_m P_mk(c) for every k."""
        return [
            f"{name}{k} = " + " + ".join(f"v{m} * {_polynomial(p)}" for m, p in row.items())
            for k, row in self.rows.items()
        ]

    def over_powers(self, name: str) -> str:
        """F from the ``name``k."""
        return _horner("s", {k: f"{name}{k}" for k in self.rows})

    def decay(self, name: str, own: int) -> str:
        """−r ∂/∂r of s^own F, over s^own, from the ``name``k."""
        return _horner("s", {k: f"{float(k + own)} * {name}{k}" for k in self.rows})


def _polynomial(p: Polynomial) -> str:
    return _horner("c", {k: repr(float(q)) for k, q in enumerate(p) if q})


def _horner(variable: str, coefficients: Mapping[int, str]) -> str:
    """Σ_k v^k A_k as v^k₁ (A_k₁ + v^(k₂−k₁) (A_k₂ + …)); the power k of v is named vk."""
    text, above = "", 0
    for k in sorted(coefficients, reverse=True):
        rest = f" + {variable}{above - k} * {text}" if text else ""
        text, above = f"({coefficients[k]}{rest})", k
    return f"{variable}{above} * {text}" if above else text


def _cross(a: str, b: str, k: int) -> str:
    """Component k of a × b."""
    p, q = (k + 1) % 3, (k + 2) % 3
    return f"{a}{p} * {b}{q} - {a}{q} * {b}{p}"


def _function(signature: str, lines: Iterable[str]) -> str:
    return f"def {signature}:\n" + "".join(f"    {line}\n" for line in lines)


def _sum(name: str, tables: Sequence[str], lines: Sequence[str]) -> str:
    """The text of a sum over j; ``tables`` are the arrays it reads."""
    return _function(
        f"{name}({', '.join(tables)}, radius, me, first, last)",
        [
            "u0 = u1 = u2 = w0 = w1 = w2 = 0.0",
            "for j in range(np.uint64(first), np.uint64(last)):",
            *(f"    {line}" for line in lines),
            "return u0, u1, u2, w0, w1, w2",
        ],
    )


def sum_twists(law, sources, radius, me, first, last):
    """Σ_j (u, a w) at sphere ``me``, over 0 ≤ first ≤ j < last, compiled from the text ``law``.

    The rows of ``sources`` are x, y, z, the components of each axis, and each mode's strengths.
    """
    raise NotImplementedError("compiled code only")


def sum_changes(law, sources, changes, radius, me, first, last):
    """Change of :func:`sum_twists` with ``changes`` of the rows x, y, z and of the axes."""
    raise NotImplementedError("compiled code only")


def set_derivative(law, sources, radius, me, j, out):
    """out (6, 6) = ∂(u, w) of the flow of ``j`` at ``me``.

    Columns are the displacement of ``me`` and the rotation of ``j``, in the lab. A displacement of
    ``j`` has the opposite effect, and a rotation of ``me`` none.
    """
    raise NotImplementedError("compiled code only")


@lru_cache(maxsize=256)
def _compiled(law: str, name: str):
    """Compile the function of that name in the text, once for all kernels that call it."""
    namespace: dict = {"np": np}
    exec(law, namespace)
    function = rename(namespace[name], law)
    return numba.njit(function, fastmath=set(ARITHMETIC), error_model="numpy")


@overload(sum_twists, prefer_literal=True)
def _sum_twists_of(law, sources, radius, me, first, last):
    if not isinstance(law, types.StringLiteral):
        return None
    compiled = _compiled(law.literal_value, "sum_twists")

    def call(law, sources, radius, me, first, last):
        return compiled(sources, radius, me, first, last)

    return rename(call, law.literal_value)


@overload(sum_changes, prefer_literal=True)
def _sum_changes_of(law, sources, changes, radius, me, first, last):
    if not isinstance(law, types.StringLiteral):
        return None
    compiled = _compiled(law.literal_value, "sum_changes")

    def call(law, sources, changes, radius, me, first, last):
        return compiled(sources, changes, radius, me, first, last)

    return rename(call, law.literal_value)


@overload(set_derivative, prefer_literal=True)
def _set_derivative_of(law, sources, radius, me, j, out):
    if not isinstance(law, types.StringLiteral):
        return None
    compiled = _compiled(law.literal_value, "set_derivative")

    def call(law, sources, radius, me, j, out):
        return compiled(sources, radius, me, j, out)

    return rename(call, law.literal_value)
