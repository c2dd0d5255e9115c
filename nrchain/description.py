"""What a scene simulates and what it leaves out, in words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain.arguments import a_scene
from nrchain.regime import warnings
from nrchain.scene import Moduli, Scene


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
    for name, modulus in zip(Moduli._fields, a_scene(scene).moduli, strict=True):
        (simulated if modulus else left_out).append(
            (name, f"modulus {modulus:.4g}" if modulus else "modulus 0")
        )
    reach = scene.slip.neighbours
    where = _reach_text(reach)
    for label, mode in scene.slip.modes.items():
        strength = np.unique(mode.strength)
        text = f"{strength[0]:g}" if len(strength) == 1 else f"{strength[0]:g} to {strength[-1]:g}"
        if np.any(strength):
            simulated.append((f"slip {label}", f"strength {text}, {where}"))
        else:
            left_out.append((f"slip {label}", "strength 0"))
    if scene.slip.modes:
        (simulated if scene.slip.finite_size else left_out).append(
            ("finite size", "(a/r)² in the velocity of 2s")
        )
        if reach != "all":
            left_out.append(("long range", f"slip flows beyond {where}"))
    friction = scene.friction
    if friction.kind == "one-body":
        simulated.append(("friction", "one-body"))
        left_out.append(("friction between spheres", "Rotne–Prager–Yamakawa mobilities"))
    else:
        simulated.append(("friction", f"pairwise, {_reach_text(friction.neighbours)}"))
        left_out.append(("near field", "lubrication and reflections, of order (a/r)⁴"))
    steric = scene.steric
    if steric.acts:
        text = f"{steric.kind}, strength {steric.strength:g}, below {scene.steric_range:.4g}"
        simulated.append(("steric repulsion", text))
    else:
        left_out.append(("steric repulsion", "a run stops where spheres touch"))
    left_out.append(("other effects", "Brownian motion, external fields"))
    return Description(simulated, left_out, warnings(scene))


def _reach_text(neighbours: int | str) -> str:
    if neighbours == "all":
        return "all pairs"
    return f"{neighbours} neighbour{'s' * (neighbours != 1)} a side"
