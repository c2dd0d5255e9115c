"""A chain that is held at its first sphere and pushed by a follower force at its last one.

An effect of one's own, as docs/effects.md describes: the first sphere is held in place and in its
orientation by stiff springs, and the force on the last one is −f e₁, along its own axis whatever
the shape of the chain. A force f > 0 compresses the chain.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

import nrchain
from nrchain import rules

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class CantileverSpec(nrchain.Section):
    """The force at the end, and the springs that hold the first sphere at the origin."""

    path: ClassVar[str] = "cantilever"
    force: Annotated[float, rules.number()] = 0.0
    hold: Annotated[float, rules.number(least=0)] = 0.0


class Cantilever(nrchain.OneBodyEffect):
    """F = −k r and T = k d² Σ_j e_j × E_j on the first sphere, F = −f e₁ on the last."""

    name = "cantilever"
    summary = "a follower force at the end of a chain whose first sphere is held"
    equation = "F = −f e₁ at the end"
    Section = CantileverSpec
    covariant = False
    placed = True
    example: ClassVar[Any] = {"cantilever.force": 1.0, "cantilever.hold": 100.0}

    @property
    def _twisting(self) -> float:
        """k d²: of the springs that hold the orientation."""
        return float(self._spec.hold * self.scene.chain.spacing**2)

    @property
    def _spec(self) -> Any:
        return self.scene.cantilever

    def add_wrenches(self, positions: Array, frames: Array, wrenches: Array) -> None:
        wrenches[0, :3] -= self._spec.hold * positions[0]
        e = frames[0]
        wrenches[0, 3:] += self._twisting * np.array(
            [e[2, 1] - e[1, 2], e[0, 2] - e[2, 0], e[1, 0] - e[0, 1]]
        )
        wrenches[-1, :3] -= self._spec.force * frames[-1, 0]

    def derivative(self, positions: Array, frames: Array) -> Array:
        own = np.zeros((len(positions), 6, 6))
        own[0, :3, :3] = -self._spec.hold * np.eye(3)
        # (φ × e) × E = e (φ·E) − φ (e·E)
        own[0, 3:, 3:] = self._twisting * (frames[0].T - np.trace(frames[0]) * np.eye(3))
        x, y, z = self._spec.force * frames[-1, 0]
        # −f φ × e₁ = f e₁ × φ
        own[-1, :3, 3:] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        return own


@contextmanager
def cantilevers() -> Iterator[None]:
    """Within it, scenes have a table ``[cantilever]``."""
    nrchain.register_effect(Cantilever)
    try:
        yield
    finally:
        nrchain.unregister_effect(Cantilever.name)
