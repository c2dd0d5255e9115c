"""Σ_j u(x_i − x_j) over all pairs but the near ones, for any number of spheres along a chain."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from nrchain.hydrodynamics import sharing
from nrchain.hydrodynamics.tree.accuracy import far_ratios, highest_degree
from nrchain.hydrodynamics.tree.harmonics import coupling
from nrchain.hydrodynamics.tree.intervals import (
    GAP,
    fill_balls,
    interval_bounds,
    interval_lists,
)
from nrchain.hydrodynamics.tree.moments import add_displaced
from nrchain.hydrodynamics.tree.passes import (
    POTENTIALS,
    across_kernel,
    add_moved,
    flow_kernel,
    gather_kernel,
    gradient_kernel,
    lower_kernel,
    raise_kernel,
)

PARALLEL_SPHERES = 2000
"""More spheres than this are summed on several threads."""

LEAF = 8
"""Spheres of a leaf for each degree: its pairs then take about as long as its multipoles."""


class FarField:
    """The flow of far intervals at each sphere, and its derivative, at one set of positions.

    Parameters
    ----------
    count, radius
        N and a.
    accuracy
        Largest error of a sum over all pairs, relative to its largest value.
    own_degree
        Highest degree of the multipoles of one sphere.
    lowest
        Their lowest degree.

    Attributes
    ----------
    own
        (N, (own degree + 1)², 4) multipoles of each sphere about its own centre
        (:mod:`nrchain.hydrodynamics.tree.moments`); fill them after :meth:`place`.
    lists
        What is far and what is near at the positions last passed to :meth:`place`.
    bounds
        The intervals (:func:`~nrchain.hydrodynamics.tree.intervals.interval_bounds`).
    parallel
        Whether sums run on several threads.
    """

    def __init__(
        self, count: int, radius: float, accuracy: float, own_degree: int, lowest: int
    ) -> None:
        self._radius, self.parallel = radius, count > PARALLEL_SPHERES
        self.degree = highest_degree(accuracy, own_degree)
        self._ratios = far_ratios(accuracy, self.degree, own_degree)
        self.table = tuple(coupling(self.degree))
        self.bounds = interval_bounds(count, LEAF * self.degree)
        shape = len(self.bounds), (self.degree + 1) ** 2, POTENTIALS
        self._multipoles, self._locals = np.zeros(shape), np.zeros(shape)
        self._balls = np.zeros((len(self.bounds), 4))
        self._points = np.empty((3, count))
        self._own_degree, self._lowest = own_degree, lowest
        self.own = np.empty((count, (own_degree + 1) ** 2, POTENTIALS))

    @cached_property
    def changes(self) -> np.ndarray:
        """Room for the changes of :attr:`own`, up to one degree more."""
        return np.empty((len(self.own), (self._own_degree + 2) ** 2, POTENTIALS))

    def place(self, points: np.ndarray) -> None:
        """Take the positions (3, N): set :attr:`lists`."""
        np.multiply(points, 1.0 / self._radius, out=self._points)
        fill_balls(self._points, self.bounds, self._balls)
        self._gradients: np.ndarray | None = None
        self.lists = interval_lists(self.bounds, self._balls, self._ratios, GAP)

    def add(self, twists: np.ndarray) -> None:
        """twists (N, 6) += the flow of far intervals, from the multipoles :attr:`own`."""
        self._spread(self.own, self._lowest)
        self._run(flow_kernel, self._points, *self._tree(), self._locals, self._radius, twists)

    def add_product(self, moves: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += the change of :meth:`add` with displacements ``moves`` (3, N).

        :attr:`changes` holds all other changes of :attr:`own`, and is overwritten.
        """
        if self._gradients is None:
            self._gradients = np.empty((len(twists), 6, 3))
            self._spread(self.own, self._lowest)
            self._run(gradient_kernel, self._points, *self._tree(), self._locals, self._gradients)
        moves = np.ascontiguousarray(moves) / self._radius
        add_displaced(self.table, self._own_degree, moves, self.own, self.changes)
        self._spread(self.changes, self._lowest)
        self._run(flow_kernel, self._points, *self._tree(), self._locals, self._radius, twists)
        add_moved(self._gradients, moves, self._radius, twists)

    def _tree(self) -> tuple:
        return self.bounds, self._balls, self.degree, self.table

    def _run(self, compiled: Any, *arguments: Any) -> None:
        sharing.add(compiled, self.parallel, *arguments)

    def _spread(self, own: np.ndarray, lowest: int) -> None:
        """The local expansions of all intervals, from the multipoles of the spheres."""
        tree = self._tree()
        self._run(gather_kernel, self._points, own, lowest, *tree, self._multipoles)
        self._run(raise_kernel, self._balls, self.degree, self.table, self._multipoles)
        far, passed = (self.lists.far_begin, self.lists.far), (self._multipoles, self._locals)
        self._run(across_kernel, self._balls, *far, self.degree, self.table, *passed)
        self._run(lower_kernel, self._balls, self.degree, self.table, self._locals)
