"""r_i = r_i⁰ + V (t − t⁰) + ρ_i, R_i = cay(θ_i) R_i⁰(t): a chart in compiled code.

The same coordinates as those of :mod:`nrchain.motion.charts`, for all spheres in their order along
the chain: y is (N, 6), and zero for clamped spheres. Kernels here do not return to the
interpreter, unless a term of the model does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrchain._addresses import (
    address_of,
    blocks_in,
    cube_in,
    floats_at,
    integers_at,
    matrix_in,
    vector_in,
)
from nrchain._compile import part
from nrchain.geometry import lie
from nrchain.motion.chart_jacobian import set_tangents, transform_blocks
from nrchain.motion.chart_poses import set_poses, set_rates
from nrchain.motion.terms import FLAGS, HELD, set_blocks, set_carrying_twists, set_twists


class Chart(NamedTuple):
    """The base of a chart, and scratch space, in the order of a table of addresses.

    Attributes
    ----------
    places, near, frames
        r⁰ (N, 3) in the lab and relative to ``origin``, and R⁰ (N, 3, 3).
    spins
        (N, 3), Ω of every base along its own axes.
    drift, origin, clock
        V (3,), the origin at t⁰ (3,), and t⁰ (1,).
    order
        0 … N−1.
    positions, turned, twists, maps, turning
        Scratch: poses, (v, ω), tangents of the Cayley map, and Ω in the lab.
    """

    places: np.ndarray
    near: np.ndarray
    frames: np.ndarray
    spins: np.ndarray
    drift: np.ndarray
    origin: np.ndarray
    clock: np.ndarray
    order: np.ndarray
    positions: np.ndarray
    turned: np.ndarray
    twists: np.ndarray
    maps: np.ndarray
    turning: np.ndarray


def empty_chart(count: int) -> Chart:
    """A chart for ``count`` spheres, without a base."""
    return Chart(
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        np.zeros((count, 3, 3)),
        np.zeros((count, 3)),
        np.zeros(3),
        np.zeros(3),
        np.zeros(1),
        np.arange(count),
        np.zeros((count, 3)),
        np.zeros((count, 3, 3)),
        np.zeros((count, 6)),
        np.zeros((count, 3, 3, 3)),
        np.zeros((count, 3)),
    )


# Places of these arrays in the table of a chain (:func:`nrchain._addresses.table_of`).
PLACES, NEAR, FRAMES, SPINS, DRIFT, ORIGIN, CLOCK, ORDER = range(8)
POSITIONS, TURNED, TWISTED, MAPS, TURNING = range(8, 13)


@part
def _set_near(t, time, y, positions, frames):
    """Poses at y, relative to the origin that drifts with the base."""
    set_poses(
        y,
        vector_in(t, ORDER, integers_at),
        matrix_in(t, NEAR, floats_at),
        cube_in(t, FRAMES, floats_at),
        matrix_in(t, SPINS, floats_at),
        time - vector_in(t, CLOCK, floats_at)[0],
        positions,
        frames,
    )


@part
def _move_to_lab(t, time, positions):
    """positions += the origin at this time; clamped spheres are where they are to the last bit."""
    since = time - vector_in(t, CLOCK, floats_at)[0]
    origin, drift = vector_in(t, ORIGIN, floats_at), vector_in(t, DRIFT, floats_at)
    held, places = vector_in(t, HELD, integers_at), matrix_in(t, PLACES, floats_at)
    for i in range(positions.shape[0]):
        for k in range(3):
            positions[i, k] += origin[k] + drift[k] * since
            if held[i]:
                positions[i, k] = places[i, k]


@part
def set_lab_poses(t, time, y, positions, frames):
    """Poses at coordinates y (6N) in the lab."""
    _set_near(t, time, y, positions, frames)
    _move_to_lab(t, time, positions)


@part
def _set_twists(t, time, y):
    """Poses and twists at y in the scratch space of the chart; returns a status.

    Interactions depend on differences of positions, which lose digits far from the origin of the
    lab: they see positions relative to the origin of the chart, unless a term needs the lab.
    """
    positions, frames = matrix_in(t, POSITIONS, floats_at), cube_in(t, TURNED, floats_at)
    _set_near(t, time, y, positions, frames)
    if vector_in(t, FLAGS, integers_at)[1]:
        _move_to_lab(t, time, positions)
    return set_twists(t, t[POSITIONS, 0], t[TURNED, 0], matrix_in(t, TWISTED, floats_at))


@part
def set_y_rates(t, time, y, out):
    """out (6N) = ẏ; returns a status."""
    status = _set_twists(t, time, y)
    set_rates(
        y,
        vector_in(t, ORDER, integers_at),
        vector_in(t, DRIFT, floats_at),
        matrix_in(t, SPINS, floats_at),
        cube_in(t, TURNED, floats_at),
        matrix_in(t, TWISTED, floats_at),
        out,
    )
    return status


@part
def linearise(t, time, y, blocks):
    """blocks (N, 2w + 1, 6, 6) = ∂ẏ_i/∂y_{i+m−w}; returns a status."""
    status = _set_twists(t, time, y)
    if status:
        return status
    order, spins = vector_in(t, ORDER, integers_at), matrix_in(t, SPINS, floats_at)
    turned, turning = cube_in(t, TURNED, floats_at), matrix_in(t, TURNING, floats_at)
    maps = blocks_in(t, MAPS, floats_at)
    set_tangents(y, order, spins, turned, matrix_in(t, TWISTED, floats_at), maps)
    for i in range(order.shape[0]):
        for k in range(3):
            turning[i, k] = 0.0
            for a in range(3):
                turning[i, k] += spins[i, a] * turned[i, a, k]
    status = set_blocks(t, t[POSITIONS, 0], t[TURNED, 0], blocks)
    transform_blocks(blocks, order, maps, turning)
    return status


@part
def rebase(t, time, positions, frames):
    """Take these poses in the lab as the base at ``time``; ``frames`` are orthonormalised.

    The base drifts and spins as slip, fields and flows move the chain: see
    :meth:`nrchain.motion.charts.ChartedChain.rebase`. Returns a status.
    """
    count, clamps = positions.shape[0], vector_in(t, FLAGS, integers_at)[0]
    drift, spins = vector_in(t, DRIFT, floats_at), matrix_in(t, SPINS, floats_at)
    lie.orthonormalise(frames)
    vector_in(t, CLOCK, floats_at)[0] = time
    drift[:] = 0.0
    spins[:] = 0.0
    if not clamps:
        twists = matrix_in(t, TWISTED, floats_at)
        status = set_carrying_twists(t, address_of(positions), address_of(frames), twists)
        if status:
            return status
        _set_motion(t, frames, twists, drift, spins)
    origin, held = vector_in(t, ORIGIN, floats_at), vector_in(t, HELD, integers_at)
    origin[:] = 0.0
    for i in range(count):
        for k in range(3):
            if not clamps:
                origin[k] += positions[i, k] / count
            elif held[i]:
                # any clamped sphere will do
                origin[k] = positions[i, k]
    places, near = matrix_in(t, PLACES, floats_at), matrix_in(t, NEAR, floats_at)
    base = cube_in(t, FRAMES, floats_at)
    for i in range(count):
        for k in range(3):
            for a in range(3):
                base[i, a, k] = frames[i, a, k]
            places[i, k] = positions[i, k]
            near[i, k] = positions[i, k] - origin[k]
    return 0


@part
def _set_motion(t, frames, twists, drift, spins):
    """The mean drift and spin of twists, or the spin of every sphere where frames are free."""
    count, spin = frames.shape[0], 0.0
    for i in range(count):
        for k in range(3):
            drift[k] += twists[i, k] / count
            spin += twists[i, 3 + k] * frames[i, 0, k] / count
    coupled = vector_in(t, FLAGS, integers_at)[2]
    for i in range(count):
        spins[i, 0] = spin
        if not coupled:
            for a in range(3):
                spins[i, a] = (
                    frames[i, a, 0] * twists[i, 3]
                    + frames[i, a, 1] * twists[i, 4]
                    + frames[i, a, 2] * twists[i, 5]
                )


@part
def set_coordinates(t, time, still, positions, frames, out):
    """out (6N) = y of poses in the lab at ``time``, 0 for clamped spheres; ``still`` is y = 0."""
    held, rotation = vector_in(t, HELD, integers_at), np.empty((3, 3))
    places, turned = matrix_in(t, POSITIONS, floats_at), cube_in(t, TURNED, floats_at)
    set_lab_poses(t, time, still, places, turned)
    for i in range(positions.shape[0]):
        if held[i]:
            out[6 * i : 6 * i + 6] = 0.0
            continue
        for k in range(3):
            out[6 * i + k] = positions[i, k] - places[i, k]
            for m in range(3):
                rotation[k, m] = (
                    frames[i, 0, k] * turned[i, 0, m]
                    + frames[i, 1, k] * turned[i, 1, m]
                    + frames[i, 2, k] * turned[i, 2, m]
                )
        lie.inverse_cayley(rotation, out[6 * i + 3 : 6 * i + 6])
