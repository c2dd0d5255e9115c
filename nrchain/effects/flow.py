"""v = G·r, ω = ½ curl(G·r): spheres carried by a background flow, a shear or an extension.

G is the gradient ∂u_p/∂r_q of the flow far from the chain, constant and traceless; the origin of
the lab is at rest. How rigid spheres disturb the flow is the effect ``strain``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from nrchain._addresses import (
    ROW,
    Term,
    carray,
    compile_term,
    floats_at,
    integers_at,
    matrix_in,
    table_of,
    vector_in,
)
from nrchain.effects.base import OneBodyEffect
from nrchain.effects.registry import register_effect
from nrchain.errors import SceneError
from nrchain.inputs.about import About
from nrchain.inputs.rules import Section, flag, vector
from nrchain.scene.fluid_sections import NEIGHBOURS
from nrchain.scene.scene import Scene

Matrix = tuple[tuple[float, float, float], ...]

TRACE = 1e-12
"""Largest trace of a gradient, relative to its largest entry: rounding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FlowSpec(Section):
    """u = G·r: the rows of a traceless G, and the disturbance of the flow by rigid spheres.

    ``neighbours`` is the number of neighbours on either side that feel the disturbance. With
    ``finite_size`` it has the factors (1 + a²∇²/6)(1 + a²∇²/10).
    """

    path: ClassVar[str] = "flow"
    set_by_auto: ClassVar[tuple[str, ...]] = ("neighbours", "finite_size")
    gradient: Annotated[Matrix, vector(inner=vector())] = ((0.0,) * 3,) * 3
    disturbance: Annotated[bool, flag()] = True
    neighbours: Annotated[int | Literal["all"], NEIGHBOURS] = "all"
    finite_size: Annotated[bool, flag()] = False
    about: ClassVar[Mapping[str, About]] = {
        "gradient": About(
            "G",
            "1/T",
            "3 × 3 without trace; on a periodic chain, first column zero",
            "velocity gradient, row by row",
        ),
        "disturbance": About(
            "",
            "",
            "true, false",
            "spheres resist the strain, and their stresslets disturb the flow",
        ),
        "neighbours": About(
            "k",
            "",
            'whole number ≥ 1, "all"',
            "reach of the disturbance, independent of slip and friction",
        ),
        "finite_size": About("", "", "true, false", "add the (a/r)² correction of the disturbance"),
    }

    @property
    def matrix(self) -> np.ndarray:
        """G (3, 3)."""
        return np.array(self.gradient)

    def check(self) -> None:
        if abs(np.trace(self.matrix)) > TRACE * np.abs(self.matrix).max():
            allowed = "must have no trace: the fluid is incompressible"
            raise SceneError("flow.gradient", self.gradient, allowed)


def _add_at(context: int, positions: int, frames: int, out: int, width: int) -> int:
    """The term of :meth:`Flow.add_twists`; its table: G, ½ curl, and N."""
    t = carray(integers_at(context), (3, ROW))
    gradient, spin = matrix_in(t, 0, floats_at), vector_in(t, 1, floats_at)
    n = vector_in(t, 2, integers_at)[0]
    r, twists = carray(floats_at(positions), (n, 3)), carray(floats_at(out), (n, 6))
    for i in range(n):
        for k in range(3):
            twists[i, 3 + k] += spin[k]
            for m in range(3):
                twists[i, k] += gradient[k, m] * r[i, m]
    return 0


def _add_blocks_at(context: int, positions: int, frames: int, out: int, width: int) -> int:
    """The derivative of the same: blocks[i, w] += G."""
    t = carray(integers_at(context), (3, ROW))
    gradient, n = matrix_in(t, 0, floats_at), vector_in(t, 2, integers_at)[0]
    blocks = carray(floats_at(out), (n, 2 * width + 1, 6, 6))
    for i in range(n):
        for k in range(3):
            for m in range(3):
                blocks[i, width, k, m] += gradient[k, m]
    return 0


@register_effect
class Flow(OneBodyEffect):
    """The background flow of a scene at the centre of each sphere."""

    name = "flow"
    key = "flow.gradient"
    summary = "a background flow, shear or extension, carries and turns every sphere"
    absence = "the fluid is at rest far away"
    equation = "v = G·r, ω = ½ ∇ × (G·r)"
    gives = "twist"
    Section = FlowSpec
    example = {  # noqa: RUF012
        "flow.gradient": [[0.0, 0.3, -0.1], [0.0, 0.2, 0.4], [0.0, -0.3, -0.2]]
    }
    covariant = False
    carries = True

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self._gradient = self.section(scene).matrix
        g = self._gradient
        self.spin = 0.5 * np.array([g[2, 1] - g[1, 2], g[0, 2] - g[2, 0], g[1, 0] - g[0, 1]])

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        return bool(cls.section(scene).matrix.any())

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse a flow that changes along x on a periodic chain."""
        gradient = cls.section(scene).gradient
        if scene.chain.ends == "periodic" and any(row[0] for row in gradient):
            allowed = (
                "must not change along x on a periodic chain (its first column zero, as in the"
                " shear u_x = γ y), or its images move apart; or choose free or clamped ends"
            )
            raise SceneError(cls.key, gradient, allowed)

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """|G| over half the chain."""
        return float(np.linalg.norm(cls.section(scene).matrix, 2)) * 0.5 * scene.length

    @classmethod
    def straight(cls, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """The twist of a sphere on the x axis, and G as its derivative with u.

        Raises SceneError for a flow that changes along x: it stretches or rotates the chain.
        """
        flow, twist, own = cls(scene), np.zeros((1, 6)), np.zeros((6, 6))
        if flow._gradient[:, 0].any():
            allowed = (
                "changes along x (its first column): it stretches a straight chain along x, or"
                " turns it away from x"
            )
            raise SceneError(cls.key, cls.section(scene).gradient, allowed)
        flow.add_twists(np.zeros((1, 3)), np.eye(3)[None], twist)
        own[:3, :3] = flow._gradient
        return twist[0], own

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        twists[:, :3] += positions @ self._gradient.T
        twists[:, 3:] += self.spin

    def term(self) -> Term:
        entries = compile_term(_add_at), compile_term(_add_blocks_at)
        arrays = self._gradient, self.spin, np.array([self.scene.chain.particles])
        return Term(entries[0].address, entries[1].address, table_of(arrays), (*arrays, *entries))

    def derivative(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        own = np.zeros((len(positions), 6, 6))
        own[:, :3, :3] = self._gradient
        return own
