"""u/V and w = ½ curl u of one slip mode: its label, its symmetry and its table of polynomials.

The table (:mod:`nrchain.hydrodynamics.flow_tables`) is all that defines a mode. The angular
velocity of a sphere in the flow is half its curl and the finite-size correction is a Laplacian;
both are computed on the table.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from nrchain.errors import SceneError
from nrchain.hydrodynamics.flow_tables import (
    BASIS,
    FlowTable,
    Polynomial,
    add,
    clean,
    curl,
    divergence,
    flux,
    laplacian,
    scale,
)
from nrchain.inputs.rules import flag, is_whole, line, whole

LARGEST_POWER = 64
"""Largest power of a/r in a flow: (a/r)^64 vanishes at any distance between spheres."""

LARGEST_COEFFICIENT = 10**100

_TABLE = "must be {(basis, power): coefficients}"
_ROW = "coefficients must be a list of whole numbers, or fractions as text, of at most 1e100"
_LABEL = re.compile(r"[0-9][0-9A-Za-z_]*")


@dataclass(frozen=True)
class SlipMode:
    """u/V = Σ (a/r)^k P(c) b: one mode of slip, with its label and its symmetry.

    Parameters
    ----------
    label
        Its name in scenes, such as ``"2s"``: the order l of the tensorial harmonic, and its part
        s (symmetric), a (antisymmetric) or t (trace).
    name
        Its spoken name.
    order
        l of the label; the finite-size operator of the acting sphere is 1 + a²∇²/(4l + 2).
    polar, chiral
        Whether the mode changes sign with e, and with a mirror.
    velocity
        The flow over V as ``{(basis, k): coefficients of 1, c, c², …}``, with ``basis`` one of
        ``"n"``, ``"e"`` and ``"x"`` (e × n).

    Raises
    ------
    SceneError
        For a flow with divergence or net flux, one that is no Stokes flow, and one without the
        symmetry stated.

    >>> stresslet = SlipMode("2s", "stresslet", 2, False, False, {("n", 2): ("-7/6", 0, "7/2")})
    >>> stresslet.spin()
    {('x', 3): (Fraction(0, 1), Fraction(7, 2))}
    """

    label: str
    name: str
    order: int
    polar: bool
    chiral: bool
    velocity: Mapping[tuple[str, int], Iterable[Fraction | int | str]]

    def __hash__(self) -> int:
        return hash(self.label)

    def __post_init__(self) -> None:
        if not (isinstance(self.label, str) and is_label(self.label)):
            allowed = "must be a digit followed by letters, digits or _, such as '4t'"
            raise SceneError("slip mode label", self.label, allowed)
        line()(f"name of mode {self.label}", self.name)
        whole(least=0)(f"order of mode {self.label}", self.order)
        for name in ("polar", "chiral"):
            flag()(f"{name} of mode {self.label}", getattr(self, name))
        object.__setattr__(self, "velocity", clean(self._read()))
        self._check()

    def _read(self) -> FlowTable:
        """Return the given table in rational numbers."""
        key, table = f"velocity of mode {self.label}", {}
        try:
            rows = list(self.velocity.items())
        except (TypeError, AttributeError):
            raise SceneError(key, self.velocity, _TABLE) from None
        for place, row in rows:
            basis, power = place if isinstance(place, tuple) and len(place) == 2 else (None, None)
            if basis not in BASIS or not is_whole(power) or not 1 <= power <= LARGEST_POWER:
                raise SceneError(
                    key,
                    place,
                    f"a row is keyed by one of {', '.join(BASIS)} and a power of a/r, a whole"
                    f" number from 1 to {LARGEST_POWER}",
                )
            table[basis, power] = _polynomial(f"{key}, row {basis} (a/r)^{power}", row)
        return table

    def _check(self) -> None:
        """Refuse a table that is not a Stokes flow of the symmetry stated."""
        key = f"velocity of mode {self.label}"
        flow = self._table
        if not flow:
            raise SceneError(key, {}, "must have at least one row that is not zero")
        if divergence(flow):
            raise SceneError(key, self.velocity, "must have no divergence")
        if curl(laplacian(flow)):
            raise SceneError(key, self.velocity, "must be a Stokes flow: curl ∇²u = 0")
        if flux(flow):
            raise SceneError(key, self.velocity, "must have no net flux: ∫ u·n dΩ = 0")
        for (basis, _), p in flow.items():
            # e → −e changes the sign of c, of e and of e × n
            odd = {(m % 2 == 1) != (basis != "n") for m, q in enumerate(p) if q}
            if odd != {self.polar}:
                allowed = "must be odd in e for a polar mode and even for an apolar one"
                raise SceneError(f"{key}, row {basis}", [str(q) for q in p], allowed)
            if (basis == "x") != self.chiral:
                allowed = "must be along e × n for a chiral mode, along n and e for an achiral one"
                raise SceneError(f"{key}, row {basis}", [str(q) for q in p], allowed)

    @property
    def _table(self) -> FlowTable:
        return {key: tuple(Fraction(p) for p in row) for key, row in self.velocity.items()}

    def flow(self, finite_size: bool = False) -> FlowTable:
        """u/V as a table; with ``finite_size``, (1 + a²∇²/6)(1 + a²∇²/(4l + 2)) u/V.

        The first factor is Faxén's, for the sphere that feels the flow; the second is that of the
        acting sphere (Table active_force_torque of the paper).
        """
        return dict(self._flows[finite_size])

    def exterior_flow(self) -> FlowTable:
        """(1 + a²∇²/(4l + 2)) u/V as a table: the exact flow about a sphere by itself.

        The sphere is free of force and torque. On its surface the flow is the slip.
        """
        return dict(self._exterior)

    @cached_property
    def _exterior(self) -> FlowTable:
        return _add_laplacian(self._table, 4 * self.order + 2)

    @cached_property
    def _flows(self) -> tuple[FlowTable, FlowTable]:
        """The flow without and with finite size, kept because rational arithmetic is slow."""
        return self._table, _add_laplacian(self._exterior, 6)

    def spin(self, finite_size: bool = False) -> FlowTable:
        """a w/V = (a/2V) curl u as a table: the angular velocity of a sphere in the flow.

        Finite size does not change it: the curl of a biharmonic flow is harmonic.
        """
        return dict(self._spins[finite_size])

    @cached_property
    def _spins(self) -> tuple[FlowTable, FlowTable]:
        plain, sized = (scale(curl(flow), Fraction(1, 2)) for flow in self._flows)
        return plain, sized


def _add_laplacian(table: FlowTable, denominator: int) -> FlowTable:
    """(1 + a²∇²/denominator) u."""
    return add(table, scale(laplacian(table), Fraction(1, denominator)))


def _polynomial(key: str, row: Any) -> Polynomial:
    """Read the coefficients of a row, of a size that floats can hold."""
    try:
        p = tuple(Fraction(q) for q in row)
    except (TypeError, ValueError, ArithmeticError):
        raise SceneError(key, row, _ROW) from None
    if isinstance(row, str) or any(abs(q) > LARGEST_COEFFICIENT for q in p):
        raise SceneError(key, row, _ROW)
    return p


def is_label(text: object) -> bool:
    """Whether a text has the form of a mode label."""
    return _LABEL.fullmatch(str(text)) is not None
