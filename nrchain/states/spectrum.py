"""Λ of J about a state: growth, modes, sensitivities and transient growth of a finite chain.

:func:`spectrum` finds the state first (:mod:`nrchain.states.newton`), then the eigenvalues of the
matrix of small changes in axes that go along with the chain (:mod:`nrchain.comoving.relative`). The
motions of the chain as a whole are set apart: a free chain has six, with rates 0 and, if it spins
at Ω, ±iΩ.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nrchain.comoving import dense, krylov
from nrchain.comoving.bordered import Bordered
from nrchain.comoving.motions import NAMES, TURN
from nrchain.comoving.relative import Point, RelativeChain
from nrchain.errors import SceneError
from nrchain.notebook import record_html, table_html
from nrchain.scene.loading import require_chosen
from nrchain.scene.scene import Scene
from nrchain.states import sensitivity, transient
from nrchain.states.modes import Mode, modes_of
from nrchain.states.newton import SteadyState
from nrchain.states.parameters import parameters
from nrchain.states.search import start_name, state_near
from nrchain.states.transient import Transient
from nrchain.theory.line_loads import straight_poses
from nrchain.types import Poses
from nrchain.wording import brief

DENSE = 500
"""Spheres of the longest chain of which all eigenvalues are computed."""

MODES = 10
"""Leading modes that are computed unless more are asked for."""


@dataclass(frozen=True)
class Neutral:
    """The motions of a chain as a whole that change neither its shape nor its law.

    Attributes
    ----------
    names
        The elementary motions that take part.
    rates
        (r,) their rates: 0, and ±iΩ on a chain that spins, whose axis and velocity turn.
    error
        ‖J Q − Q A‖: by how much J does not map these motions to themselves; rounding.
    """

    names: tuple[str, ...]
    rates: np.ndarray
    error: float

    __repr__ = brief
    _repr_html_ = record_html


@dataclass(frozen=True)
class Spectrum:
    """The rates and modes of small changes of a state.

    Attributes
    ----------
    scene, state
        The scene, and the state that was found.
    modes
        Leading modes, from the fastest growth on; of a pair Λ, Λ* the one with Im Λ > 0.
    neutral
        The motions of the chain as a whole, which are no modes of its shape.
    rates
        Eigenvalues of the shape, from the largest real part on: all of them if ``is_whole``.
    is_whole
        Whether all eigenvalues were computed. If not, these are the ones near the two axes.
    abscissa
        ω(J), the largest growth rate of the norm of a small change. That of near neighbours alone
        for more than :data:`DENSE` spheres with interactions of all pairs.

    >>> from nrchain import load_scene, spectrum
    >>> found = spectrum(load_scene("buckling", **{"slip.2s": 100.0}))
    >>> found.is_stable, bool(found.leading.growth > 0.0)
    (False, True)
    """

    scene: Scene
    state: SteadyState
    modes: tuple[Mode, ...]
    neutral: Neutral
    rates: np.ndarray
    is_whole: bool
    abscissa: float
    is_straight: bool = field(repr=False)

    __repr__ = brief

    def _repr_html_(self) -> str:
        rows = [
            (one.growth, one.frequency, one.multiplicity, f"{one.error:.1e}") for one in self.modes
        ]
        what = "stable" if self.is_stable else f"leading growth {self.leading.growth:.6g}"
        title = f"Leading modes of {len(self.rates)}: {what}"
        return table_html(title, rows, ("growth", "frequency", "modes", "error"))

    @property
    def leading(self) -> Mode:
        """The mode of fastest growth."""
        return self.modes[0]

    @property
    def is_stable(self) -> bool:
        """Whether all modes of the shape decay, by more than the error of their rates."""
        return all(mode.growth < -mode.error for mode in self.modes)

    def sensitivities(
        self, mode: Mode | None = None, keys: Collection[str] | None = None
    ) -> dict[str, complex]:
        """dΛ/dp of a mode, by default the leading one, with each number p of the scene.

        ``keys`` chooses among the numbers; ``slip.2s[3]`` is the strength of sphere 3 in a list.
        Held spheres of a straight chain stay (N − 1) d apart; those of given poses keep their
        places. The poses of a periodic chain stretch with its period.
        """
        chosen = self.leading if mode is None else mode
        numbers = {one.key: one for one in parameters(self.scene)}
        for key in keys or ():
            if key not in numbers:
                raise SceneError("keys", key, f"must be among {', '.join(numbers)}")
        if not np.isfinite(chosen.condition):
            allowed = f"must be at most {DENSE} for left modes with interactions of all pairs"
            raise SceneError("chain.particles", self.scene.chain.particles, allowed)
        point = self.point()
        factors = Bordered(point, by_products=True)
        return {
            one.key: sensitivity.derivative(point, factors, chosen, one, self._carried)
            for one in numbers.values()
            if keys is None or one.key in keys
        }

    def transient_growth(self) -> Transient | None:
        """max_t ‖exp(J t)‖ over changes of shape; None where the matrix is too large."""
        return transient.transient_growth(self.point(), self.leading.growth, self.abscissa)

    def point(self) -> Point:
        """The state with its matrix J."""
        return RelativeChain(self.scene, self.state.poses).at(self.state.poses)

    def _carried(self, scene: Scene) -> Poses:
        """The poses of the state for a scene with another number."""
        positions, frames = self.state.poses
        positions = positions.copy()
        if self.is_straight:
            positions += straight_poses(scene)[0] - straight_poses(self.scene)[0]
        elif scene.period != self.scene.period:
            positions[:, 0] *= scene.period / self.scene.period
        return positions, frames


def spectrum(scene: Scene, at: Any = None, modes: int = MODES) -> Spectrum:
    """Λ, x and ℓ with J x = Λ x of small changes of a state of rest or of steady motion.

    Parameters
    ----------
    scene
        Any ends, effects and strengths, without ``effects = "auto"``.
    at
        Poses near the state: ``(positions, frames)``, or a trajectory, whose last snapshot is
        taken. By default the straight chain. Newton's method goes from there to the state itself.
    modes
        Number of leading eigenvalues whose modes are computed.

    Raises :class:`~nrchain.errors.SceneError` if no state is near these poses, with the velocity
    that is left, and the flow or field that forbids one.

    >>> from nrchain import load_scene
    >>> found = spectrum(load_scene("buckling", **{"slip.2s": 40.0}))
    >>> found.is_stable, found.leading.multiplicity
    (True, 2)
    """
    require_states(scene)
    try:
        with np.errstate(all="ignore"):
            return spectrum_about(scene, state_near(scene, at), at is None, modes)
    except (FloatingPointError, np.linalg.LinAlgError) as error:
        raise SceneError("at", start_name(at), f"has no spectrum: {error}") from None


def require_states(scene: Scene) -> None:
    """Refuse a scene whose effects are still to be chosen, or that has no sphere free to move."""
    require_chosen(scene)
    if scene.chain.ends == "clamped" and scene.chain.particles == 2:
        raise SceneError("chain.particles", 2, "leaves no sphere free to move between clamps")


def spectrum_about(scene: Scene, state: SteadyState, is_straight: bool, modes: int) -> Spectrum:
    """The spectrum of a state that has been found."""
    point = RelativeChain(scene, state.poses).at(state.poses)
    is_whole = scene.chain.particles <= DENSE
    if is_whole:
        abscissa = transient.numerical_abscissa(dense.shape_matrix(point))
        rates = dense.all_rates(point)
    else:
        abscissa = krylov.numerical_abscissa(point)
        rates = krylov.leading_rates(point, modes, abscissa)
    return Spectrum(
        scene=scene,
        state=state,
        modes=modes_of(point, rates, modes),
        neutral=_neutral(point),
        rates=rates,
        is_whole=is_whole,
        abscissa=abscissa,
        is_straight=is_straight,
    )


def _neutral(point: Point) -> Neutral:
    """The motions as a whole, with the matrix A of J Q = Q A."""
    basis = point.neutral
    image = point.product(basis) if basis.shape[1] else np.zeros_like(basis)
    own = basis.T @ image
    allowed = point.chain.allowed
    taking_part = np.abs(allowed).max(axis=1, initial=0.0) > 0.0
    # on a straight chain the turn about e₁ is a rotation of the whole
    taking_part[TURN] &= basis.shape[1] == allowed.shape[1]
    if not basis.shape[1]:
        taking_part[:] = False
    names = tuple(name for name, part in zip(NAMES, taking_part, strict=True) if part)
    error = float(np.abs(image - basis @ own).max(initial=0.0))
    return Neutral(names, dense.in_order(np.linalg.eigvals(own).astype(complex)), error)
