"""Poses of the nodes of a rod → their twists: the rod as a model for charts and integrators.

With nodes in place of spheres, charts and integrators do for a rod all that they do for a chain.
Charts move with the mean motion that its sources give a rod: the stress moves no rod as a whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from nrchain._addresses import (
    Term,
    carray,
    compile_term,
    cube_in,
    floats_at,
    integers_at,
    matrix_in,
    table_of,
    vector_in,
)
from nrchain._compile import part
from nrchain.potential.link import add_block_product
from nrchain.theory.rod.nonlinear.derivative import add_blocks
from nrchain.theory.rod.nonlinear.elements import Elements
from nrchain.theory.rod.nonlinear.kernels import add_twists, set_mean_motion

SLOPES, WEIGHTS, LAW, MOBILITY, POINTS, PERIOD, COUNTS, LENGTHS = range(8)
ARRAYS, ROW = 8, 5


@part
def _add_twists_at(context: int, positions: int, frames: int, out: int, stressed: bool) -> None:
    t = carray(integers_at(context), (ARRAYS, ROW))
    n, counts = t[MOBILITY, 1], vector_in(t, COUNTS, integers_at)
    add_twists(
        carray(floats_at(positions), (n, 3)),
        carray(floats_at(frames), (n, 3, 3)),
        matrix_in(t, SLOPES, floats_at),
        vector_in(t, WEIGHTS, floats_at),
        matrix_in(t, LAW, floats_at),
        cube_in(t, MOBILITY, floats_at),
        matrix_in(t, POINTS, floats_at),
        counts[0],
        vector_in(t, PERIOD, floats_at)[0],
        stressed,
        carray(floats_at(out), (n, 6)),
    )


def _add_twists(context: int, positions: int, frames: int, out: int, width: int) -> int:
    """The term of :meth:`RodEffect.add_twists`."""
    _add_twists_at(context, positions, frames, out, True)
    return 0


def _set_carrying(context: int, positions: int, frames: int, out: int, width: int) -> int:
    """The term of :meth:`RodModel.carrying_twists`, the only one that carries a rod."""
    t = carray(integers_at(context), (ARRAYS, ROW))
    n = t[MOBILITY, 1]
    _add_twists_at(context, positions, frames, out, False)
    set_mean_motion(
        carray(floats_at(frames), (n, 3, 3)),
        vector_in(t, LENGTHS, floats_at),
        carray(floats_at(out), (n, 6)),
    )
    return 0


def _add_blocks(context: int, positions: int, frames: int, out: int, width: int) -> int:
    """The term of :meth:`RodEffect.add_blocks`."""
    t = carray(integers_at(context), (ARRAYS, ROW))
    n, counts = t[MOBILITY, 1], vector_in(t, COUNTS, integers_at)
    add_blocks(
        carray(floats_at(positions), (n, 3)),
        carray(floats_at(frames), (n, 3, 3)),
        matrix_in(t, SLOPES, floats_at),
        vector_in(t, WEIGHTS, floats_at),
        matrix_in(t, LAW, floats_at),
        cube_in(t, MOBILITY, floats_at),
        matrix_in(t, POINTS, floats_at),
        counts[0],
        vector_in(t, PERIOD, floats_at)[0],
        carray(floats_at(out), (n, 2 * width + 1, 6, 6)),
    )
    return 0


@dataclass(eq=False)
class RodEffect:
    """The twists that stress and sources give the nodes of a rod.

    ``arrays`` are those of :func:`arrays_of`, in the order of the table of addresses.
    """

    arrays: tuple[np.ndarray, ...]
    gives: ClassVar[Literal["twist"]] = "twist"
    carries: ClassVar[bool] = True

    def __post_init__(self) -> None:
        self._table = table_of(self.arrays)
        self._add, self._add_blocks = compile_term(_add_twists), compile_term(_add_blocks)
        self._carry = compile_term(_set_carrying)

    def __reduce__(self) -> tuple[Any, ...]:
        # addresses are those of this process
        return type(self), (self.arrays,)

    def term(self) -> Term:
        """The effect by address, for compiled steps."""
        entries = self._add, self._add_blocks
        return Term(entries[0].address, entries[1].address, self._table, (*self.arrays, *entries))

    def carrying_term(self) -> Term:
        """The mean motion due to the sources."""
        entry = self._carry
        return Term(entry.address, self._add_blocks.address, self._table, (*self.arrays, entry))

    def set_carrying(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6), zero before, = the mean motion due to the sources."""
        self._call(self._carry, positions, frames, twists, 0)

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += (v, ω) of every node, in the lab."""
        self._call(self._add, positions, frames, twists, 0)

    def add_jacobian(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6) += ∂(v, ω)_i/∂(u, φ)_{i+m−w} at these poses."""
        self._call(self._add_blocks, positions, frames, blocks, blocks.shape[1] // 2)

    def _call(
        self, entry: object, positions: np.ndarray, frames: np.ndarray, out: np.ndarray, width: int
    ) -> None:
        places, axes = (np.ascontiguousarray(array, float) for array in (positions, frames))
        addresses = (array.ctypes.data for array in (self._table, places, axes, out))
        entry.ctypes(*addresses, width)  # type: ignore[attr-defined]


def arrays_of(
    elements: Elements,
    law: np.ndarray,
    mobility: np.ndarray,
    points: np.ndarray,
    lengths: np.ndarray,
) -> tuple[np.ndarray, ...]:
    """What the kernels need: see :mod:`~nrchain.theory.rod.nonlinear.kernels`.

    ``mobility`` (N, 6, 6) is Γ⁻¹ over the length of each node, ``points`` (N, 6) wrenches on nodes
    along their own axes, ``lengths`` (N,) the lengths of rod with the drag of each node.
    """
    return (
        np.ascontiguousarray(elements.slopes),
        np.ascontiguousarray(elements.weights),
        law,
        mobility,
        points,
        np.array([elements.length if elements.closed else 0.0]),
        np.array([elements.count]),
        lengths,
    )


class RodModel:
    """(v, ω) of all nodes and its derivative: see :class:`nrchain.motion.pose_model.PoseModel`."""

    is_banded = is_near = True
    needs_places = False
    ties_frames = True
    friction = elasticity = slip = linearise_slip = None
    drag = (1.0, 1.0)
    wrench_reach = 0

    def __init__(
        self,
        elements: Elements,
        held: np.ndarray,
        law: np.ndarray,
        mobility: np.ndarray,
        points: np.ndarray,
        lengths: np.ndarray,
    ) -> None:
        self.count, self.held = len(elements.places), held
        self.reach = self.near_reach = elements.degree
        self.period = elements.length if elements.closed else 0.0
        self._effect = RodEffect(arrays_of(elements, law, mobility, points, lengths))
        self.further_effects = (self._effect,)

    def twists(
        self, positions: np.ndarray, frames: np.ndarray, out: np.ndarray | None = None
    ) -> np.ndarray:
        """(v, ω) (N, 6) of every node in the lab; zero for clamped ends."""
        twists = np.empty((self.count, 6)) if out is None else out
        twists[:] = 0.0
        self._effect.add_twists(positions, frames, twists)
        twists[self.held] = 0.0
        return twists

    def carrying_twists(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """(v, ω) (N, 6): the mean motion due to the sources, weighted by the drag of the nodes."""
        twists = np.zeros((self.count, 6))
        self._effect.set_carrying(positions, frames, twists)
        return twists

    def linearise(self, positions: np.ndarray, frames: np.ndarray, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6) = ∂(v, ω)_i/∂(u, φ)_{i+m−w}."""
        blocks[:] = 0.0
        self._effect.add_jacobian(positions, frames, blocks)
        self._blocks = blocks

    def add_product(self, poses: np.ndarray, twists: np.ndarray) -> None:
        """twists += their change with ``poses`` (N, 6), about the last linearisation."""
        add_block_product(self._blocks, poses, self.period > 0.0, twists)
