"""Positions, links and arguments, as all measurements take them."""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from nrchain.errors import NrchainError, SceneError, shorten
from nrchain.scene.unwrapping import unwrapped_chain
from nrchain.trajectory.trajectory import Trajectory

Array = NDArray[np.floating]

NOISE = 3.0
"""Uncertainty of an amplitude, in tolerances of the run: measured on decaying waves."""


class MeasurementError(NrchainError, ValueError):
    """A trajectory on which the quantity cannot be measured."""


def require_trajectory(given: object) -> Trajectory:
    """The trajectory given. Anything else raises a MeasurementError that says how to get one."""
    if not isinstance(given, Trajectory):
        allowed = "must be a Trajectory, as simulate and Trajectory.open return"
        raise MeasurementError(f"trajectory = {shorten(given)}: {allowed}")
    return given


def positions_of(trajectory: Trajectory) -> Array:
    """(T, N, 3) positions, unwrapped if the chain is periodic and elastic.

    Raises :class:`MeasurementError` where the image of a sphere is not clear.
    """
    try:
        return unwrapped_chain(require_trajectory(trajectory).scene, trajectory.positions)
    except SceneError as error:
        raise MeasurementError(str(error)) from error


def links_of(trajectory: Trajectory) -> Array:
    """(T, L, 3) from each sphere to the next; a periodic chain's last one closes it."""
    positions = positions_of(trajectory)
    links = np.diff(positions, axis=1)
    if trajectory.scene.chain.ends != "periodic":
        return links
    closing = positions[:, :1] - positions[:, -1:]
    closing[..., 0] += trajectory.scene.length
    return np.concatenate([links, closing], axis=1)


def real_number(
    name: str, given: object, *, least: float | None = None, most: float = sys.float_info.max
) -> float:
    """The number given, between ``least`` (None: −``most``) and ``most``, or a MeasurementError."""
    plain = given.item() if isinstance(given, np.generic) else given
    low = -most if least is None else least
    if isinstance(plain, bool) or not isinstance(plain, int | float) or not low <= plain <= most:
        words = "" if least is None else f" of at least {least:g}"
        raise MeasurementError(f"{name} = {shorten(given)}: must be a real number{words}")
    return float(plain)
