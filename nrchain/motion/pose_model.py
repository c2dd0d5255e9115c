"""What charts and integrators need of a model: poses → twists, and the derivative.

The chain of a scene is one (:class:`nrchain.motion.model.Model`), the nodes of a continuous rod are
another (:mod:`nrchain.theory.rod.nonlinear.model`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np


class PoseModel(Protocol):
    """(v, ω) of N bodies at their poses; attributes as those of ``Model``.

    ``elasticity``, ``slip`` and ``friction`` are falsy where a model has none. All else is in
    ``further_effects``, with ``gives``, ``carries`` and ``term``.
    """

    @property
    def elasticity(self) -> Any: ...
    @property
    def slip(self) -> Any: ...
    @property
    def linearise_slip(self) -> Any: ...

    @property
    def count(self) -> int: ...
    @property
    def period(self) -> float: ...
    @property
    def held(self) -> np.ndarray: ...
    @property
    def reach(self) -> int: ...
    @property
    def is_banded(self) -> bool: ...
    @property
    def is_near(self) -> bool: ...
    @property
    def near_reach(self) -> int: ...
    @property
    def wrench_reach(self) -> int: ...
    @property
    def needs_places(self) -> bool: ...
    @property
    def ties_frames(self) -> bool: ...
    @property
    def friction(self) -> Any: ...
    @property
    def drag(self) -> tuple[float, float]: ...
    @property
    def further_effects(self) -> Sequence[Any]: ...

    def twists(
        self, positions: np.ndarray, frames: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        """(v, ω) (N, 6); zero for held bodies."""
        ...

    def carrying_twists(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """(v, ω) (N, 6) of what may move the bodies as a whole."""
        ...

    def linearise(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6) = the derivative, or its part near the diagonal."""
        ...

    def add_product(self, poses: np.ndarray, twists: np.ndarray) -> None:
        """twists += their change with ``poses`` (N, 6), about the last linearisation."""
        ...
