"""Seconds per right-hand side, counted: what a scene costs, the same on every machine.

Choices must not depend on how busy a machine is. The work is therefore counted, in the time that
its parts take on one core of a present-day machine: the loop of the integrator, the elastic chain,
pairs of slip flow and pairs of friction, each with the products and solves that come with a
right-hand side. Absolute times are good to a factor of two, ratios between scenes of one chain to
some ten per cent.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Self

from nrchain.effects.shared.slip_flow import active_modes
from nrchain.hydrodynamics.images import EXACT, POINTS
from nrchain.hydrodynamics.pairs import NEAR
from nrchain.planning.scene_changes import reaching, sized
from nrchain.scene.scene import Scene, load_scene

LOOP, SPHERE = 50e-6, 0.7e-6
"""Seconds of the integrator's own, and of one sphere with its links."""

PRODUCTS = 2.2
"""Products with the Jacobian that come with a right-hand side."""

SLIP_PAIR, SLIP_PRODUCT = 1.0e-9, 2.5e-9
"""Of one pair of one mode, or of one part of the disturbance of a flow; a further mode adds
:data:`MODE` of it, the finite size of slip a fifth."""

MODE, FINITE_SIZE = 0.3, 0.2

FRICTION_PAIR, FRICTION_PRODUCT, FRICTION_CALL = 1.8e-9, 3.9e-9, 5e-6
SUPPORT = 35e-6
"""Of the wrenches by which clamps hold their spheres against friction with all others."""

BLOCK = 0.05e-6
"""Of the exact blocks of one sphere with one further neighbour, over the life of a Jacobian."""

IMAGES = (2 * (EXACT + POINTS) + 1) / 2
"""Images of a periodic chain that all pairs take in, over two."""


class Fluid(NamedTuple):
    """How much of the fluid between spheres is simulated: what a choice of effects decides.

    ``friction``, ``slip`` and ``strain`` are the reaches of friction between spheres, of the slip
    flows and of the disturbance of a background flow: infinite for all pairs, 0 for none.
    ``finite_size`` is whether any of the flows has its own.
    """

    friction: float
    slip: float
    strain: float
    finite_size: bool

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """That of a scene."""
        friction = scene.friction
        places = _number(friction.neighbours) if friction.kind == "pairwise" else 0.0
        reaches = {
            name: _number(getattr(scene, section).neighbours)
            for name, section in reaching(scene).items()
        }
        size = any(getattr(scene, section).finite_size for section in sized(scene).values())
        return cls(places, reaches.get("slip", 0.0), reaches.get("strain", 0.0), size)

    def holds(self, other: Fluid) -> bool:
        """Whether all that ``other`` simulates is part of this."""
        return all(a >= b for a, b in zip(self, other, strict=True))

    def applied(self, scene: Scene) -> Scene:
        """The scene with this in place of its own."""
        changes: dict[str, Any] = {
            "friction.kind": "pairwise" if self.friction else "one-body",
            "friction.neighbours": _neighbours(self.friction or math.inf),
        }
        for name, section in reaching(scene).items():
            changes[f"{section}.neighbours"] = _neighbours(getattr(self, name))
        for section in sized(scene).values():
            changes[f"{section}.finite_size"] = self.finite_size
        return load_scene(scene, **changes)


def _number(neighbours: int | str) -> float:
    return math.inf if neighbours == "all" else float(neighbours)


def _neighbours(number: float) -> int | str:
    return "all" if math.isinf(number) else int(number)


def evaluation_cost(scene: Scene, fluid: Fluid | None = None) -> float:
    """Nominal seconds of one right-hand side of a scene, and of all that comes with it.

    ``fluid`` stands for its own if it is given.
    """
    fluid = fluid or Fluid.of(scene)
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


def _flows(scene: Scene, fluid: Fluid) -> list[tuple[float, float]]:
    """Of the slip and of the disturbance of a flow: places a side, and work in pairs of a mode."""
    sizes = sized(scene) if fluid.finite_size else {}
    flows = []
    if fluid.slip:
        work = 1.0 + MODE * (len(active_modes(scene)) - 1)
        work += FINITE_SIZE * ("finite size" in sizes)
        flows.append((_places(scene, fluid.slip), work))
    if fluid.strain:
        flows.append((_places(scene, fluid.strain), 1.0 + ("finite size of strain" in sizes)))
    return flows


def _places(scene: Scene, reach: float) -> float:
    """Neighbours a side, on average over a chain whose ends have fewer."""
    count = scene.chain.particles
    if scene.chain.ends == "periodic":
        return IMAGES * count if math.isinf(reach) else reach
    places = min(reach, count - 1)
    return places * (2 * count - places - 1) / (2 * count)
