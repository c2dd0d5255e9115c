"""u = Σ V (a/r)^k P(c) b: the flow that a mode of surface slip induces, one row a mode.

A sphere of radius a whose slip is uniaxial about the unit vector e sets up, at x = r n from its
centre and with c = e·n, a flow with components along three vectors only,

    u = u_n n + u_e e + u_x (e × n),      u_b = V Σ_k (a/r)^k P_bk(c),

with polynomials P. A mode is that table of polynomials and nothing else: its angular velocity is
half the curl, its finite-size correction a Laplacian, and both are taken here on the table,
exactly, in rational numbers. The compiled kernels, the Jacobians, the lattice sums and the tests
are all made from the same rows, so that a further mode is one call of :func:`register`.

Source of the four pair laws: Németh, Kobayashi, Adhikari, Eqs. (2s_force), (3a_force), (3t_force)
and (4a_force), with n the unit vector from the acting to the feeling sphere. The strengths V are
the paper's: they differ from slip speeds by the factors noted in the README.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from nrchain.errors import SceneError
from nrchain.inputs.names import did_you_mean
from nrchain.inputs.rules import flag, is_whole, line, whole

BASIS = ("n", "e", "x")
"""The three vectors of a flow: n, e and x = e × n."""

Polynomial = tuple[Fraction, ...]
"""Coefficients of 1, c, c², …"""

LARGEST_POWER = 64
"""Of a/r in a flow: of larger ones nothing is left at any distance that spheres can have."""

LARGEST_COEFFICIENT = 10**100

_TABLE = "must be {(basis, power): coefficients}"
_ROW = "coefficients must be a list of whole numbers, or fractions as text, of at most 1e100"
_LABEL = re.compile(r"[0-9][0-9A-Za-z_]*")

PairTable = dict[tuple[str, int], Polynomial]
"""Polynomial in c for each (basis vector, power of a/r)."""


@dataclass(frozen=True)
class SlipMode:
    """One mode of slip: its label, its symmetry and the flow it induces.

    Parameters
    ----------
    label
        What scenes call it, such as ``"2s"``: the order l of the tensorial harmonic, and its part
        s (symmetric), a (antisymmetric) or t (trace).
    name
        Its spoken name.
    order
        l of the label; the finite-size operator of the acting sphere is 1 + a²∇²/(4l + 2).
    polar, chiral
        Whether the mode changes sign with e, and with a mirror.
    velocity
        The flow over V as ``{(basis, k): coefficients of 1, c, c², …}``.
    """

    label: str
    name: str
    order: int
    polar: bool
    chiral: bool
    velocity: Mapping[tuple[str, int], Iterable[Fraction | int | str]]

    def __post_init__(self) -> None:
        if not (isinstance(self.label, str) and is_label(self.label)):
            allowed = "must be a digit followed by letters, digits or _, such as '4t'"
            raise SceneError("slip mode label", self.label, allowed)
        line()(f"name of mode {self.label}", self.name)
        whole(least=0)(f"order of mode {self.label}", self.order)
        for name in ("polar", "chiral"):
            flag()(f"{name} of mode {self.label}", getattr(self, name))
        object.__setattr__(self, "velocity", _clean(self._read()))
        self._check()

    def _read(self) -> PairTable:
        """The table as given, in rational numbers."""
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
        """Refuse what is not a Stokes flow of the symmetry stated, before it enters any kernel."""
        key = f"velocity of mode {self.label}"
        flow = self._table
        if not flow:
            raise SceneError(key, {}, "must have at least one row that is not zero")
        if divergence(flow):
            raise SceneError(key, self.velocity, "must have no divergence")
        if curl(laplacian(flow)):
            raise SceneError(key, self.velocity, "must be a Stokes flow: curl ∇²u = 0")
        if _flux(flow):
            raise SceneError(key, self.velocity, "must carry no fluid away: ∫ u·n dΩ = 0")
        for (basis, _), p in flow.items():
            # e → −e turns c to −c, and e and e × n around
            odd = {(m % 2 == 1) != (basis != "n") for m, q in enumerate(p) if q}
            if odd != {self.polar}:
                allowed = "must be odd in e for a polar mode and even for an apolar one"
                raise SceneError(f"{key}, row {basis}", [str(q) for q in p], allowed)
            if (basis == "x") != self.chiral:
                allowed = "must be along e × n for a chiral mode, along n and e for an achiral one"
                raise SceneError(f"{key}, row {basis}", [str(q) for q in p], allowed)

    @property
    def _table(self) -> PairTable:
        return {key: tuple(Fraction(p) for p in row) for key, row in self.velocity.items()}

    def flow(self, finite_size: bool = False) -> PairTable:
        """u/V as a table; with ``finite_size``, (1 + a²∇²/6)(1 + a²∇²/(4l + 2)) u/V.

        The first factor is Faxén's for the sphere that feels the flow, the second that of the
        sphere whose slip sets it up (Table active_force_torque of the paper).
        """
        return dict(self._flows[finite_size])

    @cached_property
    def _flows(self) -> tuple[PairTable, PairTable]:
        """The flow, and that with finite size: rational arithmetic is slow, and asked for often."""
        plain = table = self._table
        for denominator in (6, 4 * self.order + 2):
            table = _add(table, _scale(laplacian(table), Fraction(1, denominator)))
        return plain, table

    def spin(self, finite_size: bool = False) -> PairTable:
        """a w/V = (a/2V) curl u as a table: the angular velocity of a sphere in the flow.

        The finite-size factors leave it as it is for a biharmonic flow, whose curl is harmonic.
        """
        return dict(self._spins[finite_size])

    @cached_property
    def _spins(self) -> tuple[PairTable, PairTable]:
        plain, sized = (_scale(curl(flow), Fraction(1, 2)) for flow in self._flows)
        return plain, sized


def _flux(flow: PairTable) -> Fraction:
    """∫ u·n dΩ/2πV at r = a of a flow without divergence: only what falls as 1/r² has any."""
    along = ((flow.get(("n", 2), ()), 0), (flow.get(("e", 2), ()), 1))
    terms = [(m + shift, q) for row, shift in along for m, q in enumerate(row)]
    return sum((2 * q / (m + 1) for m, q in terms if m % 2 == 0), Fraction(0))


def _polynomial(key: str, row: Any) -> Polynomial:
    """The coefficients of a row, if floats hold what is made of them."""
    try:
        p = tuple(Fraction(q) for q in row)
    except (TypeError, ValueError, ArithmeticError):
        raise SceneError(key, row, _ROW) from None
    if isinstance(row, str) or any(abs(q) > LARGEST_COEFFICIENT for q in p):
        raise SceneError(key, row, _ROW)
    return p


def is_label(text: object) -> bool:
    """Whether a text may be the label of a mode, known or not."""
    return _LABEL.fullmatch(str(text)) is not None


def curl(table: PairTable) -> PairTable:
    """a ∇ × (u_n n + u_e e + u_x e × n), term by term, on a table in powers of s = a/r.

    With ∇c = (e − c n)/r:
        ∇ × (f n)     = (f_c / r) e × n
        ∇ × (g e)     = (c g_c / r − g_r) e × n
        ∇ × (h e × n) = (h_r + h/r) e + [c h/r − c h_r − (1 − c²) h_c / r] n
    and a monomial s^k has r ∂/∂r = −k.
    """
    result: PairTable = {}
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
    return _clean(result)


def divergence(table: PairTable) -> PairTable:
    """a ∇·u, keyed ("n", k): ∇·(f n) = f_r + 2f/r and ∇·(g e) = c g_r + (1 − c²) g_c/r."""
    result: PairTable = {}
    for (basis, k), p in table.items():
        slope = _derivative(p)
        if basis == "n":
            _accumulate(result, ("n", k + 1), tuple((2 - k) * q for q in p))
        elif basis == "e":
            _accumulate(result, ("n", k + 1), tuple(-k * q for q in _shift(p, 1)))
            _accumulate(result, ("n", k + 1), slope)
            _accumulate(result, ("n", k + 1), tuple(-q for q in _shift(slope, 2)))
    return _clean(result)


def laplacian(table: PairTable) -> PairTable:
    """a²∇²u = −a² ∇ × (∇ × u), for a flow without divergence."""
    return _scale(curl(curl(table)), Fraction(-1))


def _derivative(p: Polynomial) -> Polynomial:
    return tuple(m * q for m, q in enumerate(p))[1:]


def _shift(p: Polynomial, by: int) -> Polynomial:
    return (Fraction(0),) * by + tuple(p)


def _accumulate(table: PairTable, key: tuple[str, int], p: Polynomial) -> None:
    old = table.get(key, ())
    longest = max(len(old), len(p))
    pad = [tuple(q) + (Fraction(0),) * (longest - len(q)) for q in (old, p)]
    table[key] = tuple(a + b for a, b in zip(*pad, strict=True))


def _add(first: PairTable, second: PairTable) -> PairTable:
    result = dict(first)
    for key, p in second.items():
        _accumulate(result, key, p)
    return _clean(result)


def _scale(table: PairTable, factor: Fraction) -> PairTable:
    return {key: tuple(factor * q for q in p) for key, p in table.items()}


def _clean(table: PairTable) -> PairTable:
    """The table without trailing zeros and without rows that vanish."""
    result: PairTable = {}
    for key, p in table.items():
        while p and p[-1] == 0:
            p = p[:-1]
        if p:
            result[key] = p
    return result


_MODES: dict[str, SlipMode] = {}


def register(mode: SlipMode) -> SlipMode:
    """Make a mode known to scenes, kernels and the registry-driven tests, and return it.

    A trajectory file names its modes, it does not hold their tables: register a mode again before
    opening or resuming a run of it. Raises :class:`~nrchain.errors.SceneError` when the label is
    taken by another mode.
    """
    if not isinstance(mode, SlipMode):
        raise SceneError("slip mode", mode, "must be a SlipMode")
    known = _MODES.get(mode.label)
    if known is not None and known != mode:
        raise SceneError(
            "slip mode label", mode.label, "is taken by another mode; choose a new one"
        )
    _MODES[mode.label] = mode
    return mode


def unregister(label: str) -> None:
    """Forget a mode that was registered; scenes that name it are refused from then on."""
    del _MODES[find(label).label]


def modes() -> tuple[SlipMode, ...]:
    """Every mode known, in the order of registration."""
    return tuple(_MODES.values())


def find(label: str) -> SlipMode:
    """The mode of a label; unknown labels raise with the nearest known one."""
    if isinstance(label, str) and label in _MODES:
        return _MODES[label]
    hint = did_you_mean(label, _MODES)
    raise SceneError("slip mode", label, f"known modes are {', '.join(_MODES)}{hint}")


register(
    SlipMode(
        label="2s",
        name="stresslet",
        order=2,
        polar=False,
        chiral=False,
        velocity={("n", 2): ("-7/6", 0, "7/2")},
    )
)
register(
    SlipMode(
        label="3a",
        name="torque dipole",
        order=3,
        polar=False,
        chiral=True,
        velocity={("x", 3): (0, "13/12")},
    )
)
register(
    SlipMode(
        label="3t",
        name="source dipole",
        order=3,
        polar=True,
        chiral=False,
        velocity={("e", 3): ("-1/5",), ("n", 3): (0, "3/5")},
    )
)
register(
    SlipMode(
        label="4a",
        name="chiral octupole",
        order=4,
        polar=True,
        chiral=True,
        velocity={("x", 4): ("363/40", 0, "-363/8")},
    )
)
