"""G(X) = 0 from a guess or from a nudge: the states of rest and of steady motion of a chain.

Newton's method finds the state next to a guess, stable or not. A nudge, or a guess that is next to
no state, is followed to the state that attracts it (:mod:`nrchain.states.relaxation`), and Newton's
method ends the search.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.comoving.motions import moved
from nrchain.comoving.relative import Point, RelativeChain
from nrchain.effects.base import Effect
from nrchain.errors import SceneError
from nrchain.inputs.rules import is_number
from nrchain.notebook import table_html
from nrchain.scene.scene import Scene
from nrchain.states.newton import SteadyState, largest_change, solve
from nrchain.states.relaxation import relax
from nrchain.states.search import given_poses, refuse_out_of_reach, start_name, state_near
from nrchain.states.spectrum import MODES, Spectrum, require_states, spectrum_about
from nrchain.theory.line_loads import straight_poses
from nrchain.types import Poses
from nrchain.wording import brief

STRAIGHT = 1e-9
"""Distance of spheres from the axis, in d, at which a chain counts as straight."""


@dataclass(frozen=True)
class State:
    """A chain at rest, or one that swims, spins and screws without a change of shape.

    Attributes
    ----------
    spectrum
        Rates and modes of small changes; ``spectrum.neutral`` counts the motions of the chain as a
        whole. It holds the scene, and the steady state with the steps that it took.

    >>> from nrchain import find_state, load_scene
    >>> find_state(load_scene("buckling", **{"slip.2s": 40.0})).is_stable
    True
    """

    spectrum: Spectrum

    __repr__ = brief

    def _repr_html_(self) -> str:
        leading = self.spectrum.leading
        rows = [
            ("scene", repr(self.scene)),
            ("velocity V", self.velocity.tolist()),
            ("rotation Ω", self.rotation.tolist()),
            ("turn about e₁", self.turn),
            ("residual", f"{self.residual:.1e}"),
            ("leading growth", leading.growth),
            ("its frequency", leading.frequency),
            ("stable", str(self.spectrum.is_stable)),
        ]
        return table_html("State", rows)

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.spectrum.scene

    @property
    def positions(self) -> np.ndarray:
        """(N, 3)."""
        return self.spectrum.state.positions

    @property
    def frames(self) -> np.ndarray:
        """(N, 3, 3)."""
        return self.spectrum.state.frames

    @property
    def poses(self) -> Poses:
        """Positions and frames."""
        return self.spectrum.state.poses

    @property
    def origin(self) -> np.ndarray:
        """o (3,): the mean position of the guess, or of the held spheres."""
        return self.spectrum.state.origin

    @property
    def velocity(self) -> np.ndarray:
        """V (3,) of the point :attr:`origin`, in the lab."""
        return self.spectrum.state.motion.velocity

    @property
    def rotation(self) -> np.ndarray:
        """Ω (3,) of the chain as a whole, in the lab."""
        return self.spectrum.state.motion.rotation

    @property
    def turn(self) -> float:
        """Rate at which all spheres turn about their own axes e₁, beside Ω."""
        return self.spectrum.state.motion.turn

    @property
    def residual(self) -> float:
        """Largest velocity, or a times angular velocity, of a sphere beside that motion."""
        return self.spectrum.state.residual

    @property
    def error(self) -> float:
        """The last correction of Newton's method, in lengths and radians, of all spheres."""
        return self.spectrum.state.error

    @property
    def steps(self) -> int:
        """Steps of the search, each with one factorisation."""
        return self.spectrum.state.steps

    @property
    def is_stable(self) -> bool:
        """Whether all modes of the shape decay, by more than the error of their rates."""
        return self.spectrum.is_stable


