"""(v, ω)_i = Σ_j (u, w)(r_i − r_j, e_j): the flow of one slip mode at the nearest neighbours.

Every mode of :mod:`nrchain.slip_modes` is one effect: the leading order of its flow at the nearest
neighbours. Flows of farther spheres are the effect ``reach``, and the part of relative order (a/r)²
is the effect ``finite size``. A model sums all three, of all modes, in one pass over the pairs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from nrchain.effects.base import Cost, Effect
from nrchain.effects.registry import register_family
from nrchain.effects.shared.slip_flow import (
    FlowEffect,
    make_flow,
    mode_scale,
    pairs_within,
    reach_text,
)
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.slip_mode import SlipMode
from nrchain.scene.fluid_sections import SlipSpec
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.wording import span


class SlipEffect(FlowEffect):
    """(v, ω)_i of one mode: its leading-order flow at nearest neighbours."""

    mode: ClassVar[SlipMode]

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self._set(lambda: make_flow(scene, 1, False).only(self.mode.label), None)

    def __reduce__(self) -> tuple[Any, ...]:
        # the class is built here and has no importable name
        return _effect_in, (self.mode, self.scene)

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        slip = scene.slip.modes.get(cls.mode.label)
        return slip is not None and bool(np.any(slip.strength))

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        return load_scene(scene, **{cls.key: None})

    @classmethod
    def detail(cls, scene: Scene) -> str:
        strength = np.asarray(scene.slip.modes[cls.mode.label].strength)
        text = span(f"{strength.min():g}", f"{strength.max():g}")
        return f"strength {text}, {reach_text(scene.slip.neighbours)}"

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        return Cost(pairs_within(scene, 1), "pairs")

    @classmethod
    def scale(cls, scene: Scene) -> float:
        return mode_scale(scene, cls.mode.label, scene.chain.spacing)


def effect_of(mode: SlipMode) -> type[SlipEffect]:
    """The effect of a mode; the same class for the same mode."""
    if mode.label not in _MADE or _MADE[mode.label].mode != mode:
        _MADE[mode.label] = _make_effect(mode)
    return _MADE[mode.label]


def _effect_in(mode: SlipMode, scene: Scene) -> SlipEffect:
    return effect_of(mode)(scene)


_MADE: dict[str, type[SlipEffect]] = {}


def _make_effect(mode: SlipMode) -> type[SlipEffect]:
    symmetry = f"{'polar' if mode.polar else 'apolar'}, {'chiral' if mode.chiral else 'achiral'}"
    row = " + ".join(
        f"({_polynomial(p)}) (a/r)^{power} {_BASIS[basis]}"
        for (basis, power), p in sorted(mode.flow().items(), key=lambda item: item[0][1])
    )
    attributes = {
        "mode": mode,
        "name": f"slip {mode.label}",
        "key": SlipSpec.key(mode.label),
        "summary": f"flow of the {mode.name} at nearest neighbours, {symmetry}",
        "equation": f"u/V = {row}, w = ½ curl u",
        "example": {SlipSpec.key(mode.label): 100.0},
        "__doc__": f"The flow of the {mode.name}.",
        "__module__": __name__,
    }
    return type(f"Slip{mode.label}", (SlipEffect,), attributes)


_BASIS = {"n": "n", "e": "e", "x": "e × n"}


def _polynomial(p: Sequence[object]) -> str:
    powers = ("", " c", " c²", " c³", " c⁴", " c⁵", " c⁶")
    return " + ".join(f"{q}{powers[m]}" for m, q in enumerate(p) if q).replace("+ -", "− ")


def _mode_effects() -> tuple[type[Effect], ...]:
    return tuple(effect_of(mode) for mode in slip_modes.modes())


register_family("slip", _mode_effects)
