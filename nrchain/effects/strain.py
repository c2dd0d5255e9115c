"""u = −(5a³/2) x (x·E·x)/r⁵, w = −(5a³/2)(E·x) × x/r⁵: rigid spheres resist a strain.

E is the symmetric part of the gradient of a background flow. A sphere that does not deform as the
fluid around it would sheds the flow of its stresslet S = (20/3)πηa³E, to leading order in a/r, and
carries and turns the others with it; w is half the curl of u. x points from the sphere that sheds
to the one that feels. The relative velocity of two spheres is changed by −5(a/r)³ x (x·E·x)/r²,
which is the leading order of Batchelor & Green, J. Fluid Mech. 56, 375 (1972), Eq. (2.7).
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numba import prange

from nrchain._compile import kernel
from nrchain.effects.base import Cost, Effect
from nrchain.effects.flow import Flow
from nrchain.effects.registry import register_effect
from nrchain.effects.slip import pairs_within, reach_text
from nrchain.errors import SceneError
from nrchain.hydrodynamics.images import Layout
from nrchain.hydrodynamics.pairs import NEAR, PARALLEL_PAIRS, compile_sum
from nrchain.scene import Scene, load_scene


@kernel
def _pull(strain, x):
    """E·x."""
    return (
        strain[0, 0] * x[0] + strain[0, 1] * x[1] + strain[0, 2] * x[2],
        strain[1, 0] * x[0] + strain[1, 1] * x[1] + strain[1, 2] * x[2],
        strain[2, 0] * x[0] + strain[2, 1] * x[1] + strain[2, 2] * x[2],
    )


@kernel
def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


@kernel
def _cross(p, q):
    return (
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    )


@kernel
def _between(points, i, j):
    """r_i − r_j."""
    return (
        points[i, 0] - points[j, 0],
        points[i, 1] - points[j, 1],
        points[i, 2] - points[j, 2],
    )


@kernel
def _add_change(x, dx, strain, factor, out):
    """out (6,) += factor times the change of (x x·E·x, (E·x) × x)/r⁵ when x changes by dx."""
    square = 1.0 / _dot(x, x)
    factor *= square**2 * np.sqrt(square)
    pulled, moved = _pull(strain, x), _pull(strain, dx)
    along, stretch = _dot(pulled, x), 5.0 * square * _dot(x, dx)
    change = 2.0 * _dot(pulled, dx) - along * stretch
    turn, first, second = _cross(pulled, x), _cross(moved, x), _cross(pulled, dx)
    for k in range(3):
        out[k] += factor * (change * x[k] + along * dx[k])
        out[3 + k] += factor * (first[k] + second[k] - stretch * turn[k])


@cache
def _twist_kernel(parallel: bool) -> Any:
    """Compile the sum over pairs: see :meth:`Strain.add_twists`."""

    def add_strain(points, weights, strain, size, first, reach, twists):
        for i in prange(twists.shape[0]):
            me = first + i
            for j in range(max(0, me - reach), min(points.shape[0], me + reach + 1)):
                if j == me:
                    continue
                x = _between(points, me, j)
                pulled, square = _pull(strain, x), 1.0 / _dot(x, x)
                factor = -size * weights[j] * square**2 * np.sqrt(square)
                along, turn = _dot(pulled, x), _cross(pulled, x)
                for k in range(3):
                    twists[i, k] += factor * along * x[k]
                    twists[i, 3 + k] += factor * turn[k]

    return compile_sum(add_strain, parallel)


@cache
def _product_kernel(parallel: bool) -> Any:
    """Compile its derivative along a change: see :meth:`Strain.add_product`."""

    def add_strain_product(points, moves, weights, strain, size, first, reach, out):
        for i in prange(out.shape[0]):
            me = first + i
            for j in range(max(0, me - reach), min(points.shape[0], me + reach + 1)):
                if j == me:
                    continue
                x, dx = _between(points, me, j), _between(moves, me, j)
                _add_change(x, dx, strain, -size * weights[j], out[i])

    return compile_sum(add_strain_product, parallel)


@kernel
def _add_blocks(points, weights, strain, size, first, reach, blocks):
    centre = blocks.shape[1] // 2
    column = np.empty(6)
    for i in range(blocks.shape[0]):
        me = first + i
        for j in range(max(0, me - reach), min(points.shape[0], me + reach + 1)):
            if j == me:
                continue
            x = _between(points, me, j)
            for k in range(3):
                dx = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
                column[:] = 0.0
                _add_change(x, dx, strain, -size * weights[j], column)
                for row in range(6):
                    blocks[i, centre, row, k] += column[row]
                    blocks[i, centre + j - me, row, k] -= column[row]


@register_effect
class Strain(Effect):
    """The disturbance of a background flow by the spheres in it, over the reach of the slip."""

    name = "strain"
    key = "flow.disturbance"
    summary = "rigid spheres in a background flow disturb it: stresslets, over the slip's reach"
    absence = "spheres disturb no background flow"
    equation = "u = −(5a³/2) x (x·E·x)/r⁵, w = ½ curl u"
    gives = "twist"
    example = Flow.example
    covariant = False
    placed = False
    over_reach = True

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        chain, neighbours = scene.chain, scene.slip.neighbours
        gradient = Flow.section(scene).matrix
        self._strain = 0.5 * (gradient + gradient.T)
        self._size = 2.5 * chain.radius**3
        self._layout = Layout.of(
            chain.particles,
            neighbours if isinstance(neighbours, int) else None,
            scene.length if chain.ends == "periodic" else 0.0,
        )
        reach = self._layout.reach
        self.places = reach if reach <= NEAR else None
        self._parallel = 2 * reach * chain.particles > PARALLEL_PAIRS

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        gradient = Flow.section(scene).matrix
        return Flow.section(scene).disturbance and bool((gradient + gradient.T).any())

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        return load_scene(scene, **{cls.key: False})

    @classmethod
    def detail(cls, scene: Scene) -> str:
        return f"stresslets, {reach_text(scene.slip.neighbours)}"

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        return Cost(pairs_within(scene, scene.slip.neighbours), "pairs")

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """One neighbour at d: (5/2)(a/d)³ |E| d."""
        gradient, d = Flow.section(scene).matrix, scene.chain.spacing
        strain = 0.5 * float(np.linalg.norm(gradient + gradient.T, 2))
        return 2.5 * (scene.chain.radius / d) ** 3 * strain * d

    @classmethod
    def straight(cls, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Refused: the lattice operator has no part for it."""
        allowed = (
            "has no part in the laws of the endless straight chain: flow.disturbance = false leaves"
            " it out"
        )
        raise SceneError(cls.key, True, allowed)

    def _points(self, positions: np.ndarray) -> np.ndarray:
        points = positions[self._layout.spheres]
        points[:, 0] += self._layout.shifts
        return points

    def _law(self) -> tuple[Any, ...]:
        layout = self._layout
        return layout.weights, self._strain, self._size, layout.first, layout.reach

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        _twist_kernel(self._parallel)(self._points(positions), *self._law(), twists)

    def linearise(self, positions: np.ndarray, frames: np.ndarray) -> None:
        self._there = self._points(positions)

    def add_blocks(self, blocks: np.ndarray) -> None:
        """Nothing where the blocks are not the whole derivative: the flow is smooth."""
        if self.places is not None and self.places <= blocks.shape[1] // 2:
            _add_blocks(self._there, *self._law(), blocks)

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        moves = poses[self._layout.spheres, :3]
        _product_kernel(self._parallel)(self._there, moves, *self._law(), out)
