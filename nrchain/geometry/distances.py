"""|r − r′| and ∠(frame, frame′): how far spheres are from where they are compared with."""

from __future__ import annotations

import numpy as np

from nrchain.types import Poses


def pose_distances(poses: Poses, others: Poses) -> tuple[np.ndarray, np.ndarray]:
    """Distance and angle (…, N) of spheres between two sets of poses (…, N, 3), (…, N, 3, 3).

    The angle of the rotation between both frames is exact to rounding.

    >>> here = np.zeros((1, 3)), np.eye(3)[None]
    >>> there = np.array([[3.0, 4.0, 0.0]]), np.diag([-1.0, -1.0, 1.0])[None]
    >>> [float(apart[0]) for apart in pose_distances(here, there)]
    [5.0, 3.141592653589793]
    """
    apart = np.linalg.norm(poses[0] - others[0], axis=-1)
    between = np.einsum("...ak,...am->...km", poses[1], others[1])
    sine = np.linalg.norm(
        [between[..., (k + 2) % 3, (k + 1) % 3] - between[..., (k + 1) % 3, (k + 2) % 3]
         for k in range(3)],
        axis=0,
    )  # fmt: skip
    cosine = np.trace(between, axis1=-2, axis2=-1) - 1.0
    return apart, np.arctan2(sine, cosine)
