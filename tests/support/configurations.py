"""One list of small chains: effects, modes, ends, reach, friction, measures of bend, and units.

The list drives the tests of symmetry, gradient, Jacobian, rigid motion and agreement. A test takes
the part that it applies to::

    @each(lambda c: c.ends == "free")
    def test_something(configuration):
        model = Model(configuration.scene())
        twists = model.twists(*configuration.poses())
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
import pytest

import nrchain
from nrchain.effects.base import Effect
from nrchain.effects.registry import effects, find_effect
from support.poses import random_chain
from support.spring import Spring

ENDS = ("free", "clamped", "periodic")
MODULI = {"stretch": 3.0, "shear": 5.0, "twist": 7.0, "bend": 11.0}
SLACK = {f"elasticity.{name}": 0.0 for name in MODULI}
"""Changes of a scene that take its elasticity out."""

MODES: dict[str, tuple[float, tuple[float, float, float]]] = {
    "2s": (3.0, (1.0, 0.0, 0.0)),
    "3a": (2.0, (0.0, 1.0, 2.0)),
    "3t": (-4.0, (1.0, 0.0, 0.0)),
    "4a": (5.0, (0.0, 1.0, 1.0)),
}
"""Strength and body axis: three axes among four modes."""

VISCOSITIES = {0.3: 1.7, 1.0: 1.0, 1.2: 1.7, 1.4: 0.7, 2.7: 0.7}
"""η for each radius a; the spacing d is given in radii."""

PAIRWISE = {"kind": "pairwise"}


@dataclass(frozen=True)
class Configuration:
    """A scene, and poses of its chain at which tests evaluate it.

    ``slip`` names the modes; strengths differ from sphere to sphere. ``spacing`` is d/a and
    ``apart`` the mean distance of neighbours in the poses, over a. ``effect`` is the effect that a
    test looks at by itself, if any.
    """

    name: str
    ends: str = "free"
    count: int = 6
    slip: tuple[str, ...] = ()
    reach: int | str = 1
    finite_size: bool = False
    friction: Mapping[str, Any] = field(default_factory=lambda: {"kind": "one-body"})
    measure: str = "paper"
    radius: float = 1.0
    spacing: float = 4.0
    apart: float = 4.0
    seed: int = 0
    changes: Mapping[str, Any] = field(default_factory=dict)
    effect: type[Effect] | None = None

    def __str__(self) -> str:
        return self.name

    def scene(self, **changes: Any) -> nrchain.Scene:
        table: dict[str, Any] = {
            "chain": {
                "particles": self.count,
                "radius": self.radius,
                "viscosity": VISCOSITIES[self.radius],
                "spacing": self.spacing * self.radius,
                "ends": self.ends,
            },
            "elasticity": {**MODULI, "measure": self.measure},
            "slip": {
                "neighbours": self.reach,
                "finite_size": self.finite_size,
                **{label: self._mode(label) for label in self.slip},
            },
            "friction": dict(self.friction),
            "run.end": 1.0,
        }
        return nrchain.load_scene(nrchain.load_scene(table, **self.changes), **changes)

    def _mode(self, label: str) -> dict[str, Any]:
        strength, axis = MODES[label]
        shares = np.linspace(0.5, 2.0, self.count)
        return {"strength": (strength * shares).tolist(), "axis": list(axis)}

    def poses(self, seed: int | None = None, apart: float | None = None) -> tuple[Any, Any]:
        """Random positions (N, 3) and frames (N, 3, 3); other ones for another seed."""
        where = self.apart if apart is None else apart
        chosen = self.seed if seed is None else seed
        positions, frames = random_chain(self.count, spacing=where, seed=chosen)
        return self.radius * positions, frames


def _elastic() -> list[Configuration]:
    """Short chains have no inner link, long ones have the stencil of four spheres."""
    cases = [("paper", n) for n in (2, 3, 4, 5, 9)] + [("isotropic", n) for n in (2, 5)]
    return [
        Configuration(
            f"elastic, {measure}, N = {n}, {ends}",
            ends=ends,
            count=n,
            measure=measure,
            radius=1.2,
            spacing=2.5,
            apart=2.5,
            seed=n,
        )
        for (measure, n), ends in product(cases, ("free", "periodic"))
    ]


def _slip() -> list[Configuration]:
    all_modes = tuple(MODES)
    found = [
        Configuration(
            f"{label}, reach {reach}{', finite size' if finite else ''}",
            count=12,
            slip=(label,),
            reach=reach,
            finite_size=finite,
            radius=1.4,
        )
        for label, reach, finite in product(MODES, (1, 3, "all"), (False, True))
    ]
    found += [
        Configuration(
            f"all modes, reach {reach}{', finite size' if finite else ''}, a = {radius}",
            count=7,
            slip=all_modes,
            reach=reach,
            finite_size=finite,
            radius=radius,
            apart=2.9,
        )
        for radius, reach, finite in product((0.3, 1.0, 1.2), (1, 2, "all"), (False, True))
    ]
    found += [
        Configuration(f"{label}, {ends}", ends=ends, slip=(label,))
        for label, ends in product(MODES, ENDS)
    ]
    # a periodic chain of six spheres meets images of itself at reach 8, by blocks, and 12, by sums
    found += [
        Configuration(f"all modes, {ends}, reach {reach}", ends=ends, slip=all_modes, reach=reach)
        for ends, reach in product(ENDS, (1, 2, 3, 8, 12))
    ]
    periodic = {"ends": "periodic", "slip": all_modes, "reach": "all"}
    found.append(Configuration("all modes, periodic, all images", **periodic))
    return found


def _friction() -> list[Configuration]:
    all_modes, two = tuple(MODES), {**PAIRWISE, "neighbours": 2}
    found = [
        Configuration(
            f"all modes, {ends}, reach {reach}, friction of 2 neighbours",
            ends=ends,
            slip=all_modes,
            reach=reach,
            friction=two,
        )
        for ends, reach in product(ENDS, (1, 12))
    ]
    found += [
        Configuration(
            f"all modes, {ends}, slip and friction of all pairs",
            ends=ends,
            slip=all_modes,
            reach="all",
            friction=PAIRWISE,
        )
        for ends in ENDS
    ]
    found.append(Configuration("no slip, friction of all pairs", friction=PAIRWISE))
    found += [
        Configuration(
            f"friction of neighbours: {reach}, a = {radius}",
            count=12,
            friction={**PAIRWISE, "neighbours": reach},
            radius=radius,
        )
        for radius, reach in product((0.3, 1.0, 2.7), (1, 3, "all"))
    ]
    return found


def _effects() -> list[Configuration]:
    """Every registered effect and one of a user's own, each by itself beside the elasticity."""
    # a flow along x would change the period of a periodic chain
    across = {"flow.gradient": [[0.0, 0.3, -0.1], [0.0, 0.2, 0.4], [0.0, -0.3, -0.2]]}
    near = across | {"flow.neighbours": 2, "flow.finite_size": True}
    strained = find_effect("finite size of strain")
    found = []
    for ends in ("free", "periodic"):
        name = f"disturbance by 2 neighbours, {ends}"
        found.append(Configuration(name, ends=ends, apart=2.9, changes=near, effect=strained))
    for effect, ends in product((*effects(), Spring), ("free", "periodic")):
        changes = dict(effect.example)
        if ends == "periodic" and "flow.gradient" in changes:
            changes |= across
        name = f"effect {effect.name}, {ends}"
        found.append(Configuration(name, ends=ends, apart=2.9, changes=changes, effect=effect))
    return found


CONFIGURATIONS = [*_elastic(), *_slip(), *_friction(), *_effects()]


def each(keep: Callable[[Configuration], bool]) -> pytest.MarkDecorator:
    """Run a test with the fixture ``configuration`` on every configuration that is kept."""
    kept = [c for c in CONFIGURATIONS if keep(c)]
    assert kept
    return pytest.mark.parametrize("configuration", kept, ids=str, indirect=True)
