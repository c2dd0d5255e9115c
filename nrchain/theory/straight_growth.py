"""J (u, φ) = λ (u, φ): growth rates λ of a finite chain about its straight state.

J is the derivative of the twists with the poses, about the straight state of the chain
(:mod:`nrchain.theory.straight_state`), in axes that spin with it. Motion along the chain (u_x, φ_x)
and across it decouple. For an isotropic chain u_y + i u_z and φ_y + i φ_z are two complex numbers
for each sphere, and the matrix has half the size.

Up to :data:`DENSE` spheres all eigenvalues are computed. For longer chains those nearest to a set
of real rates are computed, from one e-fold over the run to the fastest rate between neighbours. A
long chain whose flows act over all pairs is replaced by one with one-body friction and slip over
:data:`REACH` neighbours, about the straight state of that chain: a cut of J alone would leave
unbalanced tensions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nrchain.motion.model import Model
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.theory.line_loads import from_blocks, without_links
from nrchain.theory.straight_state import StraightState, straight_state

DENSE = 100
"""Largest number of spheres for which all eigenvalues are computed: about 0.1 s."""

NEAREST, APART = 4, 8.0
"""For longer chains: eigenvalues computed near each rate, and the factor between rates."""

REACH = 8
"""Neighbours over which the slip of a long chain acts in its growth rates."""

TRIED = 12
"""Growing modes that are tested to find one that is not a rigid motion."""

RIGID = 1e-3
"""A mode is a rigid motion if less than this fraction of it is anything else."""

LARGEST = 1e100
"""Larger derivatives leave the range of floats in eigenvalue routines."""

TINY = float(np.finfo(float).tiny)

ISOTROPIC = 1e-10
"""Largest anisotropy of J across the chain, relative to its largest entry, due to rounding."""

_ALONG, _ACROSS = (0, 3), (1, 4, 2, 5)


@dataclass(frozen=True)
class Mode:
    """Re λ of the fastest mode, 0 if none grows, with its shear and phase.

    ``shear`` is the largest angle between a link and e₁ over the largest turn of a sphere: 0 in a
    mode that bends, 1 or more in one that shears. ``phase`` is the root mean square turn from
    sphere to sphere over that of the spheres, qd of a wave. Both are 0 along the chain.
    """

    rate: float = 0.0
    shear: float = 0.0
    phase: float = 0.0


@dataclass(frozen=True)
class StraightGrowth:
    """The fastest modes along and across a chain; ``whole`` is False if its flows were cut."""

    along: Mode
    across: Mode
    whole: bool


def straight_growth(scene: Scene, state: StraightState) -> StraightGrowth:
    """The modes along and across a chain that grow fastest about its straight state."""
    model = Model(scene)
    free = np.flatnonzero(~model.held)
    whole = model.is_banded or model.count <= DENSE
    if not len(free):
        return StraightGrowth(Mode(), Mode(), whole)
    near = _cut(scene)
    if not whole and near != scene:
        return replace(straight_growth(near, straight_state(near)), whole=False)
    jacobian = _jacobian(model, state, whole)
    rates = 1.0 / scene.run.end, _fastest_of_neighbours(scene, state)
    along = _components(jacobian, free, _ALONG)
    across = _components(jacobian, free, _ACROSS)
    reduced = _isotropic(across)
    across = across if reduced is None else reduced
    places = state.positions[free, 0]
    found = (
        _fastest(along, rates, _along),
        _fastest(across, rates, lambda shape: _across(shape, places)),
    )
    return StraightGrowth(*found, whole)


def _cut(scene: Scene) -> Scene:
    """The scene with one-body friction and slip of ``REACH`` places at most."""
    reach = scene.slip.neighbours
    reach = REACH if reach == "all" else min(reach, REACH)
    return load_scene(scene, friction="one-body", **{"slip.neighbours": reach})


def _jacobian(model: Model, state: StraightState, whole: bool) -> Any:
    """J (6N, 6N), sparse, or with all pairs in it; in axes that spin with the chain."""
    blocks = np.empty((model.count, 2 * model.reach + 1, 6, 6))
    model.linearise(state.positions, state.frames, blocks)
    spin = 0.0 if model.held.any() else float(state.twists[:, 3].mean())
    own = np.zeros((model.count, 1, 6, 6))
    own[:, 0, 1, 2], own[:, 0, 2, 1] = spin, -spin
    periodic = model.period > 0.0
    near = from_blocks(blocks, periodic=periodic)
    if whole and not model.is_banded:
        near = np.empty(near.shape).T
        for unit, column in zip(np.eye(len(near)), near.T, strict=True):
            twists = np.zeros((model.count, 6))
            model.add_product(unit.reshape(-1, 6), twists)
            column[:] = twists.ravel()
    if not abs(near).max() < LARGEST:
        raise FloatingPointError("the derivatives are too large to compute eigenvalues")
    return near + from_blocks(own, periodic=periodic)


def _fastest_of_neighbours(scene: Scene, state: StraightState) -> float:
    """max Σ |∂v| of neighbours without springs: a bound on the rates."""
    model = Model(without_links(scene))
    blocks = np.empty((model.count, 2 * model.reach + 1, 6, 6))
    model.linearise(state.positions, state.frames, blocks)
    return float(np.abs(blocks).sum(axis=(1, 3)).max())


def _components(jacobian: Any, free: np.ndarray, parts: tuple[int, ...]) -> Any:
    """J of these components of the free spheres, component by component."""
    kept = np.concatenate([6 * free + part for part in parts])
    return jacobian[kept][:, kept]


def _isotropic(matrix: Any) -> Any:
    """A − iB of [[A, B], [−B, A]], for u_y + i u_z and φ_y + i φ_z; None if it has no such form."""
    half = matrix.shape[0] // 2
    a, b = matrix[:half, :half], matrix[:half, half:]
    c, d = matrix[half:, :half], matrix[half:, half:]
    if max(abs(a - d).max(), abs(b + c).max()) > ISOTROPIC * abs(matrix).max():
        return None
    return a - 1j * b


def _fastest(
    matrix: Any, rates: tuple[float, float], read: Callable[[np.ndarray], Mode | None]
) -> Mode:
    """The growing mode of largest Re λ that ``read`` accepts."""
    candidates = _all_modes if matrix.shape[0] <= 4 * DENSE else _nearest_modes
    for value, shape in candidates(matrix, *rates):
        if value.real <= 0.0:
            break
        mode = read(shape)
        if mode is not None:
            return replace(mode, rate=float(value.real))
    return Mode()


def _all_modes(matrix: Any, least: float, fast: float) -> Iterator[tuple[complex, np.ndarray]]:
    """Eigenvalues from the largest real part on, each with its vector by inverse iteration."""
    from scipy.linalg import eigvals, lu_factor, lu_solve

    matrix = matrix.toarray() if hasattr(matrix, "toarray") else matrix
    values = eigvals(matrix)
    size = max(float(np.abs(matrix).max()), TINY)
    for value in values[np.argsort(-values.real, kind="stable")][:TRIED]:
        # off the eigenvalue by more than rounding, so that the factors exist
        shift = value + 1e-10 * size
        factors = lu_factor(matrix - shift * np.eye(len(matrix)))
        shape = np.cos(np.arange(len(matrix)) + 1.0).astype(complex)
        for _ in range(3):
            shape = lu_solve(factors, shape)
            shape /= np.abs(shape).max()
        yield complex(value), shape


def _nearest_modes(matrix: Any, least: float, fast: float) -> Iterator[tuple[complex, np.ndarray]]:
    """Those nearest to rates from ``least`` to ``fast``, from the largest real part on."""
    from scipy.sparse.linalg import ArpackNoConvergence, eigs

    matrix = matrix.tocsc()
    begin = np.cos(np.arange(matrix.shape[0]) + 1.0).astype(matrix.dtype)
    number = 1 + max(math.ceil(math.log(max(fast / least, 1.0)) / math.log(APART)), 1)
    found: list[tuple[complex, np.ndarray]] = []
    for rate in np.geomspace(least, max(fast, 2.0 * least), number):
        try:
            values, shapes = eigs(matrix, NEAREST, sigma=rate, v0=begin, tol=1e-3, maxiter=15)
        except ArpackNoConvergence as short:
            values, shapes = short.eigenvalues, short.eigenvectors
        except RuntimeError as error:
            # no factors about this rate, or none of ARPACK's vectors grows out of them
            raise FloatingPointError(f"rates about {rate:.3g} are not found: {error}") from None
        found += zip(map(complex, values), shapes.T, strict=True)
    yield from sorted(found, key=lambda pair: -pair[0].real)


def _along(shape: np.ndarray) -> Mode | None:
    """Of (u_x, φ_x): None for a shift or a spin of the whole chain."""
    parts = shape.reshape(2, -1)
    if parts.shape[1] < 2:
        return Mode()
    own = np.abs(parts - parts.mean(axis=1, keepdims=True)).max()
    return Mode() if own > RIGID * np.abs(parts).max() else None


def _across(shape: np.ndarray, places: np.ndarray) -> Mode | None:
    """Of displacements and slopes: None for a shift or a turn of the whole chain."""
    shifts, slopes = _shifts_and_slopes(shape.reshape(-1, len(places)))
    if len(places) < 2:
        return Mode()
    away = places - places.mean()
    turn = (shifts @ away / max(float(away @ away), TINY))[:, None]
    bent = np.abs(slopes - turn).max()
    own = np.abs(shifts - shifts.mean(axis=1, keepdims=True) - turn * away).max()
    if max(own, bent) <= RIGID * max(np.abs(shifts).max(), np.abs(slopes).max()):
        return None
    return _as_mode(shifts, slopes, places)


def _shifts_and_slopes(parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u and the slopes of e₁ (k, n), as complex numbers (k = 1) or by y and z (k = 2)."""
    if len(parts) == 2:
        return parts[:1], -1j * parts[1:]
    return parts[[0, 2]], np.stack([parts[3], -parts[1]])


def _as_mode(shifts: np.ndarray, slopes: np.ndarray, places: np.ndarray) -> Mode:
    """Shear and phase of a mode from its displacements and slopes."""
    links = np.diff(shifts, axis=1) / np.diff(places)
    sheared = np.abs(links - 0.5 * (slopes[:, 1:] + slopes[:, :-1])).max()
    turned = max(float(np.abs(slopes).max()), TINY)
    phase = math.sqrt(float((np.abs(np.diff(slopes, axis=1)) ** 2).mean())) / max(
        math.sqrt(float((np.abs(slopes) ** 2).mean())), TINY
    )
    return Mode(shear=float(sheared) / turned, phase=phase)
