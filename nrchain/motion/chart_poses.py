"""r_i = r_i⁰(t) + ρ_i, R_i = cay(θ_i) R_i⁰(t): poses from coordinates y, and ẏ from twists.

Slot s of y holds (ρ, θ) of sphere ``order[s]``. Positions are (N, 3), frames (N, 3, 3), twists
(N, 6), in the lab; ``spins`` (N, 3) are Ω_a of the bases along their own axes.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain._compile import kernel, part
from nrchain.geometry import lie

TURN_LIMIT = 2.0
"""|θ| = 2 tan(α/2) at which a run changes to a new chart: a quarter turn."""

HALF_LIMIT = math.atan(0.5 * TURN_LIMIT)
"""α/2 at that limit."""

SMALLEST_TURN = float(np.finfo(float).eps)


@part
def _rotated_axes(spin, time, out):
    """out (3, 3) = the axes of a base, in rows, along its axes a ``time`` earlier."""
    rate = math.sqrt(spin[0] ** 2 + spin[1] ** 2 + spin[2] ** 2)
    out[:] = 0.0
    if rate == 0.0:
        out[0, 0] = out[1, 1] = out[2, 2] = 1.0
        return
    cosine, sine = math.cos(rate * time), math.sin(rate * time)
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        for k in range(3):
            out[a, k] = (1.0 - cosine) * spin[a] * spin[k] / rate**2
        out[a, a] += cosine
        out[a, b] += sine * spin[c] / rate
        out[a, c] -= sine * spin[b] / rate


@part
def _differ(first, second):
    """Whether two vectors (3,) differ."""
    return first[0] != second[0] or first[1] != second[1] or first[2] != second[2]


@kernel(alone=True)
def set_poses(y, order, base_positions, base_frames, spins, time, positions, frames):
    """positions = r⁰ + ρ and frames = cay(θ) R⁰ a ``time`` after the base was set."""
    rotation, base, turn, last = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), -1
    for slot in range(order.shape[0]):
        i = order[slot]
        lie.cayley(y[6 * slot + 3 : 6 * slot + 6], rotation)
        if last < 0 or _differ(spins[i], spins[last]):
            _rotated_axes(spins[i], time, turn)
            last = i
        for k in range(3):
            positions[i, k] = base_positions[i, k] + y[6 * slot + k]
            for a in range(3):
                base[a, k] = (
                    turn[a, 0] * base_frames[i, 0, k]
                    + turn[a, 1] * base_frames[i, 1, k]
                    + turn[a, 2] * base_frames[i, 2, k]
                )
        for a in range(3):
            for k in range(3):
                frames[i, a, k] = (
                    rotation[k, 0] * base[a, 0]
                    + rotation[k, 1] * base[a, 1]
                    + rotation[k, 2] * base[a, 2]
                )


@part
def _base_rotation(spin, frame, out):
    """out = Σ_a Ω_a e_a."""
    for k in range(3):
        out[k] = spin[0] * frame[0, k] + spin[1] * frame[1, k] + spin[2] * frame[2, k]


@part
def relative_rotation(spin, frame, twist, omega):
    """ω − Σ_a Ω_a e_a of a sphere."""
    _base_rotation(spin, frame, omega)
    for k in range(3):
        omega[k] = twist[3 + k] - omega[k]


@kernel(alone=True)
def set_rates(y, order, drift, spins, frames, twists, out):
    """out = (ρ̇, θ̇) = (v − V, dcay⁻¹(ω − Σ_a Ω_a e_a)) of every slot."""
    omega = np.empty(3)
    for slot in range(order.shape[0]):
        i = order[slot]
        for k in range(3):
            out[6 * slot + k] = twists[i, k] - drift[k]
        relative_rotation(spins[i], frames[i], twists[i], omega)
        lie.rate(y[6 * slot + 3 : 6 * slot + 6], omega, out[6 * slot + 3 : 6 * slot + 6])


@kernel(alone=True)
def largest_turn(y):
    """max |θ|."""
    largest = 0.0
    for slot in range(y.shape[0] // 6):
        x, z, w = y[6 * slot + 3], y[6 * slot + 4], y[6 * slot + 5]
        largest = max(largest, x * x + z * z + w * w)
    return math.sqrt(largest)


@kernel
def room_to_turn(y):
    """A quarter turn over the largest rotation of a sphere in y; large where nothing turns."""
    turn = math.atan(0.5 * largest_turn(y))
    return HALF_LIMIT / max(turn, SMALLEST_TURN)
