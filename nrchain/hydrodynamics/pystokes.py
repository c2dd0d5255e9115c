"""u = Σ output · a^k / (ratio · b^p): the pair laws through PyStokes, whose factors are data.

PyStokes sums the slip flows of all spheres, in routines whose prefactors, signs and powers of the
radius are peculiar to a release. A row of :data:`RELEASES` describes one of them: the radius b that
it is handed, the power p of b in what it returns, and the ratio of that to the closed form, which
has the power k of the spheres' radius a. Nothing is taken on trust: at first use the table is
compared with the closed forms of :mod:`nrchain.slip_modes` on one pair, and a release without a
table is refused.

This is the reference backend. It is the only importer of PyStokes, which sums every pair it is
shown: a limited reach is had by showing it two spheres at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nrchain.errors import BackendError, SceneError
from nrchain.hydrodynamics import slip_modes

Array = NDArray[np.float64]

POINT, OWN, VAST = 2.0**-80, 1.0, 2.0**80
"""The radius b handed to a routine, in units of the spheres' own.

The 2s velocity that PyStokes returns is A b² + B b⁴: a stresslet and its finite-size part. A radius
far below, or above, every distance leaves one term, the other being lost to rounding: it is
10⁻⁴⁸ (b/r)^±2 as large. Powers of two divide out again without an error.
"""


@dataclass(frozen=True)
class Routine:
    """A method of ``pystokes.unbounded.Rbm`` and how what it returns relates to a closed form."""

    method: str
    ratio: Fraction
    """What it returns over the closed form, when all radii are 1."""
    power: int
    """The power of its radius in what it returns."""
    size: float = OWN
    """The radius it is handed, over that of the spheres."""


@dataclass(frozen=True)
class ModeRoutines:
    """The routines of one mode; ``rank`` is that of the irreducible tensor they take."""

    rank: int
    velocity: Routine
    spin: Routine | None = None
    finite_size: Routine | None = None
    """The velocity with its finite-size part, where there is one."""


RELEASES: dict[str, dict[str, ModeRoutines]] = {
    "2.3.2": {
        "2s": ModeRoutines(
            rank=2,
            velocity=Routine("propulsionT2s", Fraction(-1), power=2, size=POINT),
            spin=Routine("propulsionR2s", Fraction(-1), power=2),
            finite_size=Routine("propulsionT2s", Fraction(-1), power=2),
        ),
        # propulsionR3a is no multiple of the law: it returns (32 V·x − 20 n·V·n x)/r⁵ where half
        # the curl of propulsionT3a is (−8 V·x + 20 n·V·n x)/r⁵. That is the potential quadrupole
        # of V, which is also the finite-size part of 2s, and PyStokes has that one right.
        "3a": ModeRoutines(
            rank=2,
            velocity=Routine("propulsionT3a", Fraction(96, 13), power=0),
            spin=Routine("propulsionT2s", Fraction(224, 65), power=4, size=VAST),
        ),
        "3t": ModeRoutines(
            rank=1,
            velocity=Routine("propulsionT3t", Fraction(1), power=3),
        ),
        "4a": ModeRoutines(
            rank=3,
            velocity=Routine("propulsionT4a", Fraction(-16, 121), power=0),
            spin=Routine("propulsionR4a", Fraction(-16, 121), power=0),
        ),
    }
}
"""The routines of each mode, by release of PyStokes."""

PI = {"2.3.2": 3.14159265359}
"""π as a release has it in its mobilities, which are too small by the ratio of the two."""

_LINEAR, _ANGULAR = slice(0, 3), slice(3, 6)

MOBILITIES = {
    "mobilityTT": (_LINEAR, _LINEAR),
    "mobilityTR": (_LINEAR, _ANGULAR),
    "mobilityRT": (_ANGULAR, _LINEAR),
    "mobilityRR": (_ANGULAR, _ANGULAR),
}
"""Which part of the twists each routine returns, and which part of the wrenches it acts on."""

COMPONENTS = {
    1: ("x", "y", "z"),
    2: ("xx", "yy", "xy", "xz", "yz"),
    3: ("xxx", "yyy", "xxy", "xxz", "xyy", "xyz", "yyz"),
}
"""The independent components of an irreducible tensor of each rank, in the order of PyStokes."""

TOLERANCE = 1e-12
"""The largest misfit, relative to the closed form, that the self-check lets pass."""


def twists(
    positions: Array,
    axes: Sequence[Array],
    strengths: Sequence[Array],
    *,
    neighbours: int | str,
    radius: float,
    viscosity: float,
    finite_size: bool,
    labels: Sequence[str],
) -> tuple[Array, Array]:
    """u_i = Σ_j u(r_i − r_j), w_i = Σ_j w(r_i − r_j): what the slip of all others does to sphere i.

    Parameters
    ----------
    positions
        Centres, ``(N, 3)``, of an open chain.
    axes, strengths, labels
        For each mode its unit vectors in the lab ``(N, 3)``, its strengths ``(N,)`` and its label.
    neighbours
        How far along the chain the sum goes: a number of neighbours on either side, or ``"all"``.
    radius, viscosity
        Of the spheres and of the fluid.
    finite_size
        Whether 2s has its finite-size part; the other modes have none.

    Returns
    -------
    Velocities and angular velocities in the lab, each ``(N, 3)``.

    Raises
    ------
    SceneError
        A mode that PyStokes has no routine for.
    BackendError
        PyStokes is missing, of an unknown release, or fails its self-check.
    """
    table = RELEASES[_verified(_library().__version__)]
    for label in labels:
        if label not in table:
            raise SceneError(
                "backend", "pystokes", f"has {', '.join(table)} only; mode {label!r} needs 'native'"
            )
    centres = np.array(positions, dtype=np.float64).T
    velocities, spins = np.zeros_like(centres), np.zeros_like(centres)
    for label, axis, strength in zip(labels, axes, strengths, strict=True):
        if not np.any(strength):
            continue
        mode = table[label]
        tensor = irreducible_tensor(mode.rank, axis, strength)
        velocity = mode.finite_size if finite_size and mode.finite_size else mode.velocity
        for total, routine in ((velocities, velocity), (spins, mode.spin)):
            if routine is not None:
                output = _sum(routine, centres, tensor, neighbours, radius, viscosity)
                total += output * radius ** _power(label) / float(routine.ratio)
    return velocities.T.copy(), spins.T.copy()


def mobility(
    positions: Array, wrenches: Array, neighbours: int | str, radius: float, viscosity: float
) -> Array:
    """(v, ω)_i = Σ_j μ_ij · (F, T)_j with the mobilities of Rotne, Prager and Yamakawa.

    Parameters
    ----------
    positions, wrenches
        Centres ``(N, 3)`` of an open chain, and the force and torque on each sphere ``(N, 6)``.
    neighbours
        How far along the chain the sum goes: a number of neighbours on either side, or ``"all"``.
    radius, viscosity
        Of the spheres and of the fluid.

    Returns
    -------
    Twists ``(N, 6)`` in the lab, with what each wrench does to its own sphere.

    Raises
    ------
    BackendError
        Two spheres within reach overlap, for which PyStokes has no mobility; and as
        :func:`twists`.
    """
    release = _verified(_library().__version__)
    centres = np.array(positions, dtype=np.float64).T
    wrenches = np.array(wrenches, dtype=np.float64).T
    _refuse_overlap(centres, neighbours, radius)
    result = np.zeros_like(wrenches)
    for method, (quantity, cause) in MOBILITIES.items():
        output = _sum_mobility(method, centres, wrenches[cause], neighbours, radius, viscosity)
        result[quantity] += output * (PI[release] / np.pi)
    return result.T.copy()


def check(version: str | None = None) -> None:
    """|PyStokes − closed form| ≤ 10⁻¹² |closed form| for each routine of the tables, on one pair.

    ``version`` is the release whose table is checked, by default that of the installed PyStokes.
    Raises :class:`~nrchain.errors.BackendError`, with the ratios and misfits measured, when there
    is no such table or the installed PyStokes does not follow it.
    """
    version = _library().__version__ if version is None else version
    latest = list(RELEASES)[-1]
    known = version if version in RELEASES else latest
    measured = [
        _measure(label, mode, quantity)
        for label, mode in RELEASES[known].items()
        for quantity in ("velocity", "finite_size", "spin")
        if getattr(mode, quantity) is not None
    ]
    measured += [_measure_mobility(method, PI[known]) for method in MOBILITIES]
    if version not in RELEASES:
        verdict = f"is a release whose factors are unknown (known: {', '.join(RELEASES)})"
    elif not all(agrees for agrees, _ in measured):
        verdict = "does not follow the factors known for that release"
    else:
        return
    rows = "; ".join(text for _, text in measured)
    raise BackendError(
        f"PyStokes {version} {verdict}; use the native backend, or install pystokes=={latest}. "
        f"Measured on one pair, as a multiple of the closed form: {rows}"
    )


def irreducible_tensor(rank: int, axes: Array, strengths: Array) -> Array:
    """V (e…e − traces): independent components of the uniaxial irreducible tensor, ``(2l + 1, N)``.

    Rank 1: V e; rank 2: V (ee − I/3); rank 3: V (eee − the three symmetric e δ/5). The tensors of
    ``pystokes.utils`` are not used: those of rank 3 mix up the spheres and the components.
    """
    e = dict(zip("xyz", np.asarray(axes, dtype=np.float64).T, strict=True))
    rows = []
    for component in COMPONENTS[rank]:
        row = np.prod([e[i] for i in component], axis=0)
        for p, q in combinations(range(rank), 2):
            if component[p] == component[q]:
                rest = component[:p] + component[p + 1 : q] + component[q + 1 :]
                row = row - np.prod([e[i] for i in rest], axis=0) / (2 * rank - 1)
        rows.append(row * strengths)
    return np.array(rows)


def _sum(
    routine: Routine,
    centres: Array,
    tensor: Array,
    neighbours: int | str,
    radius: float,
    viscosity: float,
) -> Array:
    """Σ output / b^p over the spheres in reach of each, ``(3, N)``."""
    count = centres.shape[1]
    size, groups = _groups(count, neighbours)
    handed = routine.size * radius
    method = getattr(_rbm(size, handed, viscosity), routine.method)
    total = np.zeros((3, count))
    for group in groups:
        output = np.zeros(3 * size)
        # flatten, because it copies: the routines refuse read-only arrays.
        method(output, centres[:, group].flatten(), tensor[:, group].flatten())
        total[:, group] += output.reshape(3, size)
    return total / handed**routine.power


def _sum_mobility(
    method: str,
    centres: Array,
    causes: Array,
    neighbours: int | str,
    radius: float,
    viscosity: float,
) -> Array:
    """Output of a mobility routine, ``(3, N)``.

    Each group returns its spheres' own part as well. It is known from one sphere shown by itself.
    """
    size, groups = _groups(centres.shape[1], neighbours)
    routine, alone = (getattr(_rbm(n, radius, viscosity), method) for n in (size, 1))
    own = np.zeros(3)
    alone(own, np.zeros(3), np.ones(3))
    total = own[:, None] * causes
    for group in groups:
        output = np.zeros(3 * size)
        routine(output, centres[:, group].flatten(), causes[:, group].flatten())
        total[:, group] += output.reshape(3, size) - own[:, None] * causes[:, group]
    return total


def _groups(count: int, neighbours: int | str) -> tuple[int, list[slice]]:
    """How many spheres to show PyStokes at a time, and which: all of them, or pair by pair."""
    if neighbours == "all" or int(neighbours) >= count - 1:
        return count, [slice(None)]
    gaps = range(1, int(neighbours) + 1)
    return 2, [slice(i, i + m + 1, m) for m in gaps for i in range(count - m)]


def _refuse_overlap(centres: Array, neighbours: int | str, radius: float) -> None:
    count = centres.shape[1]
    gaps = count - 1 if neighbours == "all" else min(int(neighbours), count - 1)
    for m in range(1, gaps + 1):
        distances = np.linalg.norm(centres[:, m:] - centres[:, :-m], axis=0)
        if np.any(distances < 2 * radius):
            i = int(np.argmin(distances))
            raise BackendError(
                f"spheres {i} and {i + m} are {distances[i]:.6g} apart, less than two radii of "
                f"{radius:.6g}: PyStokes has no mobility of overlapping spheres; use the native "
                "backend"
            )


def _rbm(particles: int, radius: float, viscosity: float) -> Any:
    """An ``Rbm``, which reserves a (3N)² matrix whether or not its noise is asked for."""
    try:
        return _library().unbounded.Rbm(radius=radius, particles=particles, viscosity=viscosity)
    except MemoryError as error:
        raise BackendError(
            f"PyStokes needs {72e-9 * particles**2:.3g} GB to sum over all pairs of {particles} "
            "spheres; use the native backend or fewer neighbours"
        ) from error


def _power(label: str) -> int:
    """k, the power of the radius in the closed form of a mode."""
    return max(power for _, power in slip_modes.find(label).velocity)


def _library() -> ModuleType:
    try:
        import pystokes
    except ImportError as error:
        raise BackendError(
            f"PyStokes cannot be imported ({error}); install pystokes=={list(RELEASES)[-1]}, or "
            "use the native backend"
        ) from error
    return pystokes


@cache
def _verified(version: str) -> str:
    """The release, once it has passed its check; a failure is raised anew each time."""
    check(version)
    return version


def _measure(label: str, mode: ModeRoutines, quantity: str) -> tuple[bool, str]:
    """Whether a row of a table holds on one pair at two radii, and in words what was found."""
    routine: Routine = getattr(mode, quantity)
    name = f"{label} {quantity.replace('_', '-')} by {routine.method}"
    centres = np.array([[0.0, 0.0, 0.0], [1.7, -2.1, 1.3]])
    axes = np.array([[2.0, 3.0, 6.0], [6.0, -2.0, 3.0]]) / 7.0
    strengths = np.array([1.1, -0.7])
    tensor = irreducible_tensor(mode.rank, axes, strengths)
    outputs, laws = [], []
    for radius in (1.0, 0.6):
        try:
            output = _sum(routine, centres.T, tensor, "all", radius, viscosity=1.0)
        except (AttributeError, TypeError, ValueError) as error:
            return False, f"{name} fails: {error}"
        outputs.append(output.T * radius ** _power(label))
        for i, j in ((0, 1), (1, 0)):
            law = _closed_form(label, quantity, centres[i] - centres[j], axes[j], radius)
            laws.append(strengths[j] * law)
    return _compare(name, outputs, laws, routine.ratio)


def _measure_mobility(method: str, pi: float) -> tuple[bool, str]:
    """Whether a mobility routine returns μ at two radii, and in words what was found."""
    centres = np.array([[0.0, 0.0, 0.0], [1.7, -2.1, 1.3]])
    causes = np.array([[1.1, -0.7, 0.4], [0.3, 0.9, -1.2]])
    outputs, laws = [], []
    for radius in (1.0, 0.6):
        try:
            output = _sum_mobility(method, centres.T, causes.T, "all", radius, viscosity=1.3)
        except (AttributeError, TypeError, ValueError) as error:
            return False, f"{method} fails: {error}"
        outputs.append(output.T * (pi / np.pi))
        for i, j in ((0, 1), (1, 0)):
            own, pair = _mobility_of_a_pair(method, centres[i] - centres[j], radius, 1.3)
            laws.append(own * causes[i] + pair @ causes[j])
    return _compare(method, outputs, laws, Fraction(1))


def _compare(name: str, outputs: Any, laws: Any, known: Fraction) -> tuple[bool, str]:
    """Whether outputs are ``known`` times the laws, and in words what was found."""
    found, expected = np.ravel(outputs), np.ravel(laws)
    ratio, scale = found @ expected / (expected @ expected), np.max(np.abs(expected))
    misfit = np.max(np.abs(found - ratio * expected)) / scale
    deviation = np.max(np.abs(found - float(known) * expected)) / scale
    text = f"{name} {ratio:.6g} where {known} is known, misfit {misfit:.0e}"
    return bool(deviation <= TOLERANCE * abs(known)), text


def _mobility_of_a_pair(
    method: str, separation: Array, radius: float, viscosity: float
) -> tuple[float, Array]:
    """A sphere's own mobility and the matrix of a pair: Rotne, Prager and Yamakawa, apart."""
    r = float(np.linalg.norm(separation))
    n, a = separation / r, radius
    nn, unit = np.outer(n, n), np.eye(3)
    scale = 1.0 / (8 * np.pi * viscosity)
    if method == "mobilityTT":
        pair = ((1 + 2 * a**2 / (3 * r**2)) * unit + (1 - 2 * a**2 / r**2) * nn) / r
        return 4 * scale / (3 * a), scale * pair
    if method == "mobilityRR":
        return scale / a**3, scale * (3 * nn - unit) / (2 * r**3)
    return 0.0, scale * np.cross(unit, n).T / r**2


def _closed_form(label: str, quantity: str, separation: Array, axis: Array, radius: float) -> Array:
    """Σ (a/r)^k P(c) b: the law of a mode of unit strength, at ``separation`` from its sphere."""
    mode = slip_modes.find(label)
    if quantity == "spin":
        table, unit = mode.spin(), 1.0 / radius
    else:
        table, unit = mode.flow(finite_size=quantity == "finite_size"), 1.0
    r = float(np.linalg.norm(separation))
    n = separation / r
    basis = {"n": n, "e": axis, "x": np.cross(axis, n)}
    result = np.zeros(3)
    for (b, k), row in table.items():
        polynomial = np.polynomial.Polynomial([float(p) for p in row])
        result += unit * (radius / r) ** k * polynomial(axis @ n) * basis[b]
    return result
