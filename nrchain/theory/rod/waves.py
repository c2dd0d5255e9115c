"""Λ(q) of the straight rod of a material: all branches, their group velocity, the beam limit.

Λ = growth − iω: a wave exp(iqs + Λt) grows at Re Λ, and a packet of such waves travels at the group
velocity dω/dq. The rod is divided into waves without strain and waves that strain
(:func:`nrchain.theory.rod.symbol.blocks`). Bending rates are then exact at any stiffness.

For qd → 0 the rod of linear response has the operator of the lattice up to terms in u‴ and φ‴,
because its moduli are those of the second derivatives. Rates of bending waves agree to a relative
order (qd)². The exception is 3a, where the term in u‴ that the rod drops is of the order of the law
itself: the rod has −13/12 for −13/18 in front of (qd)³ (paper, Eq. 3a_trans_ac_disp).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nrchain.inputs.arguments import finite_array
from nrchain.notebook import record_html
from nrchain.theory.eigenvalues import follow, matched_eigenvalues, two_branches
from nrchain.theory.lattice import Branch, Frame
from nrchain.theory.rod.material import Material
from nrchain.theory.rod.symbol import Complex, Symbol, beam_symbol, blocks
from nrchain.wording import brief

BEAM = (Branch.BEND_PLUS, Branch.BEND_MINUS, Branch.TWIST)
"""The branches of the beam limit."""

PAIRS = (
    (Branch.BEND_PLUS, Branch.SHEAR_PLUS),
    (Branch.BEND_MINUS, Branch.SHEAR_MINUS),
    (Branch.TWIST, Branch.STRETCH),
)
"""Branches that a transversely isotropic rod couples; waves without strain first."""

_HAND = np.sqrt(0.5) * np.array([[1.0, 1.0], [-1j, 1j]])
"""w_y and w_z of unit waves of hand + and −."""


@dataclass(frozen=True, eq=False)
class Waves:
    """The branches of the straight rod of a material.

    Attributes
    ----------
    wavenumbers
        q (n,).
    rates
        Λ (n, k), in the lab or in spinning axes, at a fixed point of the material.
    velocities
        dω/dq (n, k), along s. An observer at rest in the lab adds V⁰ of the rod.
    branches
        The names of the columns: those of :class:`nrchain.lattice.Branch`, or BEND_PLUS,
        BEND_MINUS and TWIST in the beam limit.
    """

    wavenumbers: NDArray[np.float64]
    rates: Complex
    velocities: NDArray[np.float64]
    branches: tuple[Branch, ...]

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def growth(self) -> NDArray[np.float64]:
        """Re Λ (n, k)."""
        return self.rates.real

    @property
    def frequency(self) -> NDArray[np.float64]:
        """ω = −Im Λ (n, k): crests travel at ω/q."""
        return -self.rates.imag

    def column(self, branch: Branch) -> Complex:
        """Λ (n,) of one branch."""
        return self.rates[:, self.branches.index(branch)]


def rod_waves(
    material: Material, wavenumbers: ArrayLike, *, frame: Frame = "lab", beam: bool = False
) -> Waves:
    """All branches Λ(q) of the straight rod of a material, or those of its beam limit.

    Parameters
    ----------
    wavenumbers
        q (n,). At the first, branches are named as those of the lattice; they are then followed
        from each wavenumber to the next.
    frame
        ``"lab"`` or ``"spinning"``: see :mod:`nrchain.theory.lattice`. They differ if the rod
        spins.
    beam
        Whether the rod is unshearable and inextensible.

    For an anisotropic rod the error is 1e-16 of the largest rate. Raises
    :class:`~nrchain.errors.SceneError` for a drag that is not positive definite, a rod that does
    not stay straight, and components in the lab of an anisotropic rod that spins.

    >>> import nrchain
    >>> from nrchain import rod
    >>> material = nrchain.Material.of(nrchain.load_scene("wave"))
    >>> waves = rod.rod_waves(material, [0.01, 0.02], beam=True)
    >>> [branch.name for branch in waves.branches]
    ['BEND_PLUS', 'BEND_MINUS', 'TWIST']
    """
    q = finite_array("wavenumbers", wavenumbers, (None,))
    parts = (beam_symbol(material, frame=frame),) if beam else blocks(material, frame=frame)
    branches = BEAM if beam else tuple(Branch)
    rates, slopes = np.zeros((2, len(q), len(branches)), complex)
    for columns in _groups(material, branches) if len(q) else ():
        rates[:, columns] = follow(partial(_values, parts, columns), q)
        slopes[:, columns] = _slopes(parts, q, rates[:, columns], columns)
    return Waves(q, rates, -slopes.imag, branches)


def _groups(material: Material, branches: tuple[Branch, ...]) -> list[list[int]]:
    """The columns of branches that couple."""
    if not material.symmetry.isotropic:
        return [list(range(len(branches)))]
    return [[branches.index(b) for b in pair if b in branches] for pair in PAIRS]


def _values(parts: tuple[Symbol, ...], columns: list[int], q: complex) -> Complex:
    """Λ of branches that couple (k,), at one wavenumber."""
    M, _, drag = (part[0][np.ix_(columns, columns)] for part in _operator(parts, np.array([q])))
    if len(columns) == 1:
        return M[0]
    if len(columns) == 2:
        return np.array(two_branches(M[0, 0], M[0, 1], M[1, 0], M[1, 1]))
    sizes = np.sqrt(np.diagonal(drag).real)
    return matched_eigenvalues(sizes[:, None] * M / sizes)


def _slopes(
    parts: tuple[Symbol, ...], q: np.ndarray, rates: Complex, columns: list[int]
) -> Complex:
    """dΛ/dq (n, k) = y·(dM/dq)·x of the left and right vectors of each rate."""
    M, slope, _ = (part[:, columns][..., columns] for part in _operator(parts, q))
    if len(columns) == 1:
        return slope[..., 0]
    if len(columns) == 2:
        # of (Λ − a)(Λ − d) = bc, which needs no vectors where they coincide
        a, b, c, d = (M[:, None, i, j] for i in (0, 1) for j in (0, 1))
        da, db, dc, dd = (slope[:, None, i, j] for i in (0, 1) for j in (0, 1))
        change = da * (rates - d) + dd * (rates - a) + db * c + b * dc
        apart = 2.0 * rates - a - d
        return np.divide(change, apart, out=np.zeros_like(change), where=apart != 0.0)
    found = np.empty_like(rates)
    for n, (matrix, change) in enumerate(zip(M, slope, strict=True)):
        values, vectors = np.linalg.eig(matrix)
        parts_of_change = np.diagonal(np.linalg.solve(vectors, change @ vectors))
        found[n] = parts_of_change[np.argmin(np.abs(rates[n][:, None] - values), axis=1)]
    return found


def _operator(parts: tuple[Symbol, ...], q: np.ndarray) -> tuple[Complex, Complex, Complex]:
    """M, dM/dq and Γ (n, k, k) in the columns of the branches, as one symbol or four blocks."""
    size = 1 if len(parts) == 1 else 2
    matrices = np.zeros((4, len(q), 3 * size, 3 * size), complex)
    for place, part in zip(np.ndindex(size, size), parts, strict=True):
        rows, columns = (slice(3 * n, 3 * n + 3) for n in place)
        for matrix, block in zip(matrices, (*part.at(q), *part.slopes(q)), strict=True):
            matrix[:, rows, columns] = block
    basis = _basis(size)
    W, drag, dW, dragged = basis.conj().T @ matrices @ basis
    M = np.linalg.solve(drag, W)
    return M, np.linalg.solve(drag, dW - dragged @ M), drag


def _basis(size: int) -> Complex:
    """(u_y, u_z, φ_x) alone, or also (F_x, F_y, F_z), in unit waves of the branches."""
    basis = np.zeros((3 * size, 3 * size), complex)
    branches = BEAM if size == 1 else tuple(Branch)
    bend = [branches.index(b) for b in (Branch.BEND_PLUS, Branch.BEND_MINUS)]
    basis[:2, bend], basis[2, branches.index(Branch.TWIST)] = _HAND, 1.0
    if size == 2:
        basis[4:, [Branch.SHEAR_PLUS, Branch.SHEAR_MINUS]] = _HAND
        basis[3, Branch.STRETCH] = 1.0
    return basis
