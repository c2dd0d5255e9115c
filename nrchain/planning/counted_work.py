"""Nominal seconds of one right-hand side of a scene: counted, and so the same on every machine.

Choices must not depend on how busy a machine is. Work is therefore counted, in the time that its
parts take on one core of a present-day machine: the loop of the integrator, the elastic chain,
pairs of slip flow and pairs of friction, each with the products and solves that come with a
right-hand side. Absolute times are good to a factor of two, ratios between scenes of one chain to
some ten per cent.
"""

from __future__ import annotations

import math

from nrchain.effects.shared.slip_flow import active_modes
from nrchain.hydrodynamics.images import EXACT, POINTS
from nrchain.hydrodynamics.pairs import NEAR
from nrchain.hydrodynamics.tree.accuracy import break_even
from nrchain.planning.flow_keys import finite_size_sections
from nrchain.planning.hydrodynamic_set import HydrodynamicSet
from nrchain.potential.chain import REACH
from nrchain.scene.scene import Scene

LOOP, SPHERE = 50e-6, 0.7e-6
"""Seconds of the integrator itself, and of one sphere with its links."""

COMPILED_LOOP, COMPILED_SPHERE, COMPILED_BLOCK = 2e-6, 0.45e-6, 0.1e-6
"""The same for Radau IIA on near neighbours, in compiled code, with factors and solves; and of one
sphere with one neighbour more than elasticity couples, which widens every factorisation."""

PRODUCTS = 2.2
"""Products with the Jacobian that come with a right-hand side."""

SLIP_PAIR, SLIP_PRODUCT = 1.0e-9, 2.5e-9
"""Seconds of one pair of one mode, or of one part of the disturbance of a flow, and of its product
with the Jacobian."""

MODE, FINITE_SIZE = 0.3, 0.2
"""What a further mode and the finite size of slip add, over the work of one mode."""

FRICTION_PAIR, FRICTION_PRODUCT, FRICTION_CALL = 1.8e-9, 3.9e-9, 5e-6
"""Seconds of one pair of friction, of its product with the Jacobian, and of one call."""

SUPPORT = 35e-6
"""Seconds of the wrenches by which clamps hold their spheres against friction with all others."""

BLOCK = 0.05e-6
"""Seconds of the exact blocks of one sphere with one more neighbour, for one Jacobian."""

IMAGES = (2 * (EXACT + POINTS) + 1) / 2
"""Half the number of periodic images that all pairs include."""


def evaluation_work(scene: Scene, fluid: HydrodynamicSet | None = None) -> float:
    """Nominal seconds of one right-hand side of a run, with the products and solves it needs.

    ``fluid`` replaces the scene's own set of flows.
    """
    fluid = fluid or HydrodynamicSet.of_scene(scene)
    count = scene.chain.particles
    farthest = min(max(fluid.slip, fluid.strain), count - 1.0)
    clamped = scene.chain.ends == "clamped" and fluid.friction > 0.0
    through_pairs = clamped or max(farthest, fluid.friction) > NEAR
    if through_pairs or scene.run.integrator not in ("auto", "radau"):
        return interpreted_work(scene, fluid)
    wider = max(farthest - REACH, fluid.friction, 0.0)
    return COMPILED_LOOP + (COMPILED_SPHERE + COMPILED_BLOCK * wider) * count


def interpreted_work(scene: Scene, fluid: HydrodynamicSet | None = None) -> float:
    """As :func:`evaluation_work` for backward differences, which a probe always takes."""
    fluid = fluid or HydrodynamicSet.of_scene(scene)
    count = scene.chain.particles
    cost = LOOP + SPHERE * count
    pairwise = fluid.friction > 0.0
    flows = _flows(scene, fluid)
    through_pairs = pairwise or any(reach > NEAR for reach, _ in flows)
    for reach, each in flows:
        pairs = 2 * reach * count
        cost += SLIP_PAIR * pairs * each
        if through_pairs:
            cost += PRODUCTS * (FRICTION_CALL + SLIP_PRODUCT * pairs * each)
    cost += BLOCK * count * max((reach - 1 for reach, _ in flows if reach <= NEAR), default=0.0)
    if pairwise:
        pairs = 2 * _places(scene, fluid.friction) * count
        cost += FRICTION_CALL + FRICTION_PAIR * pairs
        cost += PRODUCTS * (FRICTION_CALL + FRICTION_PRODUCT * pairs)
        if scene.chain.ends == "clamped":
            cost += (1.0 + PRODUCTS) * SUPPORT
    return cost


def _flows(scene: Scene, fluid: HydrodynamicSet) -> list[tuple[float, float]]:
    """Of slip and disturbance: neighbours on each side, and work of a pair in that of a mode."""
    sizes = finite_size_sections(scene) if fluid.finite_size else {}
    flows = []
    if fluid.slip:
        work = 1.0 + MODE * (len(active_modes(scene)) - 1)
        work += FINITE_SIZE * ("finite size" in sizes)
        flows.append((_places(scene, fluid.slip), work))
    if fluid.strain:
        flows.append((_places(scene, fluid.strain), 1.0 + ("finite size of strain" in sizes)))
    return flows


def _places(scene: Scene, reach: float) -> float:
    """Neighbours on each side, averaged over a chain whose ends have fewer."""
    count = scene.chain.particles
    if scene.chain.ends == "periodic":
        return IMAGES * count if math.isinf(reach) else reach
    if math.isinf(reach) and count >= (tree := break_even(scene.pair_accuracy)):
        # a sphere takes as long as in the direct sum of the shortest chain with a tree
        return 0.5 * (tree - 1)
    places = min(reach, count - 1)
    return places * (2 * count - places - 1) / (2 * count)
