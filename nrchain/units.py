"""x_SI = x L^α T^β F^γ: reduced units of a scene to and from SI, for a colloid that you name.

The equations of motion, γ_T v = F + γ_T Σu with γ_T = 6πηa, hold in any units of length L, time T
and force F. Three values of a scene that are known in SI fix all three. Every other number of the
scene follows by its dimension. SI values are quantities of ``pint`` or texts such as ``"2 um"``,
and come in with the extra ``units``; nothing else in nrchain knows ``pint``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.optional import optional
from nrchain.inputs.rules import is_number
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene

LARGEST = 1e60
"""Largest unit, in SI: products of powers of units stay in the range of floating point."""

UNITS = {
    "chain.spacing": "L",
    "chain.radius": "L",
    "chain.viscosity": "F T/L²",
    "elasticity.stretch": "F/L",
    "elasticity.shear": "F/L",
    "elasticity.twist": "F L",
    "elasticity.bend": "F L",
    "steric.strength": "F L",
    "steric.range": "L",
    "field.force": "F",
    "field.torque": "F L",
    "field.body_force": "F",
    "field.body_torque": "F L",
    "flow.gradient": "1/T",
    "start.amplitude": "L",
    "start.positions": "L",
    "run.end": "T",
}
"""The unit of each key with one; strengths ``slip.MODE`` are speeds, ``"L/T"``."""


@dataclass(frozen=True, slots=True)
class Units:
    """L, T and F: what a length, a time and a force of 1 in a scene are in SI.

    Parameters
    ----------
    length, time, force
        In m, s and N.

    >>> from nrchain import load_scene, units
    >>> scene = load_scene("buckling")
    >>> colloid = {"chain.radius": "1 um", "chain.viscosity": "1 mPa s", "slip.2s": "10 um/s"}
    >>> found = units.of(scene, **colloid)
    >>> f"{found.to_si(1.0, 'T').to('s'):.1f}"
    '10.0 second'
    >>> round(found.to_reduced("1 min"), 6)
    6.0
    """

    length: float
    time: float
    force: float

    def __repr__(self) -> str:
        return f"<Units L = {self.length:.6g} m, T = {self.time:.6g} s, F = {self.force:.6g} N>"

    def to_si(self, value: Any, unit: str) -> Any:
        """The SI quantity of a number or an array in reduced units.

        Parameters
        ----------
        value
            A number, or an array of any shape, such as the positions of a trajectory.
        unit
            ``"L/T"`` and the like, or the key of a scene that has this unit.

        Raises :class:`~nrchain.errors.SceneError` for a unit that is not understood.

        >>> colloid = Units(length=1e-6, time=1.0, force=1e-12)
        >>> f"{colloid.to_si(100.0, 'slip.2s').to('um/s'):.1f}"
        '100.0 micrometer / second'
        """
        powers = _powers(unit)
        factor = self.length ** powers[0] * self.time ** powers[1] * self.force ** powers[2]
        registry = _registry()
        names = zip(("meter", "second", "newton"), powers, strict=True)
        spelled = registry.UnitsContainer({name: power for name, power in names if power})
        return registry.Quantity(np.asarray(value)[()] * factor, spelled)

    def to_reduced(self, quantity: Any) -> Any:
        """The reduced number of an SI quantity of any dimension: an array for an array.

        Raises :class:`~nrchain.errors.SceneError` for text that is no quantity, and for
        dimensions other than length, time and mass.

        >>> round(Units(length=1e-6, time=1.0, force=1e-12).to_reduced("2 pN um"), 12)
        2.0
        """
        found = _quantity(quantity)
        powers = _powers_of(found, quantity)
        factor = self.length ** powers[0] * self.time ** powers[1] * self.force ** powers[2]
        return found.to_base_units().magnitude / factor

    def scene(self, scene: Any, **changes: Any) -> Scene:
        """A scene with changes, of which those in SI are texts or quantities with their unit.

        Raises :class:`~nrchain.errors.SceneError` for a quantity whose dimension is not that of
        its key.

        >>> colloid = Units(length=1e-6, time=1.0, force=1e-12)
        >>> colloid.scene("buckling", **{"run.end": "5 min", "chain.particles": 10}).run.end
        300.0
        """
        reduced = dict(changes)
        for key, value in changes.items():
            if _unit_of(key) and (isinstance(value, str) or hasattr(value, "magnitude")):
                _check_dimension(key, value)
                reduced[key] = float(self.to_reduced(value))
        return load_scene(scene, **reduced)

    def describe(self, scene: Scene) -> dict[str, Any]:
        """The values of a scene in SI, by key, with the moduli that its rules give.

        >>> from nrchain import load_scene
        >>> shown = Units(length=1e-6, time=1.0, force=1e-12).describe(load_scene("buckling"))
        >>> f"{shown['run.end'].to('min'):.1f}", f"{shown['slip.2s'].to('um/s'):.0f}"
        ('16.7 minute', '100 micrometer / second')
        """
        moduli = scene.moduli
        values: dict[str, Any] = {
            "chain.radius": scene.chain.radius,
            "chain.spacing": scene.chain.spacing,
            "chain.viscosity": scene.chain.viscosity,
            "elasticity.stretch": moduli.stretch,
            "elasticity.shear": moduli.shear,
            "elasticity.twist": moduli.twist,
            "elasticity.bend": moduli.bend,
            "start.amplitude": scene.start.amplitude,
            "run.end": scene.run.end,
        }
        for label, slip in scene.slip.modes.items():
            values[f"slip.{label}"] = slip.strength
        return {key: self.to_si(value, key) for key, value in values.items()}


def of(scene: Scene, **known: Any) -> Units:
    """The units in which three values of a scene are the given ones in SI.

    Parameters
    ----------
    scene
        The scene, whose values are not zero.
    known
        Three keys with their SI values, such as radius, viscosity and the strength of a mode, or a
        force or a time in place of the strength. Together they must fix length, time and force.

    Raises :class:`~nrchain.errors.SceneError` for keys without a unit, values of another dimension
    or of another sign, keys that leave one of the three units open, and units out of range.

    >>> from nrchain import load_scene
    >>> scene = load_scene("passive", field={"force": [0.0, 0.0, -0.5]})
    >>> of(scene, **{"chain.radius": "2 um", "chain.viscosity": "1 mPa s", "run.end": "1 h"})
    <Units L = 2e-06 m, T = 9 s, F = 4.44444e-16 N>
    """
    if len(known) != 3:
        raise SceneError("known", sorted(known), "must be three keys of the scene with SI values")
    rows, logarithms = [], []
    for key, given in known.items():
        unit = _unit_of(key)
        if not unit:
            raise SceneError("known", key, f"must have a unit; keys with one are {_known_keys()}")
        _check_dimension(key, given)
        ratio = float(_quantity(given).to_base_units().magnitude) / _number(scene, key)
        if not ratio > 0.0:
            raise SceneError(key, given, "must not be zero, and have the sign of the scene's value")
        rows.append(_powers(unit))
        logarithms.append(np.log(ratio))
    matrix = np.array(rows, float)
    if abs(np.linalg.det(matrix)) < 0.5:
        raise SceneError("known", sorted(known), "must fix length, time and force together")
    exponents = np.linalg.solve(matrix, logarithms)
    if not np.abs(exponents).max() < np.log(LARGEST):
        allowed = f"must give units of length, time and force between 1/{LARGEST:g} and {LARGEST:g}"
        raise SceneError("known", known, allowed)
    length, time, force = (float(unit) for unit in np.exp(exponents))
    return Units(length, time, force)


def _number(scene: Scene, key: str) -> float:
    """One number of a scene by its key; a modulus is what the rules of the scene give."""
    section, name = key.split(".", 1)
    if section == "elasticity":
        value = getattr(scene.moduli, name)
    elif section == "slip":
        value = scene.slip.modes[name].strength if name in scene.slip.modes else 0.0
    else:
        value = getattr(getattr(scene, section), name)
    if not is_number(value) or value == 0.0:
        raise SceneError(key, value, "must be one number of the scene other than zero")
    return float(value)


def _unit_of(key: str) -> str:
    """The unit of a key; "" for one without."""
    if key.startswith("slip.") and key[5:6].isdigit():
        return "L/T"
    return UNITS.get(key, "")


def _powers(unit: str) -> tuple[int, int, int]:
    """The powers of L, T and F in a unit such as ``"F T/L²"``, or in that of a key."""
    text = _unit_of(unit) or unit
    over, _, below = text.partition("/")
    powers = {"L": 0, "T": 0, "F": 0}
    for part, sign in ((over, 1), (below, -1)):
        rest = part.strip()
        for letter, power in re.findall(r"([LTF])(²|³)?", rest):
            powers[letter] += sign * {"²": 2, "³": 3}.get(power, 1)
        if re.sub(r"[LTF][²³]?|\s|^1$", "", rest):
            allowed = f"must be made of L, T and F, as L/T is, or one of {_known_keys()}"
            raise SceneError("unit", unit, allowed)
    return powers["L"], powers["T"], powers["F"]


def _known_keys() -> str:
    return ", ".join([*UNITS, "slip.MODE"])


def _check_dimension(key: str, given: Any) -> None:
    found = _quantity(given)
    if _powers_of(found, given) != _powers(key):
        raise SceneError(key, given, f"must have the unit {_unit_of(key)}")


def _powers_of(found: Any, given: Any) -> tuple[float, float, float]:
    """The powers of L, T and F in a quantity: a mass is F T²/L."""
    dimensions = {str(name): float(power) for name, power in found.dimensionality.items()}
    mass = dimensions.pop("[mass]", 0.0)
    length, time = (dimensions.pop(name, 0.0) for name in ("[length]", "[time]"))
    if dimensions:
        raise SceneError("quantity", given, "must be made of lengths, times and masses")
    return length - mass, time + 2.0 * mass, mass


def _quantity(given: Any) -> Any:
    if hasattr(given, "magnitude") and hasattr(given, "dimensionality"):
        return given
    registry = _registry()
    try:
        return registry.Quantity(given)
    except Exception as error:
        raise SceneError("quantity", given, 'must be a value with its unit, as "2 um"') from error


def _registry() -> Any:
    """The registry of units that the process shares."""
    return optional("pint", "units", "a value in SI units").get_application_registry()
