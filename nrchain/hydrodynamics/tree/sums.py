"""Σ_j over all pairs of a long open chain: slip flows and friction, near pairs and far field."""

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
    fill_friction,
    fill_slip,
    fill_slip_changes,
)


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
        self._add_near(self._near_kernel(), (sources,), twists)

    def add_product(self, sources: np.ndarray, changes: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += the change of the sum with ``changes`` of the sources."""
        self._place(sources)
        self._fill_changes(sources, changes, self._field.changes)
        self._field.add_product(changes[:3], twists)
        self._add_near(self._near_product_kernel(), (sources, changes), twists)

    def _place(self, sources: np.ndarray) -> None:
        """Make the tree of these sources, once."""
        if not self._placed:
            self._field.place(sources[:3])
            self._fill(sources, self._field.own)
            self._placed = True

    def _add_near(self, compiled: Any, arrays: tuple[np.ndarray, ...], twists: np.ndarray) -> None:
        field = self._field
        ranges = field.bounds, field.lists.near_begin, field.lists.near
        sharing.add(compiled, field.parallel, *arrays, self._radius, *ranges, twists)

    @abstractmethod
    def _fill(self, sources: np.ndarray, own: np.ndarray) -> None:
        """The multipoles of each sphere."""

    @abstractmethod
    def _fill_changes(self, sources: np.ndarray, changes: np.ndarray, own: np.ndarray) -> None:
        """Their changes, without those due to displacements."""

    @abstractmethod
    def _near_kernel(self) -> Any:
        """The sum over near pairs, compiled for one or several threads."""

    @abstractmethod
    def _near_product_kernel(self) -> Any:
        """Its derivative."""


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

    def _near_kernel(self) -> Any:
        return partial(near.slip_kernel, self._law)

    def _near_product_kernel(self) -> Any:
        return partial(near.slip_product_kernel, self._law)


class FrictionTree(PairTree):
    """μ·W; sources as in :class:`nrchain.hydrodynamics.friction`."""

    def __init__(self, count: int, radius: float, accuracy: float) -> None:
        super().__init__(FarField(count, radius, accuracy, FRICTION_DEGREE, 0), radius)

    def _fill(self, sources: np.ndarray, own: np.ndarray) -> None:
        fill_friction(sources, own)

    def _fill_changes(self, sources: np.ndarray, changes: np.ndarray, own: np.ndarray) -> None:
        fill_friction(changes, own)

    def _near_kernel(self) -> Any:
        return near.friction_kernel

    def _near_product_kernel(self) -> Any:
        return near.friction_product_kernel
