"""u → (1 + a²∇²/6)(1 + a²∇²/(4l + 2)) u: finite size of spheres in their slip flows.

The first factor is Faxén's, for the sphere that feels the flow; the second is that of the acting
sphere (paper, Table active_force_torque). Only the velocity of 2s changes, by a term of order
(a/r)²: the flows of the other modes and the angular velocities of all modes are harmonic.
"""

from __future__ import annotations

from nrchain.effects.base import Cost
from nrchain.effects.registry import register_effect
from nrchain.effects.shared.slip_flow import (
    FlowEffect,
    active_modes,
    largest_flow,
    make_flow,
    pairs_within,
)
from nrchain.hydrodynamics import slip_modes
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


@register_effect
class FiniteSize(FlowEffect):
    """The finite-size correction of the slip flows of the nearest neighbours.

    The correction for farther spheres is part of the effect ``reach``.
    """

    name = "finite size"
    key = "slip.finite_size"
    summary = "(a/r)² in the velocity of 2s"
    equation = "(1 + a²∇²/6)(1 + a²∇²/(4l + 2)) u − u"
    example = {"slip.2s": 100.0, "slip.finite_size": True}  # noqa: RUF012

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self._set(lambda: make_flow(scene, 1, True), lambda: make_flow(scene, 1, False))

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        modes = map(slip_modes.find, active_modes(scene))
        return scene.slip.finite_size and any(mode.flow(True) != mode.flow() for mode in modes)

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        return load_scene(scene, **{cls.key: False})

    @classmethod
    def detail(cls, scene: Scene) -> str:
        return cls.summary

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        return Cost(pairs_within(scene, 1), "pairs")

    @classmethod
    def scale(cls, scene: Scene) -> float:
        d, a, total = scene.chain.spacing, scene.chain.radius, 0.0
        for label in active_modes(scene):
            mode = slip_modes.find(label)
            leading, whole = mode.flow(), mode.flow(True)
            change = {row: tuple(p) for row, p in whole.items() if p != leading.get(row, ())}
            strengths = scene.slip.modes[label].strength
            largest = max(map(abs, strengths if isinstance(strengths, tuple) else (strengths,)))
            total += largest * largest_flow(change, d, a)
        return total
