"""g: r ↦ o + d + R (r − o), e ↦ R e with a turn about e₁: motions of a chain as a whole.

A motion g = exp(ξ) belongs to rates ξ of the elementary motions, per unit of time. The one that
carries one pose to another best is found from many angles, then by the Gauss–Newton method.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nrchain.comoving.motions import TURN
from nrchain.comoving.relative import RelativeChain, orthonormal_motions
from nrchain.effects.base import cross_matrix
from nrchain.states.cycles.charts import chart
from nrchain.states.cycles.orbit import FIRST, Orbit, orbit_of
from nrchain.types import Poses

ANGLES = 16
"""Angles about the axis of a rotation, and about e₁, from which a fit begins."""

ITERATIONS, CLOSE = 30, 1e-12
"""Most iterations of a fit, and the step in lengths that ends it."""

TURNED = 1e-6
"""A shape is turned by more than this angle."""


class Carry(NamedTuple):
    """R (3, 3), d (3,) and the angle of the turn about e₁."""

    rotation: np.ndarray
    shift: np.ndarray
    turn: float

    def applied(self, poses: Poses, origin: np.ndarray) -> Poses:
        """The poses moved by it."""
        positions = (poses[0] - origin) @ self.rotation.T + origin + self.shift
        frames = poses[1] @ self.rotation.T
        cosine, sine = math.cos(self.turn), math.sin(self.turn)
        turned = frames.copy()
        turned[..., 1, :] = cosine * frames[..., 1, :] + sine * frames[..., 2, :]
        turned[..., 2, :] = cosine * frames[..., 2, :] - sine * frames[..., 1, :]
        return positions, turned

    def then(self, other: Carry) -> Carry:
        """This motion, and another one after it."""
        rotation = other.rotation @ self.rotation
        shift = other.rotation @ self.shift + other.shift
        return Carry(rotation, shift, self.turn + other.turn)


STAY = Carry(np.eye(3), np.zeros(3), 0.0)


def carry(chain: RelativeChain, elementary: np.ndarray, time: float = 1.0) -> Carry:
    """exp(t ξ) of rates (7,) of the elementary motions."""
    velocity, vector, turn = chain.motion(np.asarray(elementary, float) * time)
    cross, sine, first, second = _coefficients(vector)
    rotation = np.eye(3) + sine * cross + first * cross @ cross
    along = np.eye(3) + first * cross + second * cross @ cross
    return Carry(rotation, along @ velocity, turn)


def _coefficients(vector: np.ndarray) -> tuple[np.ndarray, float, float, float]:
    """Ω^, sin α/α, (1 − cos α)/α² and (α − sin α)/α³ of an angle vector of size α."""
    angle = float(np.linalg.norm(vector))
    cross = cross_matrix(vector[None])[0]
    half = float(np.sinc(0.5 * angle / np.pi))
    sine, first = float(np.sinc(angle / np.pi)), 0.5 * half**2
    second = 1.0 / 6.0 - angle**2 / 120.0 if angle < 1e-2 else (1.0 - sine) / angle**2
    return cross, sine, first, second


def rates(chain: RelativeChain, motion: Carry) -> np.ndarray:
    """ξ (7,), an allowed motion, with exp(ξ) = g and the smallest angle of rotation."""
    from scipy.spatial.transform import Rotation

    vector = Rotation.from_matrix(motion.rotation).as_rotvec()
    # d = (1 + (1 − cos α)/α² Ω^ + (α − sin α)/α³ Ω^²) V
    cross, _, first, second = _coefficients(vector)
    velocity = np.linalg.solve(np.eye(3) + first * cross + second * cross @ cross, motion.shift)
    rigid = np.concatenate([velocity / chain.length, vector])
    # the angle of the turn is known up to whole turns
    turns = motion.turn + 2.0 * np.pi * (np.arange(-2, 3) - np.round(motion.turn / (2.0 * np.pi)))
    found = [np.append(rigid, turn) for turn in sorted(turns, key=abs)]
    allowed = chain.allowed
    if not allowed.size:
        return np.zeros(7)
    fitted = [allowed @ np.linalg.lstsq(allowed, one, rcond=None)[0] for one in found]
    rest = [round(float(np.linalg.norm(a - b)), 6) for a, b in zip(found, fitted, strict=True)]
    return fitted[int(np.argmin(rest))]


def fit(chain: RelativeChain, poses: Poses, to: Poses) -> tuple[Carry, float]:
    """The allowed motion that carries poses nearest to others, and the distance that is left.

    The distance is √mean(|u|² + ρ² |φ|²) over the free spheres.
    """
    begins = _begins(chain, poses, to)
    if len(begins) > 1:
        begins.sort(key=lambda one: _chord(chain, one, poses, to))
    return _improved(chain, begins[0], poses, to)


def _improved(chain: RelativeChain, motion: Carry, poses: Poses, to: Poses) -> tuple[Carry, float]:
    """The fit next to a motion."""
    for _ in range(ITERATIONS):
        moved = motion.applied(poses, chain.origin)
        away = chain.coordinates(np.clip(chart(*to, moved), -1e6, 1e6))
        if not chain.allowed.size:
            break
        columns = chain.columns(*moved)
        basis, combinations = orthonormal_motions(columns, chain.allowed, chain.length)
        step = basis.T @ away
        largest = np.abs(combinations @ step)[3:].max(initial=0.0)
        step *= min(1.0, 0.5 / max(largest, 1e-300))
        motion = motion.then(carry(chain, combinations @ step))
        if np.linalg.norm(step) <= CLOSE * chain.length:
            break
    moved = motion.applied(poses, chain.origin)
    away = chain.coordinates(np.clip(chart(*to, moved), -1e6, 1e6))
    return motion, float(np.linalg.norm(away)) / math.sqrt(max(len(chain.free), 1))


def _chord(chain: RelativeChain, motion: Carry, poses: Poses, to: Poses) -> float:
    """Σ |Δr|² + ρ² Σ |Δe|²/2."""
    moved = motion.applied(poses, chain.origin)
    turned = 0.5 * chain.length**2 * np.sum((moved[1] - to[1]) ** 2)
    return float(np.sum((moved[0] - to[0]) ** 2) + turned)


def _begins(chain: RelativeChain, poses: Poses, to: Poses) -> list[Carry]:
    """Motions from which a fit begins."""
    allowed = chain.allowed
    if not allowed.size:
        return [STAY]
    angles = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
    begins, axis = [STAY], _alone(allowed, slice(3, TURN))
    if np.linalg.matrix_rank(allowed[3:TURN], tol=1e-9) == 3:
        begins = [_best_rotation(chain, poses, to)]
    elif axis is not None:
        begins = [carry(chain, axis, float(angle)) for angle in angles]
    turning = _alone(allowed, slice(TURN, 7))
    if turning is None or np.abs(turning[3:TURN]).max() > 1e-9:
        return begins
    return [one.then(carry(chain, turning, float(angle))) for one in begins for angle in angles]


def _alone(allowed: np.ndarray, places: slice) -> np.ndarray | None:
    """The allowed motion of smallest translation with a unit part in some places, if any."""
    part = allowed[places]
    _, sizes, directions = np.linalg.svd(part)
    if not sizes.size or sizes[0] < 1e-9:
        return None
    return allowed @ directions[0] / sizes[0]


def _best_rotation(chain: RelativeChain, poses: Poses, to: Poses) -> Carry:
    """The rigid motion that fits positions and frames best, with e₁ alone if frames turn freely."""
    centre, other = poses[0].mean(axis=0), to[0].mean(axis=0)
    covariance = (to[0] - other).T @ (poses[0] - centre)
    axes = slice(0, 1 if np.abs(chain.allowed[TURN]).max() > 0.0 else 3)
    covariance += chain.length**2 * np.einsum("nai,nak->ik", to[1][:, axes], poses[1][:, axes])
    u, _, v = np.linalg.svd(covariance)
    rotation = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v
    shift = other - chain.origin - rotation @ (centre - chain.origin)
    return Carry(rotation, shift, 0.0)


def is_half_turned(chain: RelativeChain, orbit: Orbit, within: float) -> bool:
    """Whether the shape returns after half a turn, to ``within`` radians: planar shapes do."""
    return abs(_angle(chain, orbit) - np.pi) <= within


def is_turned(chain: RelativeChain, orbit: Orbit) -> bool:
    """Whether the shape is turned as a whole after a period."""
    return _angle(chain, orbit) > TURNED


def _angle(chain: RelativeChain, orbit: Orbit) -> float:
    """|Ω| T."""
    return orbit.period * float(np.linalg.norm(chain.motion(orbit.elementary).rotation))


def twice(chain: RelativeChain, orbit: Orbit) -> Orbit:
    """The same orbit over two periods, in axes that turn by the smallest angle."""
    period = 2.0 * orbit.period
    drift = rates(chain, carry(chain, orbit.elementary, period)) / period
    widths = np.full(2 * FIRST, 0.5 / FIRST)

    def along(fraction: float) -> Poses:
        forth = carry(chain, orbit.elementary, fraction * period)
        back = carry(chain, drift, -fraction * period)
        return forth.then(back).applied(orbit.at(2.0 * fraction), chain.origin)

    return orbit_of(along, period, drift, widths)
