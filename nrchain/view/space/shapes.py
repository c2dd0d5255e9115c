"""Points and triangles of spheres, arrows and a tube: arrays that follow the poses of a chain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

FINEST = 30_000
"""Most points of all spheres together; more spheres have fewer points each."""


HEAD = 3.2
"""Radius of the head of an arrow over that of its shaft."""


@dataclass(frozen=True)
class Template:
    """One shape in body components: ``points`` and ``normals`` (P, 3), ``faces`` (M, 3)."""

    points: np.ndarray
    normals: np.ndarray
    faces: np.ndarray

    @classmethod
    def of(cls, mesh: Any) -> Template:
        """The shape of a mesh of PyVista."""
        flat = mesh.triangulate().compute_normals(split_vertices=True, feature_angle=40.0)
        faces = flat.faces.reshape(-1, 4)[:, 1:]
        return cls(np.array(flat.points, float), np.array(flat.point_normals, float), faces)

    def copies(self, count: int) -> np.ndarray:
        """Faces (count M, 4) of so many copies, each with its number of corners."""
        shifts = len(self.points) * np.arange(count)
        corners = (self.faces[None] + shifts[:, None, None]).reshape(-1, 3)
        return np.column_stack([np.full(len(corners), 3), corners])

    def place(self, positions: np.ndarray, frames: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points and normals (N P, 3) of copies at positions (N, 3) with frames (N, 3, 3)."""
        points = positions[:, None] + self.points @ frames
        return points.reshape(-1, 3), (self.normals @ frames).reshape(-1, 3)


def sphere(pyvista: Any, count: int) -> Template:
    """A sphere of radius 1 about the origin, as fine as ``count`` of them allow."""
    levels = (level for level in (4, 3, 2) if count * (10 * 4**level + 2) <= FINEST)
    mesh = pyvista.Icosphere(radius=1.0, nsub=next(levels, 1))
    faces = mesh.faces.reshape(-1, 4)[:, 1:]
    outward = np.array(mesh.points, float)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return Template(outward, outward, faces)


def dot(pyvista: Any, radius: float) -> Template:
    """A small sphere about the origin."""
    mesh = pyvista.Icosphere(radius=1.0, nsub=1)
    outward = np.array(mesh.points, float)
    return Template(radius * outward, outward, mesh.faces.reshape(-1, 4)[:, 1:])


def arrow(pyvista: Any, axis: int, length: float, thickness: float) -> Template:
    """An arrow from the origin along body axis ``axis``."""
    head = HEAD * thickness / length
    mesh = pyvista.Arrow(
        direction=np.eye(3)[axis],
        tip_length=2.2 * head,
        tip_radius=head,
        shaft_radius=thickness / length,
        tip_resolution=16,
        shaft_resolution=12,
        scale=length,
    )
    return Template.of(mesh)


class Tube:
    """A tube about the smooth curve through the centres of a chain."""

    def __init__(self, count: int, radius: float = 0.3, sides: int = 12) -> None:
        each = max(2, min(12, 4000 // count))
        self._knots = np.arange(count)
        self.places = np.linspace(0, count - 1, each * (count - 1) + 1)
        self.radius, self._sides = radius, sides
        rings, turn = len(self.places), np.arange(sides)
        low = (sides * np.arange(rings - 1))[:, None] + turn
        side = (sides * np.arange(rings - 1))[:, None] + (turn + 1) % sides
        corners = np.stack([low, side, side + sides, low + sides], axis=-1).reshape(-1, 4)
        self.faces = np.column_stack([np.full(len(corners), 4), corners])

    def place(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points and normals of the tube through positions (N, 3)."""
        curve = CubicSpline(self._knots, positions)
        centres, tangents = curve(self.places), curve(self.places, 1)
        sizes = np.linalg.norm(tangents, axis=1, keepdims=True)
        tangents = np.divide(tangents, sizes, out=np.zeros_like(tangents), where=sizes > 0.0)
        across = np.empty_like(tangents)
        last = np.eye(3)[np.argmin(np.abs(tangents[0]))]
        for ring, tangent in enumerate(tangents):
            # carried on from ring to ring without turning about the curve
            last = last - (tangent @ last) * tangent
            last = last / max(float(np.sqrt(last @ last)), 1e-300)
            across[ring] = last
        other = np.cross(tangents, across)
        angles = (2 * np.pi * np.arange(self._sides) / self._sides)[:, None]
        outward = np.cos(angles) * across[:, None] + np.sin(angles) * other[:, None]
        points = centres[:, None] + self.radius * outward
        return points.reshape(-1, 3), outward.reshape(-1, 3)

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Values of spheres (N,) or of links (N − 1,), interpolated to the points of the tube."""
        knots = self._knots if len(values) == len(self._knots) else self._knots[:-1] + 0.5
        return np.repeat(np.interp(self.places, knots, values), self._sides)
