"""(F, M) = (F̃, M̃) + C·(ε, τ), (f, m) = (f̃, m̃) + H·(ε, τ) − Γ·(V, Ω): the material of a rod.

The stress has an energy if C is symmetric (paper, Eq. major_sym_rod), and the material is then
hyperelastic; otherwise it is odd. It is sourced if a source is not 0. In a cycle of uniform strain
the stress of unit length does the work

    W = −∮ (F·dε + M·dτ) = Σ_{a<b} (C_ab − C_ba) A_ab,     A_ab = ½ ∮ (x_a dx_b − x_b dx_a),

with x = (ε, τ): the antisymmetric part of C times the area of the cycle.

Source: paper, Secs. "Reciprocal elasticity and major symmetry" and "Dissipation".
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from nrchain.errors import SceneError
from nrchain.inputs.arguments import finite_array
from nrchain.inputs.rules import is_number
from nrchain.notebook import record_html
from nrchain.scene.scene import Scene
from nrchain.theory.rod.coarse_graining import Stress, moduli
from nrchain.theory.rod.constants import Constants
from nrchain.theory.rod.measured_symmetry import measured_symmetry
from nrchain.theory.rod.symmetry import Symmetry
from nrchain.wording import brief

ROUNDING = 1e-15
"""Error of a product of stress and strain, relative to its size."""

EXACT = 1e-13
"""Error of given constants, relative to the largest of their block."""


@dataclass(frozen=True, eq=False)
class Material:
    """The linear material of a rod, in the moving frame.

    Make one from a scene (:meth:`of`), from numbers (:meth:`from_numbers`) or from the paper's
    symbols (:meth:`from_symbols`).

    Attributes
    ----------
    constants
        C, H (6, 6), prestress and presource (6,).
    drag
        Γ (6, 6), per length.
    error
        Bounds of the absolute errors of the constants.

    >>> from nrchain import load_scene
    >>> Material.of(load_scene("buckling")).drag.shape
    (6, 6)
    """

    constants: Constants
    drag: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))
    error: Constants = field(default_factory=Constants.of)

    __repr__ = brief
    _repr_html_ = record_html

    @classmethod
    def of(cls, scene: Scene, stress: Stress = "linear", wavenumber: float | None = None) -> Self:
        """The material of the chain of a scene: see :func:`nrchain.moduli`.

        With all pairs, constants that depend on the wavelength are taken at ``wavenumber``.
        Raises :class:`~nrchain.errors.SceneError` where it is missing.
        """
        found = moduli(scene, stress)
        if wavenumber is not None:
            return cls(found.at(wavenumber), found.drag, found.error)
        if found.logarithm.largest() > 0.0:
            allowed = (
                "makes moduli that depend on the wavelength as ln(1/qd): give a wavenumber, or name"
                " a number of neighbours"
            )
            raise SceneError("slip.neighbours", "all", allowed)
        return cls(found.total, found.drag, found.error)

    @classmethod
    def from_numbers(
        cls,
        C: ArrayLike | None = None,
        H: ArrayLike | None = None,
        prestress: ArrayLike | None = None,
        presource: ArrayLike | None = None,
        drag: ArrayLike | None = None,
    ) -> Self:
        """The material of these arrays; those that are left out are 0."""
        constants = Constants.of(C, H, prestress, presource)
        gamma = np.zeros((6, 6)) if drag is None else finite_array("drag", drag, (6, 6)).copy()
        return cls(constants, gamma, _rounding(constants))

    @classmethod
    def from_symbols(cls, *, Gamma_T: float = 0.0, Gamma_R: float = 0.0, **symbols: float) -> Self:
        """The transversely isotropic material of the paper's symbols, such as ``C_perp_F_eps``.

        Γ^T and Γ^R are the drags of translation and rotation; for the other names see
        ``nrchain.rod.SYMBOLS``. Constants that are left out are 0.

        >>> from nrchain import rod
        >>> passive = rod.Material.from_symbols(C_par_F_eps=2.0, C_perp_F_eps=1.0)
        >>> float(passive.energy([0.1, 0, 0, 0, 0, 0]))
        0.01
        """
        for name, value in symbols.items():
            if not is_number(value):
                raise SceneError(name, value, "must be a finite number")
        for name, value in (("Gamma_T", Gamma_T), ("Gamma_R", Gamma_R)):
            if not is_number(value) or value < 0.0:
                raise SceneError(name, value, "must be a finite number of at least 0")
        constants = Constants.named(symbols)
        return cls(constants, np.diag(np.repeat([Gamma_T, Gamma_R], 3)), _rounding(constants))

    def stress(self, strains: ArrayLike) -> np.ndarray:
        """(F, M) (..., 6) at strains (ε, τ) (..., 6)."""
        x = _of_six("strains", strains)
        return self.constants.prestress + x @ self.constants.C.T

    def source(self, strains: ArrayLike, twists: ArrayLike | None = None) -> np.ndarray:
        """(f, m) (..., 6) at strains (..., 6), with the drag at twists (V, Ω) (..., 6)."""
        x = _of_six("strains", strains)
        active = self.constants.presource + x @ self.constants.H.T
        return active if twists is None else active - _of_six("twists", twists) @ self.drag.T

    @property
    def oddness(self) -> np.ndarray:
        """C − Cᵀ (6, 6): the work in a cycle over its area."""
        return self.constants.C - self.constants.C.T

    @property
    def odd(self) -> bool:
        """Whether C differs from its transpose by more than its error: there is no energy."""
        return bool(np.any(np.abs(self.oddness) > self.error.C + self.error.C.T))

    @property
    def hyperelastic(self) -> bool:
        """Whether the stress has an energy."""
        return not self.odd

    @property
    def sourced(self) -> bool:
        """Whether a source, at rest or per strain, is larger than its error."""
        pairs = (
            (self.constants.H, self.error.H),
            (self.constants.presource, self.error.presource),
        )
        return any(bool(np.any(np.abs(value) > error)) for value, error in pairs)

    @property
    def symmetry(self) -> Symmetry:
        """The symmetries of the constants, within their errors."""
        return measured_symmetry(self.constants, self.error)

    def energy(self, strains: ArrayLike) -> np.ndarray:
        """𝓔 = F̃·ε + M̃·τ + ½ (ε, τ)·C·(ε, τ) per length (Eq. quadr_elastic_en).

        Raises :class:`~nrchain.errors.SceneError` for an odd material, which has none.
        """
        if self.odd:
            worst = float(np.abs(self.oddness).max())
            allowed = f"is not symmetric (C_ab − C_ba up to {worst:.3g}): the stress has no energy"
            raise SceneError("C", "the matrix (F, M) per (ε, τ)", allowed)
        x = _of_six("strains", strains)
        return x @ self.constants.prestress + 0.5 * np.einsum(
            "...a,ab,...b->...", x, self.constants.C, x
        )

    def dissipation(self, twists: ArrayLike) -> np.ndarray:
        """(V, Ω)·Γ·(V, Ω) (...): the power per length lost to the fluid at twists (..., 6)."""
        xi = _of_six("twists", twists)
        return np.asarray(np.einsum("...a,ab,...b->...", xi, self.drag, xi))

    def work(self, cycle: ArrayLike) -> Work:
        """W = −∮ (F·dε + M·dτ) per length in a cycle of strains (n, 6): see :func:`cycle_work`."""
        x = finite_array("cycle", cycle, (None, 6))
        errors = self.error.prestress + np.abs(x) @ self.error.C.T
        return cycle_work(x, self.stress(x), errors)


class Work(NamedTuple):
    """Work per length in a cycle, and a bound of its error."""

    value: float
    error: float


def strain_cycle(first: ArrayLike, second: ArrayLike, points: int = 32) -> np.ndarray:
    """x = cos φ a + sin φ b (n, 6): an ellipse of strains about zero, at equal steps of φ."""
    a, b = (finite_array(n, v, (6,)) for n, v in (("first", first), ("second", second)))
    phase = 2.0 * np.pi / points * np.arange(points)[:, None]
    return np.cos(phase) * a + np.sin(phase) * b


def cycle_work(cycle: ArrayLike, stresses: ArrayLike, errors: ArrayLike | float = 0.0) -> Work:
    """W = −∮ (F·dε + M·dτ): work that stresses (n, 6) do per length in a cycle of strains (n, 6).

    Strains are at equal steps of the phase of a smooth cycle, the last before the first again. The
    slope of the strains is that of their Fourier series, the sum over the phase the trapezoidal
    rule: both converge faster than any power of 1/n. Work is positive where the material drives its
    surroundings.

    The error is that of the ``errors`` of the stresses, of rounding, and the difference from the
    work by every other point where n is even; it is then that of half the points, and generous.
    """
    x = finite_array("cycle", cycle, (None, 6))
    F = finite_array("stresses", stresses, (None, 6))
    if len(F) != len(x):
        raise SceneError("stresses", F.shape, f"must be as many as strains, {len(x)}")
    bounds = np.broadcast_to(finite_array("errors", errors), F.shape)
    work, slope = _trapezoidal_work(x, F)
    step = 2.0 * np.pi / len(x)
    error = step * float(np.sum((bounds + ROUNDING * np.abs(F)) * np.abs(slope)))
    if len(x) % 2 == 0:
        error += abs(work - _trapezoidal_work(x[::2], F[::2])[0])
    return Work(work, error)


def _of_six(key: str, value: ArrayLike) -> np.ndarray:
    """Finite numbers (..., 6)."""
    array = finite_array(key, value)
    if array.shape[-1:] != (6,):
        raise SceneError(key, array.shape, "must have six numbers along the last axis")
    return array


def _trapezoidal_work(x: np.ndarray, F: np.ndarray) -> tuple[float, np.ndarray]:
    """The work, and dx/dφ (n, 6)."""
    orders = 1j * np.fft.rfftfreq(len(x), 1.0 / len(x))
    if len(x) % 2 == 0:
        orders[-1] = 0.0
    slope = np.fft.irfft(orders[:, None] * np.fft.rfft(x, axis=0), len(x), axis=0)
    return float(-2.0 * np.pi / len(x) * np.sum(F * slope)), slope


def _rounding(constants: Constants) -> Constants:
    """Errors of given constants: :data:`EXACT` of the largest entry of each block of three."""

    def of_blocks(part: np.ndarray) -> np.ndarray:
        largest = np.abs(part).reshape((2, 3) * part.ndim)
        axes = tuple(range(1, 2 * part.ndim, 2))
        bounds = EXACT * largest.max(axis=axes, keepdims=True)
        return np.broadcast_to(bounds, largest.shape).reshape(part.shape).copy()

    return constants.map(of_blocks)
