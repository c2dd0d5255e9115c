"""(v, ω)_i = Σ_j (u, w)(r_i − r_j, e_j): the flow that one mode of slip sets up around a sphere.

There is one effect a mode, made from its row in :mod:`nrchain.slip_modes`: the leading order of
its flow at the nearest neighbours. What lies beyond them is the effect ``reach``, and the part of
relative order (a/r)² the effect ``finite size``. A model sums all three, of all modes, in one pass
over the pairs, by code that holds the modes named and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from nrchain.effects.base import Cost, Effect
from nrchain.effects.registry import register_family
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.flow_tables import FlowTable
from nrchain.hydrodynamics.images import EXACT, POINTS
from nrchain.hydrodynamics.pairs import SlipFlow
from nrchain.hydrodynamics.slip_mode import SlipMode
from nrchain.scene.scene import Scene, load_scene
from nrchain.scene.sections import SlipSpec
from nrchain.wording import span


class PyStokesFlow(SlipFlow):
    """The same twists through PyStokes; their derivatives are those of the closed forms."""

    def __init__(self, *arguments: Any, neighbours: int | str, viscosity: float, **options: Any):
        super().__init__(*arguments, **options)
        self._shown, self._viscosity = neighbours, viscosity

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        from nrchain.hydrodynamics import pystokes_backend

        if not self:
            return
        law = self.law
        velocities, spins = pystokes_backend.twists(
            positions,
            [np.einsum("b,nbk->nk", np.array(law.axes[g]), frames) for g in law.axis_of],
            list(self.strengths),
            neighbours=self._shown,
            radius=self.radius,
            viscosity=self._viscosity,
            finite_size=law.finite_size,
            labels=law.labels,
        )
        twists[:, :3] += velocities
        twists[:, 3:] += spins


def make_flow(
    scene: Scene, neighbours: int | str | None = None, finite_size: bool | None = None
) -> SlipFlow:
    """The flow of all modes of a scene, or that with another reach or order."""
    slip, chain = scene.slip, scene.chain
    shown = slip.neighbours if neighbours is None else neighbours
    modes = (
        list(slip.modes),
        [np.broadcast_to(mode.strength, chain.particles) for mode in slip.modes.values()],
        [mode.axis for mode in slip.modes.values()],
    )
    options: dict[str, Any] = {
        "count": chain.particles,
        "reach": shown if isinstance(shown, int) else None,
        "radius": chain.radius,
        "period": scene.length if chain.ends == "periodic" else 0.0,
        "finite_size": slip.finite_size if finite_size is None else finite_size,
    }
    if slip.backend == "pystokes":
        options |= {"neighbours": shown, "viscosity": chain.viscosity}
        return PyStokesFlow(*modes, **options)
    return SlipFlow(*modes, **options)


def active_modes(scene: Scene) -> tuple[str, ...]:
    """The labels of the modes whose strength is not zero everywhere."""
    return tuple(m for m, slip in scene.slip.modes.items() if np.any(slip.strength))


def pairs_within(scene: Scene, neighbours: int | str) -> int:
    """Pairs, each counted from both sides, of spheres up to so many places apart, or of all."""
    count, periodic = scene.chain.particles, scene.chain.ends == "periodic"
    if periodic and neighbours == "all":
        return count * (count * (1 + 2 * (EXACT + POINTS)) - 1)
    places = count - 1 if isinstance(neighbours, str) else neighbours
    if periodic:
        return 2 * count * places
    places = min(places, count - 1)
    return places * (2 * count - places - 1)


def largest_flow(table: FlowTable, distance: float, radius: float) -> float:
    """max |u|/V over directions at a distance, each row of a table by its largest cosine."""
    cosines = np.linspace(-1.0, 1.0, 41)
    total = 0.0
    for (_, power), p in table.items():
        polynomial = np.polynomial.polynomial.polyval(cosines, [float(q) for q in p])
        total += float(np.abs(polynomial).max()) * (radius / distance) ** power
    return total


def mode_scale(scene: Scene, label: str, distance: float) -> float:
    """max (|u|, a|w|) of a mode at a distance, to leading order."""
    mode, slip = slip_modes.find(label), scene.slip.modes[label]
    tables = mode.flow(), mode.spin()
    radius = scene.chain.radius
    strength = float(np.abs(slip.strength).max())
    return strength * max(largest_flow(table, distance, radius) for table in tables)


class FlowEffect(Effect):
    """The difference of two slip flows, ``self._flows``: (sign, flow) each, with its derivative."""

    gives = "twist"
    placed = False
    carries = True
    fused = True

    def _set(self, plus: Callable[[], SlipFlow], minus: Callable[[], SlipFlow] | None) -> None:
        """The two flows, each made twice: to evaluate, and to take the derivative of."""
        makers = [(1.0, plus)] if minus is None else [(1.0, plus), (-1.0, minus)]
        self._flows = [(sign, make(), make()) for sign, make in makers]
        reach = max(flow.reach for _, flow, _ in self._flows)
        self.places = reach if all(flow.near for _, flow, _ in self._flows) else None

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        for sign, flow, _ in self._flows:
            change = np.zeros_like(twists)
            flow.add_twists(positions, frames, change)
            twists += sign * change

    def linearise(self, positions: np.ndarray, frames: np.ndarray) -> None:
        self._there = positions.copy(), frames.copy()
        for _, _, flow in self._flows:
            flow.add_jacobian(*self._there, np.zeros((len(positions), 3, 6, 6)))

    def add_blocks(self, blocks: np.ndarray) -> None:
        for sign, _, flow in self._flows:
            change = np.zeros_like(blocks)
            flow.add_jacobian(*self._there, change)
            blocks += sign * change

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        for sign, _, flow in self._flows:
            change = np.zeros_like(out)
            flow.add_product(poses, change)
            out += sign * change


class SlipEffect(FlowEffect):
    """One mode: its leading-order flow at nearest neighbours, by the kernel of all of the scene."""

    mode: ClassVar[SlipMode]

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self._set(lambda: make_flow(scene, 1, False).only(self.mode.label), None)

    def __reduce__(self) -> tuple[Any, ...]:
        # the class is made here and not found by its name
        return _effect_in, (self.mode, self.scene)

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        return cls.mode.label in active_modes(scene)

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


def reach_text(neighbours: int | str) -> str:
    """How far along the chain, in words."""
    if neighbours == "all":
        return "all pairs"
    return f"{neighbours} neighbour{'s' * (neighbours != 1)} a side"


def effect_of(mode: SlipMode) -> type[SlipEffect]:
    """The effect of a mode, always the same class."""
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


def _polynomial(p: tuple) -> str:
    powers = ("", " c", " c²", " c³", " c⁴", " c⁵", " c⁶")
    return " + ".join(f"{q}{powers[m]}" for m, q in enumerate(p) if q).replace("+ -", "− ")


def _mode_effects() -> tuple[type[Effect], ...]:
    return tuple(effect_of(mode) for mode in slip_modes.modes())


register_family("slip", _mode_effects)
