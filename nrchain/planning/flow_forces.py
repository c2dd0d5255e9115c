"""u = (3a/4r)(I + n n)·F/γ_T against (5a³/2r²) n·E·n: what one-body friction drops in a flow.

Spheres that are held or pushed against a background flow set up Stokeslets, of order a/r. One-body
friction leaves them out, as it does all flows of forces; the disturbance of the flow by the rigid
spheres, of order (a/r)², it leaves in. The larger is then missing beside the smaller.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain.effects.flow import Flow
from nrchain.effects.shared.image_sums import net_forces, takes_all
from nrchain.effects.strain import Strain
from nrchain.scene.scene import Scene


def dropped_and_kept(
    scene: Scene, positions: np.ndarray, frames: np.ndarray
) -> tuple[float, float]:
    """Largest velocities at a neighbour, at rest spacing: (3a/2d)|F|/γ_T and (5/2)(a/d)³|E|d.

    F is what acts on a sphere at these poses from outside the chain: the forces of effects that do
    not add up to nothing, and what holds a clamped end against the flow. Forces within the chain
    add up to nothing and are left out.
    """
    wrenches = np.zeros((len(positions), 6))
    for effect in net_forces(scene):
        effect(scene).add_wrenches(positions, frames, wrenches)
    velocities = wrenches[:, :3] / scene.drag.translation
    if scene.chain.ends == "clamped":
        twists = np.zeros_like(wrenches)
        Flow(scene).add_twists(positions, frames, twists)
        velocities[[0, -1]] = -twists[[0, -1], :3]
    largest = float(np.linalg.norm(velocities, axis=1).max())
    return 1.5 * scene.chain.radius / scene.chain.spacing * largest, Strain.scale(scene)


def stokeslet_warning(scene: Scene, positions: np.ndarray, frames: np.ndarray) -> str:
    """That a scene keeps the smaller of the two flows and drops the larger; empty if it does not.

    With what would mend it: friction between spheres, of all pairs where they have a sum.
    """
    if scene.friction.kind != "one-body" or not Strain.acts(scene):
        return ""
    with np.errstate(all="ignore"):
        dropped, kept = dropped_and_kept(scene, positions, frames)
    if not kept < dropped < math.inf:
        return ""
    return (
        f"spheres held or pushed against the flow give a neighbour a velocity of up to"
        f" {dropped:.2g}, of order a/r, which one-body friction drops, while their disturbance of"
        f" the strain, up to {kept:.2g} and of order (a/r)², is kept; {_remedy(scene)}"
    )


def _remedy(scene: Scene) -> str:
    if takes_all(scene):
        return "friction = 'pairwise' keeps both"
    return "friction.kind = 'pairwise' with a number for friction.neighbours keeps both"
