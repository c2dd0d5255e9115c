"""Re Λ₁(x, y) = 0 as curves: crossings of lattice edges, found to rounding, joined cell by cell.

On an edge of the finest cells whose ends differ in the sign of the growth, the zero is that of
:func:`nrchain.critical_strength`. Marching squares joins the zeros. A curve ends where buckling, at
frequency 0, meets flutter.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nrchain.diagrams.linear import Rate, crossing
from nrchain.diagrams.mesh import Cell, Mesh, corners
from nrchain.diagrams.plane import Plane, Site
from nrchain.jobs.crew import FAILED, Job
from nrchain.jobs.ledger import Result
from nrchain.notebook import record_html
from nrchain.wording import brief

Edge = tuple[Site, Site]
"""Two neighbouring points of the lattice, the smaller first."""

Do = Callable[[Sequence[Job]], list[Result | None]]
"""Gives the results of jobs; None for those that are not there yet."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A line in the plane on which the straight chain turns unstable.

    Attributes
    ----------
    x, y
        (n,) the points in their order along the curve. A closed one ends where it begins.
    x_error, y_error
        (n,) their errors. Each point lies on a line of the lattice: one of the two is 0.
    frequency
        (n,) |Im Λ₁|: 0 where the chain buckles or coils, and that of its oscillation where it
        flutters.
    """

    x: np.ndarray
    y: np.ndarray
    x_error: np.ndarray
    y_error: np.ndarray
    frequency: np.ndarray

    __repr__ = brief
    _repr_html_ = record_html

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Curve):
            return NotImplemented
        return all(np.array_equal(vars(self)[name], vars(other)[name]) for name in vars(self))

    @property
    def flutters(self) -> bool:
        """Whether the chain oscillates at this threshold; else it buckles or coils."""
        return bool(self.frequency[0] > 0.0)


@dataclass(frozen=True)
class Crossing:
    """A point of a curve on an edge."""

    x: float
    y: float
    x_error: float
    y_error: float
    frequency: float


def trace(
    plane: Plane, mesh: Mesh, rates: Mapping[Site, Rate], do: Do
) -> tuple[tuple[Curve, ...], list[str]]:
    """The curves, and why points of them are missing; ``mesh`` is refined where signs differ."""
    cells = sorted(cell for cell in mesh.cells if cell[2] == 1)
    edges = sorted({edge for cell in cells for edge in _crossed(cell, rates)})
    jobs = [_job(plane, edge) for edge in edges]
    found: dict[Edge, Crossing] = {}
    notes = []
    for job, edge, result in zip(jobs, edges, do(jobs), strict=True):
        if result is None:
            continue
        if FAILED in result:
            notes.append(f"{job.name}: {result[FAILED]}")
            continue
        found[edge] = _crossing(plane, edge, result)
    segments = [pair for cell in cells for pair in _segments(cell, rates, found)]
    chains = _join(found, segments)
    return tuple(_curve([found[edge] for edge in chain]) for chain in chains), notes


def _crossed(cell: Cell, rates: Mapping[Site, Rate]) -> list[Edge]:
    """The edges of a cell along which the growth changes its sign, counterclockwise."""
    ring = corners(cell)
    found = []
    for k in range(4):
        first, second = sorted((ring[k], ring[(k + 1) % 4]))
        if first in rates and second in rates and rates[first].sign * rates[second].sign < 0:
            found.append((first, second))
    return found


def _job(plane: Plane, edge: Edge) -> Job:
    (i, j), (k, _) = edge
    axis = plane.x if k > i else plane.y
    places = [plane.place(site)[0 if k > i else 1] for site in edge]
    name = f"threshold {i} {j} {'x' if k > i else 'y'}"
    return Job(name, crossing, (plane.at(edge[0]), axis.key, *places))


def _crossing(plane: Plane, edge: Edge, result: Result) -> Crossing:
    x, y = plane.place(edge[0])
    if edge[1][0] > edge[0][0]:
        return Crossing(result["value"], y, result["error"], 0.0, result["frequency"])
    return Crossing(x, result["value"], 0.0, result["error"], result["frequency"])


def _segments(
    cell: Cell, rates: Mapping[Site, Rate], found: Mapping[Edge, Crossing]
) -> list[tuple[Edge, Edge]]:
    """The pieces of curves in a cell, between points of one kind."""
    edges = _crossed(cell, rates)
    pairs = [(edges[0], edges[1])] if len(edges) == 2 else []
    if len(edges) == 4:
        # a saddle: the corners that have the sign of the mean growth are connected
        ring = corners(cell)
        mean = sum(rates[site].growth for site in ring)
        alike = (mean > 0.0) == (rates[ring[0]].sign > 0)
        first, second, third, fourth = edges
        pairs = [(first, second), (third, fourth)] if alike else [(fourth, first), (second, third)]
    return [
        (one, other)
        for one, other in pairs
        if one in found
        and other in found
        and (found[one].frequency > 0.0) == (found[other].frequency > 0.0)
    ]


def _join(
    found: Mapping[Edge, Crossing], segments: Sequence[tuple[Edge, Edge]]
) -> list[list[Edge]]:
    """Points joined to chains; open ones begin at an end, and closed ones return to their start."""
    beside: dict[Edge, list[Edge]] = {edge: [] for edge in found}
    for one, other in segments:
        beside[one].append(other)
        beside[other].append(one)
    chains, seen = [], set()
    for begin in sorted(found, key=lambda edge: (len(beside[edge]) > 1, edge)):
        if begin in seen:
            continue
        chain, here = [begin], begin
        seen.add(begin)
        while following := [edge for edge in beside[here] if edge not in seen]:
            here = following[0]
            seen.add(here)
            chain.append(here)
        if len(chain) > 2 and begin in beside[here]:
            chain.append(begin)
        chains.append(chain)
    return chains


def _curve(points: Sequence[Crossing]) -> Curve:
    names = ("x", "y", "x_error", "y_error", "frequency")
    return Curve(*(np.array([getattr(point, name) for point in points]) for name in names))