def find_state(scene: Scene, guess: Any = None, *, nudge: float = 0.0, modes: int = MODES) -> State:
    """X, V and Ω with w(X) = (V + Ω × (r − o), Ω + s e₁): a state of rest or of steady motion.

    Parameters
    ----------
    scene
        Any ends and effects that allow a state, without ``effects = "auto"``.
    guess
        ``(positions, frames)``, a trajectory, whose last snapshot is taken, or another state. By
        default the straight chain.
    nudge
        Largest displacement, in radii, or rotation, in radians, by which the chain leaves the state
        of the guess along its fastest mode. The state that attracts it from there is found. A
        negative nudge goes the other way.
    modes
        Number of leading eigenvalues of its spectrum.

    Raises :class:`~nrchain.errors.SceneError` if no state is found, with the velocities that are
    left and the field or flow that forbids one.

    >>> from nrchain import load_scene
    >>> bent = find_state(load_scene("buckling", **{"slip.2s": 60.0}), nudge=0.1)
    >>> bent.is_stable, bool(abs(bent.positions[:, 1:]).max() > 5.0)
    (True, True)
    """
    require_states(scene)
    if not is_number(nudge):
        raise SceneError("nudge", nudge, "must be a finite number of radii")
    try:
        with np.errstate(all="ignore"):
            found = _search(scene, guess, nudge)
            refuse_out_of_reach(scene, found, "guess")
            is_straight = guess is None and _is_on_axis(found, scene)
            return State(spectrum_about(scene, found, is_straight, modes))
    except (FloatingPointError, np.linalg.LinAlgError) as error:
        raise SceneError("guess", start_name(guess), f"leads to no state: {error}") from None


def _search(scene: Scene, guess: Any, nudge: float) -> SteadyState:
    """The steady state of a guess, or the one that attracts it."""
    if nudge:
        return _attracting(scene, _nudged(scene, guess, nudge), guess)
    try:
        return state_near(scene, guess, "guess")
    except SceneError:
        poses = straight_poses(scene) if guess is None else given_poses(scene, guess, "guess")
        try:
            return _attracting(scene, poses, guess)
        except SceneError:
            if guess is not None:
                raise
        raise


def _nudged(scene: Scene, guess: Any, nudge: float) -> Poses:
    """The state of a guess, displaced along its fastest mode."""
    found = _search(scene, guess, 0.0)
    mode = spectrum_about(scene, found, guess is None, modes=1).leading.right[0]
    part = mode.real if np.abs(mode.real).max() >= np.abs(mode.imag).max() else mode.imag
    radius = scene.chain.radius
    sizes = np.linalg.norm(part.reshape(-1, 2, 3), axis=2) / [radius, 1.0]
    return moved(*found.poses, nudge / sizes.max() * part)


def _attracting(scene: Scene, poses: Poses, guess: Any) -> SteadyState:
    """The state that attracts a chain at these poses."""
    begin = RelativeChain(scene, poses).at(poses)
    relaxed, steps, settled = relax(begin)
    point, size, more, found = solve(relaxed)
    if not found or largest_change(relaxed, _difference(relaxed, point)) > scene.chain.spacing:
        if not settled:
            raise _lost(begin, relaxed, guess, steps)
        # a mode that hardly decays leaves Newton's method without an answer
        point, more, found = relaxed, 0, True
    return SteadyState(
        point.positions,
        point.frames,
        point.motion,
        point.chain.origin,
        point.largest,
        size,
        steps + more,
        found,
    )


def _is_on_axis(found: SteadyState, scene: Scene) -> bool:
    """Whether all spheres lie on the axis of the straight chain."""
    return bool(np.abs(found.positions[:, 1:]).max() <= STRAIGHT * scene.chain.spacing)


def _difference(before: Point, after: Point) -> np.ndarray:
    """Displacements (n,) from one point to another, without rotations."""
    poses = np.zeros((len(before.positions), 6))
    poses[:, :3] = after.positions - before.positions
    return before.chain.coordinates(poses)


def _lost(begin: Point, end: Point, guess: Any, steps: int) -> SceneError:
    """The error of a search that has found no state."""
    scene = begin.chain.scene
    left = (
        f"velocities of the spheres relative to each other are {begin.largest:.3g} at the start and"
        f" {end.largest:.3g} after {steps} steps"
    )
    forbids = _not_covariant(begin.chain.model.further_effects)
    if forbids is not None:
        allowed = f"allows no state of steady motion that is found from here: {left}"
        return SceneError(forbids.key, forbids.value(scene), allowed)
    remedy = (
        "the chain may oscillate, touch itself or drift slowly: simulate it, and give the end of"
        " the run as guess"
    )
    return SceneError("guess", start_name(guess), f"leads to no state: {left}; {remedy}")


def _not_covariant(effects: tuple[Effect, ...]) -> Effect | None:
    """The first effect that does not move and rotate with the chain."""
    return next((effect for effect in effects if not effect.covariant), None)
