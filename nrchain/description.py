"""What a scene simulates and what it leaves out, in words."""

from __future__ import annotations

from dataclasses import dataclass

from nrchain.effects.finite_size import FiniteSize
from nrchain.effects.registry import effects
from nrchain.effects.slip import active_modes, reach_text
from nrchain.regime import warnings
from nrchain.scene import Scene


@dataclass(frozen=True)
class Description:
    """What a scene simulates and what it leaves out: (effect, one line) each, and warnings."""

    simulated: list[tuple[str, str]]
    left_out: list[tuple[str, str]]
    warnings: list[str]


def describe(scene: Scene) -> Description:
    """The effects a scene names, those it does without, and whether it is in the beam limit."""
    simulated: list[tuple[str, str]] = []
    left_out: list[tuple[str, str]] = []
    for effect in effects():
        if effect.acts(scene):
            simulated.append((effect.name, effect.detail(scene)))
        elif not effect.key.startswith("slip."):
            left_out.append((effect.name, effect.summary))
    simulated.append(("drag", "of each sphere by itself"))
    left_out += _left_out_of_slip(scene)
    if scene.friction.kind == "pairwise":
        left_out.append(("near field", "lubrication and reflections, of order (a/r)⁴"))
    left_out.append(("other effects", "Brownian motion"))
    return Description(simulated, left_out, warnings(scene))


def _left_out_of_slip(scene: Scene) -> list[tuple[str, str]]:
    """What a scene with slip does without; one that names no mode does without all."""
    if not scene.slip.modes:
        return [("slip", "no mode is named")]
    modes = active_modes(scene)
    rows = [(f"slip {m}", "strength 0") for m in scene.slip.modes if m not in modes]
    if not FiniteSize.acts(scene):
        rows.append((FiniteSize.name, FiniteSize.summary))
    if scene.slip.neighbours != "all":
        rows.append(("long range", f"slip flows beyond {reach_text(scene.slip.neighbours)}"))
    return rows
