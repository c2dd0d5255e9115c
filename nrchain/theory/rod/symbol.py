"""Λ Γ(q) w = W(q) w: plane waves w = (u, φ) ∝ exp(iqs + Λt) of the straight rod of a material.

W is the change of the wrench per length, in the moving frame, with what the motion of the base
state adds. Both matrices are polynomials in the slope iq,

    W(q) = Σ_n W_n (iq)ⁿ,     Γ(q) = Σ_n Γ_n (iq)ⁿ,

and so analytic in complex q. The linearised balance of a rod with stress C·(ε, τ) + (F̃, M̃) and
sources H·(ε, τ) + (f̃, m̃) is

    δ(F′ + f) = 0,     δ(M′ + r′ × F + m) = 0,     ε = u′ + x̂ × φ,     τ = φ′,

with δF = φ × F̃ + C·(ε, τ) and alike for the others. The base state is straight, translates at V⁰
and spins at Ω⁰ about its axis: Γ·(V⁰, Ω⁰) = (f̃, m̃ + x̂ × F̃). s is the coordinate of the material
and moves with the rod; u and φ have components in the lab, or along axes that spin with the rod.
Frames are those of :mod:`nrchain.theory.lattice`.

In the beam limit the rod neither shears nor stretches: ε = 0, and waves are

    (u, φ) = (u_⊥, x̂ × u_⊥′ + φ_x x̂).

The force that keeps ε = 0 does no work on them. Then Γ and W act between such waves alone, and
the stress F of the material drops out, but not r′ × F̃.

Source: paper, Sec. "Linearized elastohydrodynamics", for transversely isotropic rods.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nrchain.errors import SceneError
from nrchain.inputs.rules import choice
from nrchain.notebook import record_html
from nrchain.theory.lattice import Frame
from nrchain.theory.rod.constants import TURN, Constants, cross
from nrchain.theory.rod.material import Material
from nrchain.wording import brief

Complex = NDArray[np.complex128]

STRAIGHT = 1e-12
"""Largest angular velocity across the rod that counts as rounding, relative to its scale."""


@dataclass(frozen=True, eq=False)
class Symbol:
    """Λ Γ(q) w = W(q) w with W = Σ wrench[n] (iq)ⁿ and Γ = Σ drag[n] (iq)ⁿ.

    Attributes
    ----------
    wrench, drag
        The coefficients (n, k, k), real or complex.
    """

    wrench: np.ndarray
    drag: np.ndarray

    __repr__ = brief
    _repr_html_ = record_html

    def __post_init__(self) -> None:
        for name in ("wrench", "drag"):
            part = np.asarray(getattr(self, name))
            if part.ndim != 3 or part.shape[1] != part.shape[2]:
                raise SceneError(name, part.shape, "must be the shape of coefficients (n, k, k)")
            object.__setattr__(self, name, part)

    def at(self, wavenumbers: ArrayLike) -> tuple[Complex, Complex]:
        """W and Γ (..., k, k) at wavenumbers q, real or complex."""
        slope = 1j * np.asarray(wavenumbers, complex)[..., None, None]
        return _evaluate(self.wrench, slope), _evaluate(self.drag, slope)

    def slopes(self, wavenumbers: ArrayLike) -> tuple[Complex, Complex]:
        """dW/dq and dΓ/dq (..., k, k)."""
        slope = 1j * np.asarray(wavenumbers, complex)[..., None, None]
        wrench, drag = (
            1j * _evaluate(_derivative(part), slope) for part in (self.wrench, self.drag)
        )
        return wrench, drag

    def operator(self, wavenumbers: ArrayLike) -> Complex:
        """M = Γ⁻¹ W (..., k, k), with d/dt w = M w."""
        wrench, drag = self.at(wavenumbers)
        return np.asarray(np.linalg.solve(drag, wrench), complex)

    def moving(self, velocity: float) -> Symbol:
        """The symbol for an observer who moves at a velocity along s: Λ + iq · velocity."""
        added = np.concatenate([np.zeros_like(self.drag[:1]), velocity * self.drag])
        size = max(len(added), len(self.wrench))
        wrench = np.zeros((size, *self.wrench.shape[1:]), np.result_type(self.wrench, added))
        wrench[: len(self.wrench)] += self.wrench
        wrench[: len(added)] += added
        return Symbol(wrench, self.drag)

    def between(self, left: np.ndarray, right: np.ndarray) -> Symbol:
        """The symbol Lᵀ(−q) · R(q) between waves R = Σ right[n] (iq)ⁿ; L alike, of its conjugate.

        For real q, and real coefficients left = right, this is R† W R.
        """
        signs = (-1.0) ** np.arange(len(left))[:, None, None]
        rows = (signs * left).swapaxes(-1, -2)
        return Symbol(*(_product(_product(rows, part), right) for part in (self.wrench, self.drag)))


def rod_symbol(material: Material, *, frame: Frame = "lab") -> Symbol:
    """The 6×6 symbol of the straight rod of a material.

    Raises :class:`~nrchain.errors.SceneError` for a drag that is not positive definite, a rod that
    does not stay straight, and components in the lab of an anisotropic rod that spins.
    """
    twist = base_motion(material, frame)
    return Symbol(_wrenches(material.constants, material, twist, frame), material.drag[None].copy())


def beam_symbol(material: Material, *, frame: Frame = "lab") -> Symbol:
    """The 3×3 symbol of (u_y, u_z, φ_x) in the beam limit. Errors as for :func:`rod_symbol`."""
    waves = beam_waves()
    return _unsheared(material, frame).between(waves, waves)


def beam_waves() -> np.ndarray:
    """(u, φ) of waves without shear and stretch, as coefficients (2, 6, 3) of (iq)ⁿ."""
    waves = np.zeros((2, 6, 3))
    waves[0, 1, 0] = waves[0, 2, 1] = waves[0, 3, 2] = 1.0
    waves[1, 3:, :2] = TURN[:, 1:]
    return waves


def strained_waves() -> np.ndarray:
    """Wrenches (iq F, x̂ × F) of forces F, as coefficients (2, 6, 3); that of F_x without its iq."""
    waves = np.zeros((2, 6, 3))
    waves[0, 0, 0] = waves[1, 1, 1] = waves[1, 2, 2] = 1.0
    waves[0, 3:, 1:] = TURN[:, 1:]
    return waves


def _unsheared(material: Material, frame: Frame) -> Symbol:
    """The symbol for waves with ε = 0, without the force that does no work on such waves."""
    twist = base_motion(material, frame)
    constants = without(material.constants, rows=True, columns=True)
    return Symbol(_wrenches(constants, material, twist, frame), material.drag[None].copy())


def without(constants: Constants, *, rows: bool, columns: bool) -> Constants:
    """The constants without the response to ε (columns), and without that of F (rows)."""
    C, H = constants.C.copy(), constants.H.copy()
    if rows:
        C[:3] = 0.0
    if columns:
        C[:, :3] = H[:, :3] = 0.0
    return Constants(C, H, constants.prestress, constants.presource)


def blocks(material: Material, *, frame: Frame = "lab") -> tuple[Symbol, Symbol, Symbol, Symbol]:
    """Symbols between waves without strain B and waves S that strain: BB, BS, SB and SS.

    S are :func:`strained_waves` over Γ, so that Γ does not couple them to B. Stiffness against
    stretch and shear is in SS alone: the others are as exact as without it.
    """
    twist, weak = base_motion(material, frame), beam_waves()
    stiff = np.linalg.solve(material.drag, strained_waves())
    found = []
    for rows, left in ((True, weak), (False, stiff)):
        for columns, right in ((True, weak), (False, stiff)):
            kept = without(material.constants, rows=rows, columns=columns)
            symbol = Symbol(_wrenches(kept, material, twist, frame), material.drag[None])
            found.append(symbol.between(left, right))
    return found[0], found[1], found[2], found[3]


def base_motion(material: Material, frame: Frame = "lab") -> NDArray[np.float64]:
    """(V⁰, Ω⁰) (6,) of the straight rod: Γ·(V⁰, Ω⁰) = (f̃, m̃ + x̂ × F̃).

    Errors as for :func:`rod_symbol`.
    """
    choice(Frame)("frame", frame)
    drag = material.drag
    if np.linalg.eigvalsh(drag + drag.T).min() <= 0.0:
        raise SceneError("drag", drag.tolist(), "must be positive definite for the rod to move")
    wrench = _base_wrench(material)
    twist = np.linalg.solve(drag, wrench)
    scale = STRAIGHT * np.linalg.norm(np.linalg.inv(drag)[3:]) * np.abs(wrench).max()
    bound = np.abs(np.linalg.inv(drag)) @ _base_error(material)
    if np.any(np.abs(twist[4:]) > scale + bound[4:]):
        allowed = "turns the rod about an axis across it: it has no straight base state"
        raise SceneError("pre-torque", wrench[3:].tolist(), allowed)
    twist[4:] = 0.0
    if abs(twist[3]) <= scale + bound[3]:
        twist[3] = 0.0
    if frame == "lab" and twist[3] and not material.symmetry.isotropic:
        allowed = (
            "an anisotropic rod that spins has steady coefficients only in axes that spin with it:"
            " use frame='spinning'"
        )
        raise SceneError("frame", frame, allowed)
    return twist


def _base_wrench(material: Material) -> NDArray[np.float64]:
    wrench = material.constants.presource.copy()
    wrench[3:] += TURN @ material.constants.prestress[:3]
    return wrench


def _base_error(material: Material) -> NDArray[np.float64]:
    error = material.error.presource.copy()
    error[3:] += np.abs(TURN) @ material.error.prestress[:3]
    return error


def _wrenches(constants: Constants, material: Material, twist: np.ndarray, frame: Frame) -> Complex:
    """W_n (3, 6, 6). ``constants`` are those of the material, or some of them."""
    F, M = np.split(constants.prestress, 2)
    sheared = np.zeros((6, 6))
    sheared[:3, 3:] = TURN
    stress = np.stack([constants.C @ sheared, constants.C, np.zeros((6, 6))])
    total = np.stack([constants.H @ sheared, constants.H, np.zeros((6, 6))])
    stress[0, :, 3:] -= _turned(np.concatenate([F, M]))
    total[0, :, 3:] -= _turned(constants.presource)
    total[1:] += stress[:-1]
    total[:, 3:] += TURN @ stress[:, :3]
    total[1, 3:, :3] -= cross(F)
    # in the moving frame, and as changes of position and direction
    total[0, :, 3:] += _turned(_base_wrench(material))
    motion = np.zeros((6, 6))
    motion[:, 3:] -= _turned(twist)
    spin = cross(twist[3:])
    if frame == "lab":
        motion[3:, 3:] += spin
    else:
        motion[:3, :3] -= spin
    total[0] += material.drag @ motion
    return total


def _turned(pair: np.ndarray) -> np.ndarray:
    """The matrix (6, 3) of φ ↦ (a × φ, b × φ) for a pair (a, b)."""
    return np.concatenate([cross(half) for half in np.split(pair, 2)])


def _evaluate(coefficients: np.ndarray, slope: np.ndarray) -> Complex:
    total = np.zeros(np.broadcast_shapes(slope.shape, coefficients.shape[1:]), complex)
    for matrix in coefficients[::-1]:
        total = total * slope + matrix
    return total


def _derivative(coefficients: np.ndarray) -> np.ndarray:
    orders = np.arange(1, len(coefficients))[:, None, None]
    return orders * coefficients[1:] if len(orders) else np.zeros_like(coefficients)


def _product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The product of two polynomials of matrices."""
    shape = (len(left) + len(right) - 1, left.shape[1], right.shape[2])
    total = np.zeros(shape, np.result_type(left, right))
    for n, a in enumerate(left):
        for m, b in enumerate(right):
            total[n + m] += a @ b
    return total
