"""v_slip on the surface of a sphere: the slip whose flow has a mode's pair law as its far field."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

from nrchain.errors import NOT_GIVEN, SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.given_slips import given_slips
from nrchain.hydrodynamics.slip import Slip
from nrchain.hydrodynamics.slip_mode import SlipMode
from nrchain.inputs.arguments import rotations

SurfaceSlip: TypeAlias = Callable[[int, np.ndarray], np.ndarray]
"""Slip velocities (P, 3) of a sphere, by its index, at unit normals (P, 3); lab frame."""

SlipLike: TypeAlias = Mapping[str, float | np.ndarray | Slip] | SurfaceSlip
"""Strength of each mode by its label, as for ``active_wrenches``, or any surface velocity."""


def slip_velocity(mode: SlipMode, axis: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """v_slip/V = (1 + a²∇²/(4l + 2)) u/V at r = a, with u the pair law of the mode: (P, 3).

    The operator turns the leading singularity into the exact flow about an isolated sphere without
    force and torque. The value of that flow on the surface is the slip. ``axis`` is the unit
    vector e, ``normals`` are (P, 3).

    This is the slip printed in Table slip of Németh, Kobayashi and Adhikari times 7/5 (2s), 39/4
    (3a), 9 (3t, with v_r = (2/45) cos θ; with the printed (1/45) cos θ the sphere would swim) and
    −5445/2 (4a): V is the strength of the paper, not a slip speed.
    """
    cosine = normals @ axis
    basis = {"n": normals, "e": np.broadcast_to(axis, normals.shape), "x": np.cross(axis, normals)}
    slip = np.zeros_like(normals)
    for (along, _), row in mode.exterior_flow().items():
        factor = np.polynomial.polynomial.polyval(cosine, [float(p) for p in row])
        slip += factor[:, None] * basis[along]
    return slip


def surface_slip(slip: SlipLike, frames: np.ndarray | None, count: int) -> SurfaceSlip:
    """v_slip(i, n) of ``count`` spheres, as a function of sphere and normal.

    Strengths are numbers, (N,) arrays or a :class:`~nrchain.hydrodynamics.slip.Slip` with a body
    axis of its own (default e1); ``frames`` is (N, 3, 3), with e_{k+1} of sphere i in ``frames[i,
    k]``, and is not needed if the slip is already a function. Raises SceneError for unknown modes,
    wrong shapes and numbers that are not finite.
    """
    if callable(slip):
        return slip
    slips = given_slips(slip, count)
    if slips and frames is None:
        raise SceneError("frames", NOT_GIVEN, f"must be rotations of shape ({count}, 3, 3)")
    modes = [
        (slip_modes.find(label), strengths, axis @ rotations(frames, count))
        for label, strengths, axis in slips
    ]

    def velocities(sphere: int, normals: np.ndarray) -> np.ndarray:
        total = np.zeros_like(normals)
        for mode, strengths, axes in modes:
            total += strengths[sphere] * slip_velocity(mode, axes[sphere], normals)
        return total

    return velocities
