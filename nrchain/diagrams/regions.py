"""Regions: neighbouring points of one kind, and the point of each that is farthest from others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from nrchain.diagrams.mesh import Mesh, corners
from nrchain.diagrams.plane import Plane, Site
from nrchain.diagrams.trials import PhasePoint
from nrchain.diagrams.verification import Verification
from nrchain.notebook import record_html
from nrchain.wording import brief


@dataclass(frozen=True)
class Region:
    """Points of one kind that are connected along the edges of cells.

    Attributes
    ----------
    kinds
        What chains end in there; several where more than one attractor is stable.
    points
        Places of its points in the table of the diagram.
    share
        Its part of the plane: each cell counts a quarter for each of its corners.
    x, y
        The ranges that its points span.
    inner
        The place, in the table, of the point that is farthest from other kinds.
    verified
        What confirms each kind at this point.
    """

    kinds: tuple[str, ...]
    points: tuple[int, ...]
    share: float
    x: tuple[float, float]
    y: tuple[float, float]
    inner: int
    verified: tuple[Verification, ...] = ()

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def kind(self) -> str:
        """The kinds in words."""
        return " or ".join(self.kinds)

    @property
    def agrees(self) -> bool:
        """Whether all that was verified agrees, and something was."""
        return bool(self.verified) and all(one.agrees for one in self.verified)


def connected(plane: Plane, mesh: Mesh, points: Mapping[Site, PhasePoint]) -> list[Region]:
    """The regions, from the largest on."""
    order = {site: place for place, site in enumerate(points)}
    groups = _groups(mesh, points)
    shares = dict.fromkeys(points, 0.0)
    for cell in mesh.cells:
        for site in corners(cell):
            if site in shares:
                shares[site] += 0.25 * cell[2] ** 2 / (plane.ends[0] * plane.ends[1])
    regions = []
    for sites in groups:
        own = [points[site] for site in sites]
        inner = _inner(plane, sites, points)
        regions.append(
            Region(
                kinds=own[0].kinds,
                points=tuple(order[site] for site in sites),
                share=float(sum(shares[site] for site in sites)),
                x=(min(p.x for p in own), max(p.x for p in own)),
                y=(min(p.y for p in own), max(p.y for p in own)),
                inner=order[inner],
            )
        )
    return sorted(regions, key=lambda region: (-region.share, region.points))


def _groups(mesh: Mesh, points: Mapping[Site, PhasePoint]) -> list[list[Site]]:
    """Sites of one kind that are connected, each group in the order of the points."""
    beside: dict[Site, set[Site]] = {site: set() for site in points}
    for one, other in mesh.pairs(points):
        if points[one].kinds == points[other].kinds:
            beside[one].add(other)
            beside[other].add(one)
    groups, seen = [], set()
    for begin in points:
        if begin in seen:
            continue
        group, border = {begin}, [begin]
        while border:
            new = beside[border.pop()] - group
            group |= new
            border += new
        seen |= group
        groups.append([site for site in points if site in group])
    return groups


def _inner(plane: Plane, sites: list[Site], points: Mapping[Site, PhasePoint]) -> Site:
    """The site that is farthest from other kinds, and then from the edges of the plane."""
    own = np.array(sites, float) / plane.ends
    kinds = points[sites[0]].kinds
    others = np.array([site for site in points if points[site].kinds != kinds], float)
    to_edge = np.minimum(own, 1.0 - own).min(axis=1)
    if not len(others):
        return sites[int(np.argmax(to_edge))]
    others = others / plane.ends
    apart = np.linalg.norm(own[:, None] - others, axis=2).min(axis=1)
    best = max(range(len(sites)), key=lambda k: (round(apart[k], 12), round(to_edge[k], 12), -k))
    return sites[best]
