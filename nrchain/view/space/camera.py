"""Where the camera stands: from where it looks, and how far away it must be to see everything."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.rules import is_number

VIEWS = {
    "slant": (-64.0, 24.0),
    "x": (0.0, 0.0),
    "y": (-90.0, 0.0),
    "z": (-90.0, 90.0),
}
"""Azimuth about z, from x, and elevation above the plane xy of named views, in degrees.

``"y"`` shows the plane xz and ``"z"`` the plane xy, both with x to the right; ``"x"`` looks along
the chain.
"""

ANGLE = 25.0
"""Angle of the picture from its lower to its upper edge, in degrees."""

View = str | tuple[float, float]


def direction(view: View) -> tuple[float, float]:
    """Azimuth and elevation of a view, in degrees: a name of :data:`VIEWS`, or both numbers."""
    if isinstance(view, str) and view in VIEWS:
        return VIEWS[view]
    parts = view.split(",") if isinstance(view, str) else view
    try:
        given = tuple(float(one) for one in parts)
    except (TypeError, ValueError):
        given = ()
    if len(given) != 2 or not all(map(is_number, given)) or abs(given[1]) > 90.0:
        allowed = (
            f"must be one of {', '.join(VIEWS)}, or azimuth,elevation in degrees, such as -64,24;"
            " the elevation lies between -90 and 90"
        )
        raise SceneError("view", view, allowed)
    return given[0], given[1]


@dataclass(frozen=True)
class Window:
    """The part of a picture that the chain may fill.

    ``low`` and ``high``, (2,) each, are tangents of the angles from the middle of the picture to
    its left and lower, and to its right and upper edge.
    """

    low: np.ndarray
    high: np.ndarray

    @classmethod
    def within(cls, aspect: float, side: float, above: float, below: float) -> Window:
        """The window of a picture of ``aspect`` = width/height with these margins, in fractions."""
        half = math.tan(math.radians(ANGLE / 2))
        wide = aspect * (1 - 2 * side)
        return cls(
            half * np.array([-wide, 2 * below - 1]),
            half * np.array([wide, 1 - 2 * above]),
        )


@dataclass(frozen=True)
class Camera:
    """A place to look from: ``position``, ``focus`` and ``up``, (3,) each."""

    position: np.ndarray
    focus: np.ndarray
    up: np.ndarray

    def moved(self, by: np.ndarray) -> Camera:
        """The camera, moved without turning."""
        return Camera(self.position + by, self.focus + by, self.up)


def fit(points: np.ndarray, margin: float, view: View, window: Window) -> Camera:
    """The nearest camera from a direction that sees spheres of radius ``margin`` about all points.

    They are all inside the window, and centred in it.
    """
    azimuth, elevation = np.radians(direction(view))
    to_camera = np.array(
        [
            math.cos(elevation) * math.cos(azimuth),
            math.cos(elevation) * math.sin(azimuth),
            math.sin(elevation),
        ]
    )
    right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    axes = np.array([right, np.cross(to_camera, right), to_camera])
    seen = points.reshape(-1, 3) @ axes.T
    across, depth = seen[:, :2], seen[:, 2]
    # the edges are planes through the camera: with the camera at (c, D), a sphere is inside if
    # low (D - depth) + room <= across - c <= high (D - depth) - room
    most = (across + depth[:, None] * window.high).max(axis=0)
    least = (across + depth[:, None] * window.low).min(axis=0)
    most += margin * np.hypot(1.0, window.high)
    least -= margin * np.hypot(1.0, window.low)
    distance = float(((most - least) / (window.high - window.low)).max())
    distance = max(distance, depth.max() + 2 * margin)
    middle = (most + least - distance * (window.high + window.low)) / 2
    focus = axes.T @ np.array([*middle, depth.max()])
    return Camera(axes.T @ np.array([*middle, distance]), focus, axes[1])
