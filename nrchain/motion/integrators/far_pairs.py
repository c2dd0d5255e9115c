"""(I − hJ/λ) x = b where a few pairs of spheres far along the chain couple: GMRES in compiled code.

With J = J₀ + R, J₀ the blocks near the diagonal and R of the far pairs, the factors of
P = I − hJ₀/λ precondition, and what remains is (I − (h/λ) P⁻¹ R) x = P⁻¹ b. Its Krylov space has at
most six dimensions for each pair, and one more. Without such pairs P⁻¹ b is the solution.

Every step starts at y = 0, where changes of y are displacements and rotations in the lab: R is that
of the terms of a model (:func:`nrchain.motion.terms.add_far`).

Saad & Schultz, SIAM J. Sci. Stat. Comput. 7, 856 (1986).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain._addresses import (
    ROW,
    Callback,
    address_of,
    call,
    carray,
    compile_term,
    complex_at,
    floats_at,
    integers_at,
    matrix_in,
    vector_in,
)
from nrchain._compile import part
from nrchain.motion.integrators.chain_equation import (
    ARRAYS,
    REAL_SCALE,
    SOLVERS,
    VECTORS_AT,
    ChainEquation,
)
from nrchain.motion.integrators.linear import KRYLOV_DIMENSION, RESIDUAL
from nrchain.motion.integrators.radau_steps import LINEARISE, SCALE, SOLVE_PAIR, SOLVE_REAL
from nrchain.motion.terms import FAR, NO_BLOCKS, add_far


@part
def _norm(vector):
    total = 0.0
    for m in range(vector.shape[0]):
        total += vector[m].real ** 2 + vector[m].imag ** 2
    return np.sqrt(total)


@part
def _subtract_projection(basis, vector):
    """vector −= basis ⟨basis, vector⟩; returns the product."""
    product = 0.0 * vector[0]
    for m in range(vector.shape[0]):
        product += np.conj(basis[m]) * vector[m]
    for m in range(vector.shape[0]):
        vector[m] -= product * basis[m]
    return product


@part
def _rotate(column, cosines, sines, target, j):
    """Bring column j of the Hessenberg matrix to upper triangular form, and ``target`` with it."""
    for k in range(j):
        above, below = column[k], column[k + 1]
        column[k] = cosines[k] * above + sines[k] * below
        column[k + 1] = cosines[k] * below - np.conj(sines[k]) * above
    above, below = column[j], column[j + 1]
    size = np.sqrt(above.real**2 + above.imag**2)
    length = np.sqrt(size**2 + below.real**2 + below.imag**2)
    phase = above / size if size > 0.0 else 1.0 + 0.0 * above
    cosines[j], sines[j] = size / length, phase * np.conj(below) / length
    column[j], column[j + 1] = phase * length, 0.0
    target[j + 1] = -np.conj(sines[j]) * target[j]
    target[j] = cosines[j] * target[j]


@part
def _set_far_product(t, vector, poses, twists, out):
    """out = R vector, for real or complex vectors; returns whether R is not zero."""
    kinds, some = vector.itemsize // 8, False
    given = carray(floats_at(address_of(vector)), kinds * vector.shape[0])
    found = carray(floats_at(address_of(out)), kinds * vector.shape[0])
    for kind in range(kinds):
        for i in range(poses.shape[0]):
            for p in range(6):
                poses[i, p] = given[kinds * (6 * i + p) + kind]
        some = add_far(t, poses, twists)
        for i in range(poses.shape[0]):
            for p in range(6):
                found[kinds * (6 * i + p) + kind] = twists[i, p]
    return some


numbers_at: Any = None
"""Pointers to real or to complex numbers: :func:`compile_term` puts one of them in its place."""


def _solve(context, source, _target, _flag, which):
    """Solve for the vector at ``source``, in place."""
    t = carray(integers_at(context), (ARRAYS, ROW))
    k, n = which - SOLVE_REAL, t[VECTORS_AT, 2]
    solvers, units = matrix_in(t, SOLVERS, integers_at), matrix_in(t, VECTORS_AT, floats_at)[SCALE]
    status = call(solvers[k, 1], solvers[k, 2], source, 0, 0, 0)
    vector, scale = carray(numbers_at(source), n), vector_in(t, REAL_SCALE + k, numbers_at)[0]
    poses, twists, change = np.empty((n // 6, 6)), np.empty((n // 6, 6)), np.empty_like(vector)
    if status or not _set_far_product(t, vector, poses, twists, change):
        return status
    basis = np.empty((KRYLOV_DIMENSION + 1, n), vector.dtype)
    columns = np.zeros((KRYLOV_DIMENSION, KRYLOV_DIMENSION + 1), vector.dtype)
    target = np.zeros(KRYLOV_DIMENSION + 1, vector.dtype)
    cosines, sines = np.empty(KRYLOV_DIMENSION), np.empty(KRYLOV_DIMENSION, vector.dtype)
    for m in range(n):
        basis[0, m] = vector[m] / units[m]
    begin, used = _norm(basis[0]), 0
    if not begin > 0.0:
        return status
    target[0] = begin
    basis[0] /= begin
    for j in range(KRYLOV_DIMENSION):
        for m in range(n):
            change[m] = units[m] * basis[j, m]
        _set_far_product(t, change, poses, twists, change)
        for m in range(n):
            change[m] *= scale
        status = call(solvers[k, 1], solvers[k, 2], address_of(change), 0, 0, 0)
        if status:
            return status
        for m in range(n):
            basis[j + 1, m] = basis[j, m] - change[m] / units[m]
        for i in range(j + 1):
            columns[j, i] = _subtract_projection(basis[i], basis[j + 1])
        size = _norm(basis[j + 1])
        columns[j, j + 1] = size
        _rotate(columns[j], cosines, sines, target, j)
        used = j + 1
        if not abs(target[used]) > RESIDUAL * begin:
            break
        basis[used] /= size
    for j in range(used - 1, -1, -1):
        for i in range(j + 1, used):
            target[j] -= columns[i, j] * target[i]
        target[j] /= columns[j, j]
    for m in range(n):
        total = 0.0 * vector[m]
        for j in range(used):
            total += basis[j, m] * target[j]
        vector[m] = units[m] * total
    return 0


# The row to spare of the solvers: what takes J, and what is called where pairs far along the chain
# first couple.
AT_CONTACT = 2


def _linearise(context, source, target, _flag, which):
    """Take J; call Python once, when a pair far along the chain couples."""
    t = carray(integers_at(context), (ARRAYS, ROW))
    solvers, far = matrix_in(t, SOLVERS, integers_at), matrix_in(t, FAR, integers_at)
    status = call(solvers[AT_CONTACT, 0], context, source, target, 0, which)
    for k in range(far.shape[0]):
        if status == 0 and call(far[k, 0], far[k, 1], 0, 0, 0, NO_BLOCKS):
            return call(solvers[AT_CONTACT, 1], 0, 0, 0, 0, 0)
    return status


class FarPairSolver:
    """Solves the systems of an ``equation`` with what its blocks leave out.

    GMRES is compiled when a pair far along the chain first couples: most runs have none.
    """

    def __init__(self, equation: ChainEquation) -> None:
        self._equation, self._contact = equation, Callback(self._begin)
        self._direct = int(equation.functions[LINEARISE])
        equation.solvers[AT_CONTACT, :2] = self._direct, self._contact.address
        equation.functions[LINEARISE] = compile_term(_linearise).address

    def _begin(self, *_: int) -> None:
        functions = self._equation.functions
        for place, kind in ((SOLVE_REAL, floats_at), (SOLVE_PAIR, complex_at)):
            functions[place] = compile_term(_solve, numbers_at=kind).address
        functions[LINEARISE] = self._direct

    def raise_error(self) -> None:
        """Raise the exception of the compilation, if it failed."""
        self._contact.raise_error()
