"""(v, ω)_i = Σ_j (u, w)(r_i − r_j, e_j): the slip flows of a scene, their cost and size."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nrchain.effects.base import Effect
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.flow_tables import FlowTable
from nrchain.hydrodynamics.images import EXACT, POINTS
from nrchain.hydrodynamics.pairs import SlipFlow
from nrchain.hydrodynamics.pystokes_flow import PyStokesFlow
from nrchain.scene.scene import Scene


def make_flow(
    scene: Scene, neighbours: int | str | None = None, finite_size: bool | None = None
) -> SlipFlow:
    """The slip flow of a scene, with its reach and finite size or others."""
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
        "period": scene.period,
        "finite_size": slip.finite_size if finite_size is None else finite_size,
    }
    if slip.backend == "pystokes":
        options |= {"neighbours": shown, "viscosity": chain.viscosity}
        return PyStokesFlow(*modes, **options)
    return SlipFlow(*modes, **options, accuracy=scene.pair_accuracy)


def active_modes(scene: Scene) -> tuple[str, ...]:
    """The labels of the modes whose strength is not zero everywhere."""
    return tuple(m for m, slip in scene.slip.modes.items() if np.any(slip.strength))


def pairs_within(scene: Scene, neighbours: int | str) -> int:
    """Number of pairs within so many neighbours, or of all pairs; each pair counts twice."""
    count, periodic = scene.chain.particles, scene.chain.ends == "periodic"
    if periodic and neighbours == "all":
        return count * (count * (1 + 2 * (EXACT + POINTS)) - 1)
    places = count - 1 if isinstance(neighbours, str) else neighbours
    if periodic:
        return 2 * count * places
    places = min(places, count - 1)
    return places * (2 * count - places - 1)


def largest_flow(table: FlowTable, distance: float, radius: float) -> float:
    """A bound on |u|/V at a distance: the sum of the largest value of each row of a table."""
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
        """Set the two flows, each twice: one to evaluate and one to linearise."""
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


def reach_text(neighbours: int | str) -> str:
    """The reach in words."""
    if neighbours == "all":
        return "all pairs"
    return f"{neighbours} neighbour{'s' * (neighbours != 1)} a side"
