"""max |Δ(v, aω)| / max |(v, aω)|: what of a disturbed flow lies beyond its reach."""

from __future__ import annotations

import numpy as np

from nrchain.effects.base import largest_velocity
from nrchain.effects.flow import Flow
from nrchain.effects.registry import acting
from nrchain.effects.strain import DisturbanceEffect, Strain
from nrchain.planning.scene_changes import reaches_all
from nrchain.scene.scene import Scene, load_scene


def disturbance(scene: Scene, positions: np.ndarray) -> np.ndarray:
    """(v, ω) (N, 6) by which the spheres of a scene disturb its background flow, all parts."""
    twists = np.zeros((len(positions), 6))
    frames = np.broadcast_to(np.eye(3), (len(positions), 3, 3))
    for effect in acting(scene):
        if issubclass(effect, DisturbanceEffect):
            effect(scene).add_twists(positions, frames, twists)
    return twists


def reach_of_strain(scene: Scene, positions: np.ndarray) -> list[tuple[str, str, str]]:
    """A line of a plan, (quantity, value, meaning), where the disturbance is cut at neighbours."""
    reach, radius = Flow.section(scene).neighbours, scene.chain.radius
    if not Strain.acts(scene) or reaches_all(scene, reach):
        return []
    whole = disturbance(load_scene(scene, **{"flow.neighbours": "all"}), positions)
    left = largest_velocity(whole - disturbance(scene, positions), radius)
    largest = largest_velocity(whole, radius)
    meaning = (
        f"of the velocities by which spheres disturb the flow at the start, beyond {reach} a side;"
        " flow.neighbours = 'all' keeps it"
    )
    return [
        ("reach of strain", f"{100.0 * left / largest if largest else 0.0:.3g} % left out", meaning)
    ]
