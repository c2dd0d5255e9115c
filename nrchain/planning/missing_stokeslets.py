"""u = (3a/4r)(I + n n)·F/γ_T against (5a³/2r²) n·E·n: the flow that one-body friction drops.

Spheres that are held or pushed against a background flow set up Stokeslets, of order a/r. One-body
friction leaves them out, as it does all flows of forces. It keeps the disturbance of the flow by
the rigid spheres, of order (a/r)². The scene then keeps the smaller flow and drops the larger.
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

    F is the force on a sphere at these poses from outside the chain: that of effects with a net
    force, and that which holds a clamped end against the flow. Forces within the chain have no net
    force and are left out.
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
    """A warning, with its remedy, if a scene keeps the smaller flow and drops the larger.

    Empty otherwise. The remedy is friction between spheres, of all pairs where they have a sum.
    """
    if scene.friction.kind != "one-body" or not Strain.acts(scene):
        return ""
    with np.errstate(all="ignore"):
        dropped, kept = dropped_and_kept(scene, positions, frames)
    if not kept < dropped < math.inf:
        return ""
    return (
        f"one-body friction drops the flow of spheres that are held or pushed, up to v ="
        f" {dropped:.2g} at a neighbour and of order a/r, and keeps the smaller disturbance of the"
        f" strain, up to v = {kept:.2g} and of order (a/r)²; {_remedy(scene)}"
    )


def _remedy(scene: Scene) -> str:
    if takes_all(scene):
        return "friction = 'pairwise' keeps both"
    return "friction.kind = 'pairwise' with a number for friction.neighbours keeps both"
