"""V, Ω and straightness: how a chain moves as a whole."""

from __future__ import annotations

import math

import numpy as np

from nrchain.analysis.measure.line_fit import Estimate, first_snapshot, slope
from nrchain.analysis.measured_chain import (
    Array,
    MeasurementError,
    links_of,
    positions_of,
    require_trajectory,
)
from nrchain.scene.unwrapping import has_images, is_wrapped
from nrchain.trajectory.trajectory import Trajectory


def translation(
    trajectory: Trajectory, start: float | None = None
) -> tuple[Estimate, Estimate, Estimate]:
    """V = d/dt Σ_i r_i/N: the components of the mean velocity, by least squares from ``start``.

    With ``start`` None, from the first snapshot. Raises
    :class:`~nrchain.analysis.measured_chain.MeasurementError` for fewer than four snapshots, and
    for an elastic periodic chain that is wrapped: how often it went around its period is lost.
    """
    first = first_snapshot(require_trajectory(trajectory).time, start)
    _refuse_wrapped(trajectory)
    centre = trajectory.positions[first:].mean(axis=1)
    x, y, z = (slope(trajectory.time[first:], centre[:, k]) for k in range(3))
    return x, y, z


def spin(trajectory: Trajectory, start: float | None = None) -> Estimate:
    """Ω = d/dt of :func:`turned_angle`, in radians per time, by least squares from ``start`` on.

    Arguments and errors as for :func:`translation` and :func:`turned_angle`.
    """
    first = first_snapshot(require_trajectory(trajectory).time, start)
    return slope(trajectory.time[first:], turned_angle(trajectory)[first:])


def turned_angle(trajectory: Trajectory) -> Array:
    """(T,) angle in radians by which the spheres have turned about their own e₁, on average.

    From one snapshot to the next each sphere turns by the smallest rotation that brings e₁ to its
    new direction, followed by an angle about e₁. The frames give that angle up to whole turns. The
    mean angular velocity of the model at both snapshots gives the number of turns.

    Raises :class:`~nrchain.analysis.measured_chain.MeasurementError`, with the time, where the
    snapshots are too far apart: where the angle of a sphere is more than a quarter turn from the
    model's, or an axis has swung by more than a right angle.
    """
    from nrchain.motion.model import Model

    frames, time = require_trajectory(trajectory).frames, trajectory.time
    positions = positions_of(trajectory)
    model = Model(trajectory.scene)
    rates = np.empty(len(time))
    for k in range(len(time)):
        omega = model.twists(positions[k], frames[k])[:, 3:]
        rates[k] = np.einsum("ik,ik->i", omega, frames[k, :, 0]).mean()
    relative = np.einsum("tiak,tibk->tiab", frames[:-1], frames[1:])
    seen = np.arctan2(
        relative[..., 2, 1] - relative[..., 1, 2], relative[..., 1, 1] + relative[..., 2, 2]
    )
    expected = ((rates[:-1] + rates[1:]) / 2.0 * np.diff(time))[:, None]
    turned = seen + 2.0 * math.pi * np.round((expected - seen) / (2.0 * math.pi))
    lost = (np.abs(turned - expected) > math.pi / 2.0) | (relative[..., 0, 0] < 0.0)
    if lost.any():
        k = int(np.argmax(lost.any(axis=1)))
        raise MeasurementError(
            f"snapshots too far apart: between t = {time[k]:.6g} and {time[k + 1]:.6g} the frames"
            " do not tell by which angle the spheres turn"
        )
    return np.concatenate([[0.0], np.cumsum(turned.mean(axis=1))])


def straightness(trajectory: Trajectory) -> Array:
    """(T,) end-to-end distance over the length of all links: 1 for a straight chain.

    On a periodic chain the end-to-end distance is its period.
    """
    links = links_of(trajectory)
    across = np.linalg.norm(links.sum(axis=1), axis=1)
    return across / np.linalg.norm(links, axis=2).sum(axis=1)


def _refuse_wrapped(trajectory: Trajectory) -> None:
    """Raise for a chain whose positions were put back into a box."""
    if not has_images(trajectory.scene):
        return
    positions_of(trajectory)
    wrapped = is_wrapped(trajectory.positions, trajectory.scene.chain.spacing)
    if wrapped.any():
        raise MeasurementError(
            f"positions[{int(np.argmax(wrapped))}]: the chain is wrapped, and how often it went "
            "around its period as a whole is lost: give the positions of the unwrapped chain"
        )
