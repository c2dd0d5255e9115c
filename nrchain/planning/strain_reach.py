"""max |Δ(v, aω)| / max |(v, aω)|: the part of the disturbance of a flow beyond its reach."""

from __future__ import annotations

import numpy as np

from nrchain.effects.base import largest_velocity
from nrchain.effects.flow import Flow
from nrchain.effects.registry import acting
from nrchain.effects.shared.slip_flow import reach_text
from nrchain.effects.strain import DisturbanceEffect, Strain
from nrchain.planning.flow_keys import is_all_pairs
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


def disturbance(scene: Scene, positions: np.ndarray) -> np.ndarray:
    """(v, ω) (N, 6) by which all spheres disturb the background flow at each."""
    twists = np.zeros((len(positions), 6))
    frames = np.broadcast_to(np.eye(3), (len(positions), 3, 3))
    for effect in acting(scene):
        if issubclass(effect, DisturbanceEffect):
            effect(scene).add_twists(positions, frames, twists)
    return twists


def strain_reach_rows(scene: Scene, positions: np.ndarray) -> list[tuple[str, str, str]]:
    """The line of a plan, (quantity, value, meaning), if the disturbance is cut at neighbours."""
    reach, radius = Flow.section(scene).neighbours, scene.chain.radius
    if not Strain.acts(scene) or is_all_pairs(scene, reach):
        return []
    whole = disturbance(load_scene(scene, **{"flow.neighbours": "all"}), positions)
    left = largest_velocity(whole - disturbance(scene, positions), radius)
    largest = largest_velocity(whole, radius)
    meaning = (
        f"of the velocities due to the disturbance at the start, beyond {reach_text(reach)};"
        " flow.neighbours = 'all' keeps it"
    )
    return [
        ("reach of strain", f"{100.0 * left / largest if largest else 0.0:.3g} % left out", meaning)
    ]
