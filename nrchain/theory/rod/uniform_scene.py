"""What a scene must be for its chain to have uniform states of strain, and its parts that do.

A uniform state is a helix on which every sphere feels the same wrench in its own frame. Fields and
flows that are fixed in the lab, and strengths that differ between spheres, leave none.
"""

from __future__ import annotations

import numpy as np

from nrchain.effects.base import Effect, cross_matrix
from nrchain.effects.registry import acting
from nrchain.errors import SceneError
from nrchain.hydrodynamics.slip import Slip
from nrchain.scene.fluid_sections import SlipSpec
from nrchain.scene.loading import require_chosen
from nrchain.scene.scene import Scene


def uniform_slip(scene: Scene) -> dict[str, Slip]:
    """The active modes of a scene, each with one strength.

    Raises :class:`~nrchain.errors.SceneError` for strengths that differ between spheres, and for
    effects that are still to be chosen.
    """
    found = {}
    for label, slip in require_chosen(scene).slip.modes.items():
        strengths = np.unique(np.atleast_1d(slip.strength))
        if len(strengths) > 1:
            allowed = (
                "varies from sphere to sphere: a uniform state of strain needs one number for all"
            )
            raise SceneError(SlipSpec.key(label), slip.strength, allowed)
        if strengths[0] != 0.0:
            found[label] = Slip(float(strengths[0]), slip.axis)
    return found


def body_wrench(scene: Scene) -> np.ndarray:
    """(F, T) (6,) in its own frame that fields along the axes of a sphere give every sphere.

    Raises :class:`~nrchain.errors.SceneError` for all other fields and flows.
    """
    total = np.zeros(6)
    for effect in acting(scene):
        if not effect.fused:
            total += _body_part(effect, scene)
    return total


def _body_part(effect: type[Effect], scene: Scene) -> np.ndarray:
    wrench, change = effect.straight(scene)
    moved = np.abs(change[:, :3]).max() > 0.0
    rotated = np.zeros((6, 3))
    rotated[:3], rotated[3:] = (-cross_matrix(half[None])[0] for half in (wrench[:3], wrench[3:]))
    if effect.gives == "twist" or moved or not np.array_equal(change[:, 3:], rotated):
        what = "position" if moved else "direction, which is fixed in the lab"
        allowed = (
            f"varies along a strained chain with its {what}: no state of strain is uniform; remove"
            " it from the scene"
        )
        raise SceneError(effect.key, effect.value(scene), allowed)
    return wrench
