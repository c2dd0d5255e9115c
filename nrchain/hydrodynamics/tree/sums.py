"""Σ_j over all pairs of a long open chain: its near pairs and its far field."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import partial
from typing import Any

import numpy as np

from nrchain.hydrodynamics import sharing
from nrchain.hydrodynamics.pair_law import PairLaw
from nrchain.hydrodynamics.tree import near
from nrchain.hydrodynamics.tree.far_field import FarField
from nrchain.hydrodynamics.tree.moments import (
    FRICTION_DEGREE,
    Terms,
    fill_slip,
    fill_slip_changes,
    fill_wrenches,
    strain_multipoles,
)

FELT = 0.5
"""The factor of f·x/ρ³ in ψ for what a sphere feels of the force on another."""

Disturbed = tuple[bool, np.ndarray, float]
"""The part of a disturbance: whether it is the stresslet, E (3, 3), and its prefactor."""


class PairTree(ABC):
    """A sum over all pairs by near pairs and a far field.

    ``sources`` and ``changes`` are the arrays of the direct sum, by sphere. Call :meth:`move` when
    sources have changed.
    """

    def __init__(self, field: FarField, radius: float) -> None:
        self._field, self._radius, self._placed = field, radius, False

    def move(self) -> None:
        """Forget the tree of the last sources."""
        self._placed = False

    def add_twists(self, sources: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += the sum at every sphere."""
        self._place(sources)
        self._field.add(twists)
        self._add_near(sources, twists)

    def add_product(self, sources: np.ndarray, changes: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += the change of the sum with ``changes`` of the sources."""
        self._place(sources)
        self._fill_changes(sources, changes, self._field.changes)
        self._field.add_product(changes[:3], twists)
        self._add_near_product(sources, changes, twists)

    def _place(self, sources: np.ndarray) -> None:
        """Make the tree of these sources, once."""
        if not self._placed:
            self._field.place(sources[:3])
            self._fill(sources, self._field.own)
            self._placed = True

    def _sum_near(self, compiled: Any, *arguments: Any, twists: np.ndarray) -> None:
        """Run a kernel over the near pairs."""
        field = self._field
        ranges = field.bounds, field.lists.near_begin, field.lists.near
        sharing.add(compiled, field.parallel, *arguments, *ranges, twists)

    @abstractmethod
    def _fill(self, sources: np.ndarray, own: np.ndarray) -> None:
        """The multipoles of each sphere."""

    @abstractmethod
    def _fill_changes(self, sources: np.ndarray, changes: np.ndarray, own: np.ndarray) -> None:
        """Their changes, without those due to displacements."""

    @abstractmethod
    def _add_near(self, sources: np.ndarray, twists: np.ndarray) -> None:
        """twists += the sum over near pairs."""

    @abstractmethod
    def _add_near_product(
        self, sources: np.ndarray, changes: np.ndarray, twists: np.ndarray
    ) -> None:
        """twists += its change."""


class SlipTree(PairTree):
    """Σ_j (u, w) of the modes of a law; sources as in :class:`nrchain.hydrodynamics.pairs`."""

    def __init__(
        self, law: PairLaw, terms: Terms, count: int, radius: float, accuracy: float
    ) -> None:
        super().__init__(FarField(count, radius, accuracy, terms.degree, terms.lowest), radius)
        self._law = law.source
        self._terms = len(law.axes), terms.rows, terms.factors, terms.degree

    def _fill(self, sources: np.ndarray, own: np.ndarray) -> None:
        fill_slip(sources, *self._terms, self._field.table, own)

    def _fill_changes(self, sources: np.ndarray, changes: np.ndarray, own: np.ndarray) -> None:
        fill_slip_changes(sources, changes, *self._terms, self._field.table, own)

    def _add_near(self, sources: np.ndarray, twists: np.ndarray) -> None:
        compiled = partial(near.slip_kernel, self._law)
        self._sum_near(compiled, sources, self._radius, twists=twists)

    def _add_near_product(
        self, sources: np.ndarray, changes: np.ndarray, twists: np.ndarray
    ) -> None:
        compiled = partial(near.slip_product_kernel, self._law)
        self._sum_near(compiled, sources, changes, self._radius, twists=twists)


class FrictionTree(PairTree):
    """μ·W; sources as in :class:`nrchain.hydrodynamics.friction`."""

    def __init__(self, count: int, radius: float, accuracy: float) -> None:
        super().__init__(FarField(count, radius, accuracy, FRICTION_DEGREE, 0), radius)

    def _fill(self, sources: np.ndarray, own: np.ndarray) -> None:
        fill_wrenches(sources, FELT, own)

    def _fill_changes(self, sources: np.ndarray, changes: np.ndarray, own: np.ndarray) -> None:
        fill_wrenches(changes, FELT, own)

    def _add_near(self, sources: np.ndarray, twists: np.ndarray) -> None:
        self._sum_near(near.friction_kernel, sources, self._radius, twists=twists)

    def _add_near_product(
        self, sources: np.ndarray, changes: np.ndarray, twists: np.ndarray
    ) -> None:
        compiled = near.friction_product_kernel
        self._sum_near(compiled, sources, changes, self._radius, twists=twists)


class DisturbanceTree(PairTree):
    """Σ_j (u, w) of spheres in a strain; sources (3, N) are positions."""

    def __init__(self, law: Disturbed, count: int, radius: float, accuracy: float) -> None:
        leading, self._strain, self._size = law
        self._leading, degree = leading, 1 if leading else 2
        super().__init__(FarField(count, radius, accuracy, degree, degree), radius)

    def _fill(self, sources: np.ndarray, own: np.ndarray) -> None:
        own[:] = strain_multipoles(self._leading, self._radius * self._strain)

    def _fill_changes(self, sources: np.ndarray, changes: np.ndarray, own: np.ndarray) -> None:
        own[:] = 0.0

    def _add_near(self, sources: np.ndarray, twists: np.ndarray) -> None:
        compiled = partial(near.disturbance_kernel, self._leading)
        points = np.ascontiguousarray(sources.T)
        self._sum_near(compiled, points, self._strain, self._size, twists=twists)

    def _add_near_product(
        self, sources: np.ndarray, changes: np.ndarray, twists: np.ndarray
    ) -> None:
        compiled = partial(near.disturbance_product_kernel, self._leading)
        points, moves = (np.ascontiguousarray(rows.T) for rows in (sources, changes))
        self._sum_near(compiled, points, moves, self._strain, self._size, twists=twists)
