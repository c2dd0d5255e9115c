"""g_i = (V + Ω × (r_i − o), Ω + s e₁): motions of a chain as a whole that leave its law as it is.

A chain in an unbounded fluid at rest may be translated and rotated as a whole: its twists follow.
If its elasticity is transversely isotropic and its slip is axial, all spheres may also turn about
their own axes e₁ by one angle. Every such motion is a neutral direction of every state, and a
steady motion of a chain is along them. Periodic images leave translations and the rotation about x.
Of the motions of a clamped chain only those remain that do not move the held spheres: a rotation
about the axis through both clamps with the opposite turn of the frames. Fields and flows leave
those that they are not changed by, which is found by differentiating them along each motion. A
uniform force moves all spheres of a free chain alike, if each has friction by itself: it changes
the velocity of the chain and nothing else, and rotations remain.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrchain.effects.base import Effect
from nrchain.geometry import lie
from nrchain.hydrodynamics.slip import E1
from nrchain.motion.model import Model
from nrchain.scene.scene import Scene
from nrchain.types import Poses

NAMES = (
    "translation along x",
    "translation along y",
    "translation along z",
    "rotation about x",
    "rotation about y",
    "rotation about z",
    "turn about e₁",
)
"""The elementary motions, in the order of :class:`Motion` and of :func:`fields`."""

TURN = 6
"""Place of the turn of all spheres about their own axes e₁."""

INDEPENDENT = 1e-6
"""A motion is independent of others if more than this fraction of it is not along them."""

UNCHANGED = 1e-7
"""An effect follows a motion if the difference is below this fraction of its change."""


SPANS = 1e-9
"""A direction is spanned if more than this fraction of the longest is along it."""


class Motion(NamedTuple):
    """V (3,), Ω (3,) and s: velocity of the point o, angular velocity, and turn about e₁."""

    velocity: np.ndarray
    rotation: np.ndarray
    turn: float


def fields(
    positions: np.ndarray, frames: np.ndarray, origin: np.ndarray, length: float
) -> np.ndarray:
    """(7, N, 6): the twists of every sphere in each elementary motion.

    A translation has the velocity of one ``length`` per unit of time, so that all seven have the
    same units.
    """
    out = np.zeros((7, len(positions), 6))
    away = positions - origin
    for k, unit in enumerate(np.eye(3)):
        out[k, :, k] = length
        out[3 + k, :, :3] = np.cross(unit, away)
        out[3 + k, :, 3 + k] = 1.0
    out[TURN, :, 3:] = frames[:, 0]
    return out


def allowed_motions(
    scene: Scene,
    model: Model,
    poses: Poses,
    origin: np.ndarray,
    length: float,
) -> np.ndarray:
    """(7, k): the combinations of elementary motions under which twists go along with the chain."""
    combinations = np.eye(7)
    kept = [k for k in range(7) if k not in _broken(scene)]
    combinations = combinations[:, kept]
    units = np.repeat([1.0, length], 3)
    held = fields(*poses, origin, length)[:, model.held] * units
    combinations = _vanishing(combinations, held.reshape(7, -1).T, 1e-9)
    nearby = _nearby(scene, model, *poses)
    defects = [_defect(effect, nearby, origin, length) for effect in model.further_effects]
    followed = combinations
    for defect in defects:
        followed = _vanishing(followed, defect, UNCHANGED)
    if np.linalg.matrix_rank(followed[:3]) < 3:
        return followed
    for effect, defect in zip(model.further_effects, defects, strict=True):
        if effect.gives == "twist" or model.friction is None:
            defect = _beside_translation(defect)
        combinations = _vanishing(combinations, defect, UNCHANGED)
    return combinations


def _broken(scene: Scene) -> set[int]:
    """Places of the motions that elasticity, slip or periodic images do not follow."""
    broken = {4, 5} if scene.chain.ends == "periodic" else set()
    moduli, axes = scene.moduli, [slip.axis for slip in scene.slip.modes.values()]
    axial = all(axis[1:] == E1[1:] for axis in axes)
    if not axial or (scene.elasticity.measure == "paper" and (moduli.twist or moduli.bend)):
        broken.add(TURN)
    return broken


def _vanishing(combinations: np.ndarray, rows: np.ndarray, tolerance: float) -> np.ndarray:
    """The combinations (7, k) whose image under ``rows`` (m, 7) vanishes."""
    if not rows.size or not combinations.size:
        return combinations
    image = rows @ combinations
    scale = np.abs(image).max()
    if not scale:
        return combinations
    _, sizes, directions = np.linalg.svd(image, full_matrices=True)
    sizes = np.append(sizes, np.zeros(len(directions) - len(sizes)))
    found = combinations @ directions[sizes <= tolerance * sizes[0]].T
    found[np.abs(found) < 1e-12] = 0.0
    return found


def _nearby(
    scene: Scene, model: Model, positions: np.ndarray, frames: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Poses without symmetry, near the given ones."""
    generator = np.random.default_rng(1)
    away, turns = generator.uniform(-0.1, 0.1, (2, len(positions), 3))
    away[model.held] = turns[model.held] = 0.0
    poses = np.hstack([scene.chain.radius * away, turns])
    return moved(positions, frames, poses)


def _defect(effect: Effect, poses: Poses, origin: np.ndarray, length: float) -> np.ndarray:
    """(6N, 7): change of an effect along each motion, less the change by which it would follow."""
    shape = len(poses[0]), 6
    values, columns = np.zeros(shape), []
    is_wrench = effect.gives == "wrench"
    units = np.repeat([1.0, 1.0 / length if is_wrench else length], 3)
    (effect.add_wrenches if is_wrench else effect.add_twists)(*poses, values)
    effect.linearise(*poses)
    for k, field in enumerate(fields(*poses, origin, length)):
        change = np.zeros(shape)
        effect.add_product(field, change)
        if 3 <= k < TURN:
            unit = np.eye(3)[k - 3]
            change[:, :3] -= np.cross(unit, values[:, :3])
            change[:, 3:] -= np.cross(unit, values[:, 3:])
        columns.append((change * units).ravel())
    size = max(float(np.abs(values * units).max(initial=0.0)), 1e-300)
    defect = np.stack(columns, axis=1)
    # what is rounding beside the effect itself is no defect
    defect[np.abs(defect) < UNCHANGED * size] = 0.0
    return defect


def _beside_translation(defect: np.ndarray) -> np.ndarray:
    """(6N, 7): a defect without the force or velocity that it gives to all spheres alike."""
    parts = defect.reshape(-1, 6, 7).copy()
    parts[:, :3] -= parts[:, :3].mean(axis=0)
    size = max(float(np.abs(defect).max(initial=0.0)), 1e-300)
    parts[np.abs(parts) < UNCHANGED * size] = 0.0
    return parts.reshape(defect.shape)


def span(rows: np.ndarray) -> np.ndarray:
    """(k, 3) orthonormal: the directions that the columns of rows (3, m) span."""
    if not rows.size:
        return np.empty((0, 3))
    left, sizes, _ = np.linalg.svd(rows)
    return left[:, : int((sizes > SPANS * max(float(sizes.max()), 1e-300)).sum())].T


def moved(
    positions: np.ndarray, frames: np.ndarray, poses: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(r + u, cay(φ) R): poses displaced and rotated in the lab by ``poses`` (N, 6)."""
    rotation, turned = np.empty((3, 3)), np.empty_like(frames)
    for i, theta in enumerate(np.ascontiguousarray(poses[:, 3:])):
        lie.cayley(theta, rotation)
        turned[i] = frames[i] @ rotation.T
    return positions + poses[:, :3], turned
