"""u = Σ output · a^k / (ratio · b^p): PyStokes, and the factors that turn it into the pair laws.

PyStokes sums the slip flows of all spheres, in routines whose prefactors, signs and powers of the
radius change with the release. A row of :data:`RELEASES` describes one routine: the radius b that
it is given, the power p of b in what it returns, and the ratio of that to the closed form, which
has the power k of the spheres' radius a.

This file holds all that is particular to PyStokes: factors, errata and memory layout. No other file
imports the library. It sums every pair it is given; for a limited reach it is given two spheres at
a time.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nrchain.errors import BackendError
from nrchain.hydrodynamics import slip_modes

Array = NDArray[np.float64]

POINT, OWN, VAST = 2.0**-80, 1.0, 2.0**80
"""The radius b given to a routine, in units of the spheres' own.

The 2s velocity that PyStokes returns is A b² + B b⁴: a stresslet and its finite-size part. A radius
far below, or far above, every distance leaves one term: the other is 10⁻⁴⁸ (b/r)^±2 as large, below
rounding. Powers of two divide out without an error.
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
    """The radius it is given, over that of the spheres."""


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

FLOWS = {
    "2.3.2": {
        "2s": Routine("flowField2s", Fraction(1), power=3),
        "3a": Routine("flowField3a", Fraction(-96, 13), power=0),
        "3t": Routine("flowField3t", Fraction(1, 2), power=5),
        "4a": Routine("flowField4a", Fraction(-16, 121), power=0),
        "force": Routine("flowField1s", Fraction(1), power=0),
        "torque": Routine("flowField2a", Fraction(-1), power=0),
    }
}
"""The methods of ``pystokes.unbounded.Flow``, which has factors of its own, by release."""

PI = {"2.3.2": 3.14159265359}
"""π as written in a release: its mobilities are too small by the ratio of the true π to it."""

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


def sum_flow(
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
    given = routine.size * radius
    method = getattr(_rbm(size, given, viscosity), routine.method)
    total = np.zeros((3, count))
    for group in groups:
        output = np.zeros(3 * size)
        # flatten, because it copies: the routines refuse read-only arrays.
        method(output, centres[:, group].flatten(), tensor[:, group].flatten())
        total[:, group] += output.reshape(3, size)
    return total / given**routine.power


def sum_mobility(
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


def flow_at(
    label: str,
    points: Array,
    positions: Array,
    axes: Array,
    strengths: Array,
    radius: float,
    viscosity: float,
) -> Array:
    """u (M, 3) at points (M, 3), by ``pystokes.unbounded.Flow``, in the units of the closed form.

    ``label`` is a mode, ``"force"`` or ``"torque"``; of these, strengths (N,) along axes (N, 3) are
    forces and torques. Raises :class:`~nrchain.errors.BackendError` for a release of PyStokes whose
    factors are not known.
    """
    version = library().__version__
    if version not in FLOWS:
        raise BackendError(f"PyStokes {version} has unknown factors; install {', '.join(FLOWS)}")
    routine, is_mode = FLOWS[version][label], label not in ("force", "torque")
    rank = RELEASES[version][label].rank if is_mode else 1
    tensor = irreducible_tensor(rank, axes, strengths)
    flow = library().unbounded.Flow(
        radius=radius, particles=len(positions), viscosity=viscosity, gridpoints=len(points)
    )
    output = np.zeros(3 * len(points))
    arrays = points.T.flatten(), positions.T.flatten(), tensor.flatten()
    getattr(flow, routine.method)(output, *arrays)
    size = radius ** (radius_power(label) - routine.power) if is_mode else 1.0
    return output.reshape(3, -1).T * size / float(routine.ratio)


def _groups(count: int, neighbours: int | str) -> tuple[int, list[slice]]:
    """How many spheres to show PyStokes at a time, and which: all of them, or pair by pair."""
    if neighbours == "all" or int(neighbours) >= count - 1:
        return count, [slice(None)]
    gaps = range(1, int(neighbours) + 1)
    return 2, [slice(i, i + m + 1, m) for m in gaps for i in range(count - m)]


def _rbm(particles: int, radius: float, viscosity: float) -> Any:
    """An ``Rbm``, which reserves a (3N)² matrix whether or not its noise is asked for."""
    try:
        return library().unbounded.Rbm(radius=radius, particles=particles, viscosity=viscosity)
    except MemoryError as error:
        raise BackendError(
            f"PyStokes needs {72e-9 * particles**2:.3g} GB to sum over all pairs of {particles} "
            "spheres; use the native backend or fewer neighbours"
        ) from error


def radius_power(label: str) -> int:
    """k, the power of the radius in the closed form of a mode."""
    return max(power for _, power in slip_modes.find(label).velocity)


def library() -> ModuleType:
    try:
        import pystokes
    except ImportError as error:
        raise BackendError(
            f"PyStokes cannot be imported ({error}); install pystokes=={list(RELEASES)[-1]}, or "
            "use the native backend"
        ) from error
    return pystokes
