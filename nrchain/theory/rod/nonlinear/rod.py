"""Γ·(V, Ω) = ((F, M)′ + (0, r′ × F) + (f, m)): the overdamped, geometrically exact rod, in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nrchain.errors import NrchainError, SceneError
from nrchain.inputs.arguments import finite_array, rotations
from nrchain.inputs.rules import choice
from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators.base import IntegrationError
from nrchain.motion.integrators.radau import Radau
from nrchain.notebook import record_html
from nrchain.scene.chain_sections import Ends
from nrchain.theory.rod.helix import Helix
from nrchain.theory.rod.material import Material
from nrchain.theory.rod.nonlinear.elements import Elements
from nrchain.theory.rod.nonlinear.model import RodModel
from nrchain.types import Poses
from nrchain.wording import brief

CLOSED_ELEMENTS = 3
"""Fewest elements of a periodic rod: one couples to both neighbours."""

MOST_STEPS = 200_000


class RodError(NrchainError):
    """A rod cannot be followed to the end of its times."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Poses of a rod at times.

    Attributes
    ----------
    times
        (T,).
    positions, frames
        (T, N, 3), and (T, N, 3, 3) with rows e_a, of the nodes, in the lab.
    steps, evaluations, jacobians
        How many the integrator took.
    """

    times: np.ndarray
    positions: np.ndarray
    frames: np.ndarray
    steps: int
    evaluations: int
    jacobians: int

    __repr__ = brief
    _repr_html_ = record_html


class CosseratRod:
    """The overdamped Cosserat rod of a material, between free, clamped or periodic ends.

    In the moving frame, with strains ε = Rᵀ r′ − e₁ and τ,

        Γ·(V, Ω) = (∂_s + τ ×) F + f,   and alike   (∂_s + τ ×) M + (e₁ + ε) × F + m.

    Solved in the weak form on spectral elements (:mod:`~nrchain.theory.rod.nonlinear.kernels`):
    free ends are without stress of their own accord, the energy of a passive rod cannot grow, and
    results move and rotate with the start.

    Parameters
    ----------
    material
        Stress, sources and drag.
    length
        L at rest; of a periodic rod, its period along x.
    elements, degree
        E and p: E p + 1 nodes, E p for periodic ends. More nodes in an element are more accurate
        for smooth shapes, more elements are faster.
    ends
        ``"free"``, ``"clamped"`` (both poses are held) or ``"periodic"``.
    quadratic
        Q (12, 6, 6): adds Σ Q_rab x_a x_b to (F, M, f, m) at strains x = (ε, τ).
    end_length
        Drag of the ends, as a length of rod at each free end. The spheres at the ends of a chain
        have half a spacing of their own.
    end_wrench
        (F, M) (6,) on each free end, along its own axes.

    Raises :class:`~nrchain.SceneError` for a drag that is not positive definite, and for other
    values that cannot be.

    >>> import numpy as np
    >>> from nrchain import Material, rod
    >>> stiff = dict(C_par_F_eps=1e3, C_perp_F_eps=1e3, C_par_M_tau=1.0, C_perp_M_tau=1.0)
    >>> material = Material.from_symbols(**stiff, Gamma_T=1.0, Gamma_R=0.01)
    >>> passive = rod.CosseratRod(material, length=1.0)
    >>> start = passive.bent([0, 0, 0, 0, 0, 2.0])  # an arc: τ₃ = 2
    >>> motion = passive.simulate(*start, times=[0.0, 1e-3])
    >>> motion.positions.shape
    (2, 25, 3)
    """

    def __init__(
        self,
        material: Material,
        length: float,
        *,
        elements: int = 3,
        degree: int = 8,
        ends: Ends = "free",
        quadratic: ArrayLike | None = None,
        end_length: float = 0.0,
        end_wrench: ArrayLike | None = None,
    ) -> None:
        choice(Ends)("ends", ends)
        _require_positive("length", length)
        fewest = CLOSED_ELEMENTS if ends == "periodic" else 1
        _require_count("elements", elements, fewest)
        _require_count("degree", degree, 2)
        if not 0.0 <= end_length < np.inf:
            raise SceneError("end_length", end_length, "must be at least 0")
        drag = material.drag
        if np.linalg.eigvalsh(drag + drag.T).min() <= 0.0:
            raise SceneError("drag", drag.tolist(), "must be positive definite for the rod to move")
        self.material, self.length, self.ends = material, float(length), ends
        self.elements = Elements.of(self.length, elements, degree, ends == "periodic")
        self.quadratic = (
            np.zeros((12, 6, 6))
            if quadratic is None
            else finite_array("quadratic", quadratic, (12, 6, 6))
        )
        weights, self._tips = self.elements.lumped(), np.zeros(len(self.elements.places))
        if ends == "free":
            self._tips[[0, -1]] = 1.0
        held = np.zeros(len(weights), bool)
        held[[0, -1]] = ends == "clamped"
        push = np.zeros(6) if end_wrench is None else finite_array("end_wrench", end_wrench, (6,))
        own = weights + end_length * self._tips
        self.drags = own[:, None, None] * drag
        self.model = RodModel(
            self.elements,
            held,
            _law(material, self.quadratic),
            np.linalg.inv(self.drags),
            self._tips[:, None] * push,
            own,
        )

    @property
    def places(self) -> np.ndarray:
        """s (N,) of the nodes."""
        return self.elements.places

    def bent(self, strain: ArrayLike) -> Poses:
        """Poses of uniform strain (ε, τ) (6,): a helix from the origin, along x at s = 0."""
        return Helix(finite_array("strain", strain, (6,))).poses(self.places)

    def strains(self, positions: ArrayLike, frames: ArrayLike) -> np.ndarray:
        """(ε, τ) (E, p + 1, 6) at the points of each element, along the axes there."""
        r, e = self._poses(positions, frames)
        nodes, slopes = self.elements.nodes, self.elements.slopes
        wraps = np.zeros((*nodes.shape, 3))
        if self.elements.closed:
            wraps[-1, -1, 0] = self.length
        along = np.einsum("kl,elp->ekp", slopes, r[nodes] + wraps)
        axes = e[nodes]
        turned = np.einsum("ekap,kl,elbp->ekab", axes, slopes, axes)
        found = np.empty((*nodes.shape, 6))
        found[..., :3] = np.einsum("ekap,ekp->eka", axes, along)
        found[..., 0] -= 1.0
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            found[..., 3 + a] = 0.5 * (turned[..., c, b] - turned[..., b, c])
        return found

    def integral(self, densities: np.ndarray) -> np.ndarray:
        """∫ ds of values (E, p + 1, …) at the points of each element."""
        return np.einsum("k,ek...->...", self.elements.weights, densities)

    def energy(self, positions: ArrayLike, frames: ArrayLike) -> float:
        """∫ 𝓔 ds of :meth:`Material.energy`; refused if the material is odd."""
        return float(self.integral(self.material.energy(self.strains(positions, frames))))

    def at(self, places: ArrayLike, positions: np.ndarray, frames: np.ndarray) -> Poses:
        """Poses (…, M, 3) and (…, M, 3, 3) at s (M,) from those of the nodes (…, N, 3).

        Polynomials of each element; frames are the rotations nearest to them.
        """
        s = finite_array("places", places, (None,))
        if s.size and not 0.0 <= s.min() <= s.max() <= self.length:
            raise SceneError("places", [s.min(), s.max()], f"must lie in [0, {self.length:g}]")
        matrix = self.elements.interpolation(s)
        nodes = np.einsum("mn,...np->...mp", matrix, positions)
        axes = np.einsum("mn,...nap->...map", matrix, frames)
        left, _, right = np.linalg.svd(axes)
        return nodes, left @ right

    def simulate(
        self,
        positions: ArrayLike,
        frames: ArrayLike,
        times: Sequence[float] | np.ndarray,
        *,
        rtol: float = 1e-6,
        atol: float | None = None,
    ) -> Motion:
        """The motion from poses (N, 3) and (N, 3, 3) of the nodes at the first of ``times``.

        ``rtol`` bounds the error of a step in displacements over the length and in rotations; it is
        relative to the motion in the step, with a floor of ``atol`` (default ``rtol``). Steps are
        those of Radau IIA, in the charts of :class:`nrchain.motion.charts.ChartedChain`.

        Raises :class:`~nrchain.SceneError` for bad input and ``nrchain.rod.RodError`` where steps
        fail.
        """
        r, e = self._poses(positions, frames)
        t = finite_array("times", times, (None,))
        if t.size == 0 or np.any(np.diff(t) <= 0.0):
            raise SceneError("times", t.tolist()[:3], "must be one or more, in rising order")
        for key, value in (("rtol", rtol), ("atol", rtol if atol is None else atol)):
            if not 0.0 < value < 1.0:
                raise SceneError(key, value, "must lie between 0 and 1")
        floor = rtol if atol is None else atol
        chain = ChartedChain(self.model)
        units = np.tile(np.repeat([floor * self.length, floor], 3), chain.dimension // 6)
        chain.rebase(float(t[0]), r, e)
        stepper = Radau(chain, float(t[-1]), rtol, units)
        stepper.start(float(t[0]), np.zeros(chain.dimension))
        found = [(r, e)]
        try:
            with np.errstate(all="ignore"):
                while len(found) < len(t):
                    stepper.step()
                    while len(found) < len(t) and t[len(found)] <= stepper.reached:
                        found.append(stepper.poses_at(float(t[len(found)])))
                    if stepper.steps > MOST_STEPS:
                        raise IntegrationError(f"more than {MOST_STEPS} steps")
        except IntegrationError as error:
            raise RodError(f"the rod stops at t = {stepper.reached:.6g}: {error}") from error
        return Motion(
            t,
            np.array([poses[0] for poses in found]),
            np.array([poses[1] for poses in found]),
            stepper.steps,
            chain.evaluations,
            chain.jacobians,
        )

    def _poses(self, positions: ArrayLike, frames: ArrayLike) -> Poses:
        count = len(self.places)
        return finite_array("positions", positions, (count, 3)), rotations(frames, count)


def _law(material: Material, quadratic: np.ndarray) -> np.ndarray:
    """(28, 12): coefficients of 1, of the strains and of their products in (F, M, f, m)."""
    c = material.constants
    rest = np.concatenate([c.prestress, c.presource])[None]
    first, second = np.tril_indices(6)
    both = quadratic + quadratic.swapaxes(1, 2)
    both[:, range(6), range(6)] *= 0.5
    return np.vstack([rest, np.hstack([c.C.T, c.H.T]), both[:, first, second].T])


def _require_positive(key: str, value: float) -> None:
    if not 0.0 < value < np.inf:
        raise SceneError(key, value, "must be above 0")


def _require_count(key: str, value: int, fewest: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < fewest:
        raise SceneError(key, value, f"must be an integer of at least {fewest}")
