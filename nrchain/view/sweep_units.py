"""Names of what a sweep varies and observes, with units where the scene has those of the paper."""

from __future__ import annotations

from nrchain.scene.scene import Scene
from nrchain.units import UNITS
from nrchain.view import units
from nrchain.view.drawing import letters

OBSERVED: dict[str, units.Kind] = {
    **dict.fromkeys(("end.time", "measure.attractor.since", "measure.attractor.period"), "time"),
    **dict.fromkeys(("end.size", "end.gyration", "end.distance", "measure.wave"), "length"),
    **dict.fromkeys(("measure.rate", "measure.rate.error", "measure.rate.frequency"), "rate"),
    **dict.fromkeys(("measure.fit_shape", "measure.fit_shape.frequency"), "rate"),
    **dict.fromkeys(("measure.lyapunov", "measure.lyapunov.error"), "rate"),
    **dict.fromkeys(("measure.spin", "measure.spin.error"), "rate"),
    **dict.fromkeys((f"measure.translation{end}" for end in ("", ".x", ".y", ".z")), "speed"),
}
"""The kind of unit of each observable that has one."""

VARIED: dict[str, units.Kind] = {"L": "length", "T": "time", "L/T": "speed"}
"""The kind of a unit that a key has."""

SETS_UNITS = frozenset(("chain.radius", "chain.spacing", "chain.viscosity", "elasticity.bend"))
"""Keys of which the units depend: a sweep that varies one has no unit for all its points."""


def label(name: str, scene: Scene, keys: tuple[str, ...]) -> str:
    """A key or an observable of a sweep over ``keys``, with its unit if the paper has it.

    >>> label("end.time", nrchain.load_scene("buckling"), ("slip.2s",))
    'end.time  [$\\\\gamma_T d^2/\\\\mu$]'
    """
    if name == "measure.turned_angle":
        return f"{name}  [rad]"
    is_mode = name.startswith("slip.") and name[5:6].isdigit()
    kind = OBSERVED.get(name) or VARIED.get("L/T" if is_mode else UNITS.get(name, ""))
    if kind is None or SETS_UNITS & set(keys):
        return letters(name)
    return units.words(letters(name), scene, kind)
