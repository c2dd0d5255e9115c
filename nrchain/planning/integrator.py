"""The integrator of a scene, before it is run."""

from __future__ import annotations

from nrchain.motion.integrators import resolve_name
from nrchain.motion.model import Model
from nrchain.scene.scene import Scene


def integrator_of(scene: Scene) -> str:
    """Its name: that of ``run.integrator``, or the one that ``"auto"`` stands for in this scene.

    >>> import nrchain
    >>> integrator_of(nrchain.load_scene("buckling"))
    'radau'
    """
    return resolve_name(scene.run.integrator, Model(scene).is_near)
