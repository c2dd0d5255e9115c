"""u(S x, S e) = ± S u(x, e): the symmetry that slip modes leave to a chain.

An operation S maps the flow of a mode with axis e to that with axis S e, times det S if the mode is
chiral. A polar mode changes sign with its axis. Axes off e₁ leave no rotation about e₁ but half
turns: the group is finite.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product

import numpy as np

from nrchain.errors import SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.inputs.arguments import finite_array
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.theory.rod.symmetry import SAME, Matrix, Symmetry


def slip_symmetry(scene: Scene) -> Symmetry:
    """The symmetry that the slip of a scene leaves to its chain; that of all modes together.

    The elasticity has every symmetry of the line. Raises :class:`~nrchain.errors.SceneError` for
    anything but a scene.
    """
    scene = require_scene(scene)
    return symmetry_of_modes(
        {
            label: slip.axis
            for label, slip in scene.slip.modes.items()
            if np.any(np.asarray(slip.strength))
        }
    )


def symmetry_of_modes(axes: Mapping[str, tuple[float, float, float]]) -> Symmetry:
    """The symmetry of modes with these body axes, by label.

    >>> from nrchain.rod import symmetry_of_modes
    >>> str(symmetry_of_modes({"2s": (1, 0, 0), "3a": (1, 0, 0)}))
    'transversely isotropic, apolar, chiral'
    """
    units = {}
    for label, axis in axes.items():
        vector = finite_array(f"axis of {label}", axis, (3,))
        if not vector.any():
            raise SceneError(f"axis of {label}", axis, "must not be zero")
        units[label] = vector / np.linalg.norm(vector)
    across = [unit[1:] for unit in units.values() if np.abs(unit[1:]).max() > SAME]
    # an operation maps each axis to itself: it is diagonal along and across the first one off e₁
    c, s = across[0] / np.linalg.norm(across[0]) if across else (1.0, 0.0)
    basis = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    found = [
        basis @ np.diag(signs) @ basis.T
        for signs in product((1.0, -1.0), repeat=3)
        # a turn about e₁ adds nothing to an isotropic group
        if across or signs[1] == 1.0
    ]
    operations = tuple(
        S for S in found if all(_keeps(S, label, unit) for label, unit in units.items())
    )
    return Symmetry(not across, operations)


def _keeps(operation: Matrix, label: str, axis: Matrix) -> bool:
    """Whether an operation leaves a mode with this axis unchanged."""
    mode, image = slip_modes.find(label), operation @ axis
    along = float(image @ axis)
    if not math.isclose(abs(along), 1.0, abs_tol=SAME):
        return False
    sign = math.copysign(1.0, along) if mode.polar else 1.0
    return sign * (np.linalg.det(operation) if mode.chiral else 1.0) > 0.0
