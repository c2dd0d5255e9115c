"""|K − S K| ≤ error: which symmetries given constants have."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from nrchain.theory.rod.constants import Constants, parts_of
from nrchain.theory.rod.symmetry import (
    QUARTER,
    SOURCES,
    STRAINS,
    STRESSES,
    Matrix,
    Symmetry,
    act,
    move,
    ref,
    rot,
    transform,
)

ANGLES = 32
"""Directions across the rod at which a change is sampled: a trigonometric polynomial of 2θ, of
order 8 at most, is known from them."""

TURNED = 1e-14
"""Rounding of a moved constant relative to the largest of its kind: an angle is known to rounding,
and leaves a part of large entries in those that are 0."""

_ABOUT = np.diag([1.0, -1.0, -1.0])
"""The half turn about e₁."""


def measured_symmetry(constants: Constants, error: Constants) -> Symmetry:
    """The symmetries of given constants, each known to ``error``.

    For constants that are not transversely isotropic, the axis of a half turn and the plane of a
    mirror are those of the best agreement.
    """
    isotropic = _unchanged(constants, error, QUARTER)
    tried = [rot(), ref(), -np.eye(3)]
    if not isotropic:
        tried = [_ABOUT, *(kind(_best_angle(constants, kind)) for kind in (rot, ref))]
        tried += [-np.eye(3), -_ABOUT]
    kept = [S for S in tried if _unchanged(constants, error, S)]
    return Symmetry(isotropic, (np.eye(3), *kept))


def _best_angle(constants: Constants, kind: Callable[[float], Matrix]) -> float:
    """The direction θ of the half turn or mirror that changes the constants least."""
    angles = math.pi / ANGLES * np.arange(ANGLES)
    # what is isotropic may be much larger, and its rounding would hide the rest
    mean = sum((transform(constants, _turn(2.0 * angle)) for angle in angles), Constants.of())
    across = constants - mean.map(lambda part: part / ANGLES)
    moved = (transform(across, kind(angle)) - across for angle in angles)
    change = [sum(float(np.sum(part**2)) for part in parts_of(m)) for m in moved]
    orders = 2j * np.arange(ANGLES // 2 + 1)
    waves = np.fft.rfft(change) / ANGLES
    waves[1:-1] *= 2.0
    angle = float(angles[np.argmin(change)])
    for _ in range(20):
        # the slope vanishes linearly at an exact symmetry: Newton finds its angle to rounding
        phases = waves * np.exp(orders * angle)
        slope, bend = float(np.sum(orders * phases).real), float(np.sum(orders**2 * phases).real)
        if bend <= 0.0:
            break
        angle -= slope / bend
    return angle


def _turn(angle: float) -> Matrix:
    """The rotation by an angle about e₁."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _unchanged(constants: Constants, error: Constants, operation: Matrix) -> bool:
    """Whether an operation changes no constant by more than the errors of the two together."""
    matrices = (np.abs(act(operation, kinds)) for kinds in (STRAINS, STRESSES, SOURCES))
    rounding = constants.map(lambda part: np.full_like(part, TURNED * np.abs(part).max()))
    bound = error + move(error, *matrices) + rounding
    change = (transform(constants, operation) - constants).map(np.abs)
    pairs = zip(parts_of(change), parts_of(bound), strict=True)
    return all(bool(np.all(part <= limit)) for part, limit in pairs)
