"""Cells of a plane, halved where the labels of their points differ.

A cell is a square of the lattice. Points on its edges that belong to smaller neighbours count among
its own, so that a boundary which enters a cell between two corners is followed.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping

from nrchain.diagrams.plane import Plane, Site

Cell = tuple[int, int, int]
"""i and j of the lower left corner, and the length of a side."""

Labels = Mapping[Site, Hashable]


class Mesh:
    """The cells of a plane, at first those of its coarse grid."""

    def __init__(self, plane: Plane) -> None:
        (right, top), step = plane.ends, plane.step
        self.cells = {(i, j, step) for i in range(0, right, step) for j in range(0, top, step)}

    def sites(self) -> list[Site]:
        """All corners, row by row."""
        found = {site for cell in self.cells for site in corners(cell)}
        return sorted(found, key=lambda site: site[::-1])

    def around(self, cell: Cell, labels: Labels) -> list[Site]:
        """The labelled points on the edges of a cell, counterclockwise from its corner."""
        return [site for site in _edges(cell) if site in labels]

    def mixed(self, labels: Labels) -> list[Cell]:
        """The cells that can be halved and whose labels differ, row by row."""
        found = [cell for cell in self.cells if cell[2] > 1 and self._differs(cell, labels)]
        return sorted(found, key=_by_row)

    def refine(self, labels: Labels, room: float = math.inf) -> list[Site]:
        """Halve cells whose labels differ, the largest first, until there are new points.

        Returns the new points, row by row: at most ``room`` of them.
        """
        new: dict[Site, None] = {}
        while not new:
            mixed, halved = self.mixed(labels), False
            largest = max((cell[2] for cell in mixed), default=0)
            for cell in mixed:
                parts = halves(cell)
                wanted = dict.fromkeys(s for part in parts for s in corners(part))
                added = [site for site in wanted if site not in labels and site not in new]
                if cell[2] == largest and len(new) + len(added) <= room:
                    new |= dict.fromkeys(added)
                    self.cells.remove(cell)
                    self.cells |= set(parts)
                    halved = True
            if not halved:
                break
        return sorted(new, key=lambda site: site[::-1])

    def pairs(self, labels: Labels) -> Iterator[tuple[Site, Site]]:
        """Neighbouring points along the edges of all cells."""
        for cell in self.cells:
            ring = self.around(cell, labels)
            yield from zip(ring, ring[1:] + ring[:1], strict=True)

    def _differs(self, cell: Cell, labels: Labels) -> bool:
        return len({labels[site] for site in self.around(cell, labels)}) > 1


def corners(cell: Cell) -> tuple[Site, Site, Site, Site]:
    """The corners of a cell, counterclockwise."""
    i, j, step = cell
    return (i, j), (i + step, j), (i + step, j + step), (i, j + step)


def halves(cell: Cell) -> list[Cell]:
    """The four cells of half the length."""
    i, j, step = cell
    half = step // 2
    return [(i + a * half, j + b * half, half) for b in (0, 1) for a in (0, 1)]


def _edges(cell: Cell) -> Iterator[Site]:
    """All lattice points on the edges of a cell, counterclockwise."""
    i, j, step = cell
    for k in range(step):
        yield i + k, j
    for k in range(step):
        yield i + step, j + k
    for k in range(step):
        yield i + step - k, j + step
    for k in range(step):
        yield i, j + step - k


def _by_row(cell: Cell) -> tuple[int, int]:
    return cell[1], cell[0]
