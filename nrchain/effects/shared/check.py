"""∂(F, T)/∂(u, φ) against differences, rigid motion, energy: the self-check of an effect."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from nrchain.effects.base import Effect
from nrchain.effects.registry import acting, effects
from nrchain.effects.shared.check_poses import WatchedEffect, bent_poses, given_poses, moved_poses
from nrchain.errors import NOT_GIVEN, SceneError, Words
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.types import Poses

STEP = 1e-5
"""Step of the finite differences, in radii and radians."""

DERIVATIVE, EXACT = 1e-6, 1e-10
"""Largest errors allowed, relative to the largest entry: against finite differences, and between
two evaluations of the same number."""

PLAIN: Mapping[str, Any] = {
    "chain": {"particles": 6, "spacing": 4.0},
    "elasticity": {"stretch": 3.0, "shear": 5.0, "twist": 7.0, "bend": 11.0},
    "run.end": 1.0,
}
"""The default chain for the check of an effect."""

_NAMES = ("x", "y", "z")


def check_effect(
    effect: type[Effect],
    scene: Scene | Mapping[str, Any] | None = None,
    *,
    positions: np.ndarray | None = None,
    frames: np.ndarray | None = None,
) -> dict[str, float]:
    """Check derivative, energy, covariance and balance of an effect on a bent and twisted chain.

    Parameters
    ----------
    scene
        A scene in which the effect acts, or changes to a chain of six spheres that switch it on;
        default: its ``example``.
    positions, frames
        (N, 3) and (N, 3, 3): poses for the check; default: random ones about the straight chain.
        Positions of a periodic chain may be wrapped (:func:`nrchain.scene.unwrapping.unwrapped`).

    Returns
    -------
    dict
        The error of each check relative to the largest number in it: ``"product"`` and
        ``"blocks"``, the derivative against centred differences; ``"energy"``, wrenches against
        −∂V/∂(u, φ); ``"rigid motion"`` and ``"shift"``, the change when the whole chain is moved
        and rotated, or only moved; ``"net force"`` and ``"torque"``, if these must vanish. Checks
        that do not apply are left out.

    Raises
    ------
    SceneError
        For the first check that fails, with the sphere and the component; for a method that raises
        or changes the given poses, with its name; for an effect that is not registered, does not
        act in the scene, or exerts nothing at the poses.

    >>> from nrchain import load_scene
    >>> from nrchain.effects.field import Field
    >>> scene = load_scene("passive", **{"chain.particles": 4, "field.force": [0.0, 0.0, 1.0]})
    >>> all(error < 1e-6 for error in check_effect(Field, scene).values())
    True
    """
    if effect not in effects():
        raise SceneError("effect", effect, "must be registered first, with register_effect")
    what = _scene(effect, scene)
    if (positions is None) != (frames is None):
        missing = "positions" if positions is None else "frames"
        raise SceneError(missing, NOT_GIVEN, "positions and frames must be given together")
    poses = bent_poses(what) if positions is None else given_poses(what, positions, frames)
    check = _Check(effect, what, poses)
    return check.derivative() | check.energy() | check.motions() | check.balance()


def _scene(effect: type[Effect], given: Scene | Mapping[str, Any] | None) -> Scene:
    if not isinstance(given, Scene):
        given = effect.example if given is None else given
        plain = load_scene(PLAIN)
        given = load_scene(plain, **given)
    if effect not in acting(given):
        allowed = "must be a scene, or changes to one, in which the effect acts: give it an example"
        raise SceneError(f"effect {effect.name}: scene", given.to_mapping(), allowed)
    return given


class _Check:
    """One effect of a scene at one set of poses; twists and derivatives in units of radii."""

    def __init__(self, effect: type[Effect], scene: Scene, poses: Poses) -> None:
        self.kind, self.poses, self.scene = effect, poses, scene
        self.effect = WatchedEffect(effect(scene), effect.name)
        self.count, radius = len(poses[0]), scene.chain.radius
        power = -1.0 if effect.gives == "wrench" else 1.0
        self.rows = np.repeat([1.0, radius**power], 3)
        self.columns = np.repeat([radius, 1.0], 3)

    def result(self, poses: Poses) -> np.ndarray:
        out = np.zeros((self.count, 6))
        add = self.effect.add_wrenches if self.kind.gives == "wrench" else self.effect.add_twists
        add(*poses, out)
        return out * self.rows

    def differences(self, function: Callable[[Poses], Any]) -> np.ndarray:
        """∂/∂(u/a, φ) by centred differences: shape of the function + (N, 6)."""
        found = []
        for sphere in range(self.count):
            for component in range(6):
                step = STEP * self.columns[component]
                ahead, behind = (
                    function(moved_poses(self.poses, sphere, component, sign * step))
                    for sign in (1.0, -1.0)
                )
                found.append((np.asarray(ahead) - np.asarray(behind)) / (2.0 * STEP))
        stacked = np.stack(found, axis=-1)
        return stacked.reshape(*stacked.shape[:-1], self.count, 6)

    def derivative(self) -> dict[str, float]:
        if self.kind.gives == "mobility":
            return {}
        if not self.result(self.poses).any():
            allowed = (
                f"effect {self.kind.name} exerts nothing there, so that there is nothing to check: "
                "give positions and frames, or a scene, at which it does"
            )
            raise SceneError("positions", Words("those of the check"), allowed)
        numeric = self.differences(self.result)
        self.effect.linearise(*self.poses)
        self.result(moved_poses(self.poses, 0, 1, 0.1 * self.scene.chain.radius))
        given = np.zeros((self.count, 6, self.count, 6))
        for sphere in range(self.count):
            for component in range(6):
                moves, out = np.zeros((2, self.count, 6))
                moves[sphere, component] = self.columns[component]
                self.effect.add_product(moves, out)
                given[:, :, sphere, component] = out * self.rows
        found = {"product": self._compare("add_product", given, numeric)}
        if self.effect.places is not None:
            found["blocks"] = self._compare("add_blocks", self._blocks(), numeric)
        return found

    def _blocks(self) -> np.ndarray:
        width = self.effect.places or 0
        blocks = np.zeros((self.count, 2 * width + 1, 6, 6))
        self.effect.add_blocks(blocks)
        whole = np.zeros((self.count, 6, self.count, 6))
        for i in range(self.count):
            for m in range(-width, width + 1):
                if self.scene.chain.ends == "periodic" or 0 <= i + m < self.count:
                    whole[i, :, (i + m) % self.count] += blocks[i, width + m]
        return whole * self.rows[:, None, None] * self.columns

    def energy(self) -> dict[str, float]:
        if self.effect.energy is None:
            return {}
        slope = -self.differences(lambda poses: self.effect.energy(*poses))
        given = self.result(self.poses) * self.scene.chain.radius
        return {"energy": self._compare("energy", given, slope)}

    def motions(self) -> dict[str, float]:
        if self.kind.gives == "mobility":
            return {}
        from scipy.spatial.transform import Rotation

        # a chain that repeats along x can only be turned about that
        axis = [0.9, 0.0, 0.0] if self.scene.chain.ends == "periodic" else [0.3, -0.7, 0.5]
        turn = Rotation.from_rotvec(axis).as_matrix()
        shift = self.scene.chain.spacing * np.array([4.0, -2.0, 8.0])
        positions, frames = self.poses
        here = self.result(self.poses)
        there = self.result((positions @ turn.T + shift, np.ascontiguousarray(frames @ turn.T)))
        turned = np.concatenate([here[:, :3] @ turn.T, here[:, 3:] @ turn.T], axis=1)
        found = {}
        if self.kind.covariant:
            found["rigid motion"] = self._compare("covariant", there, turned, EXACT)
        if not self.kind.placed:
            moved = self.result((positions + shift, frames))
            found["shift"] = self._compare("placed", moved, here, EXACT)
        return found

    def balance(self) -> dict[str, float]:
        if self.kind.gives != "wrench":
            return {}
        here, found = self.result(self.poses), {}
        if self.kind.balanced(self.scene):
            forces = here[:, :3]
            largest = float(np.abs(forces).max())
            error = self._compare("balanced", forces.sum(axis=0), np.zeros(3), EXACT, largest)
            found["net force"] = error
        if self.kind.torque_free:
            alone = here * [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
            found["torque"] = self._compare("torque_free", here, alone, EXACT)
        return found

    def _compare(
        self,
        name: str,
        given: np.ndarray,
        expected: np.ndarray,
        allowed: float = DERIVATIVE,
        largest: float = 0.0,
    ) -> float:
        """The largest error over the largest number, refused if it is more than ``allowed``."""
        errors = np.nan_to_num(np.abs(given - expected), nan=np.inf)
        error = float(errors.max()) / (max(float(np.abs(expected).max()), largest) or 1.0)
        if not error <= allowed:
            where = np.unravel_index(int(np.argmax(errors)), errors.shape)
            raise SceneError(
                f"effect {self.kind.name}.{name}",
                float(given[where]),
                f"does not hold: {_STATEMENTS[name]} gives {expected[where]:.6g} for "
                f"{_place(self.kind.gives, where)} (lengths in radii), "
                f"off by {error:.2g} of the largest",
            )
        return error


_STATEMENTS = {
    "add_product": "its derivative by differences",
    "add_blocks": "its derivative by differences",
    "energy": "minus the slope of its energy, by differences,",
    "covariant": "a chain moved and turned as a whole",
    "placed": "the same chain elsewhere in the lab",
    "balanced": "the sum of forces that are balanced",
    "torque_free": "a force alone",
}


def _place(gives: str, where: tuple[Any, ...]) -> str:
    letters = "FT" if gives == "wrench" else "vω"
    if len(where) == 1:
        return f"the net force along {_NAMES[where[0]]}"
    of = f"{letters[where[1] // 3]}_{_NAMES[where[1] % 3]} of sphere {where[0]}"
    if len(where) == 2:
        return of
    by = f"{'uφ'[where[3] // 3]}_{_NAMES[where[3] % 3]} of sphere {where[2]}"
    return f"{of} with {by}"
