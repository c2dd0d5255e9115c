"""Λ of the mode that grows fastest, or decays slowest, without modes and errors."""

from __future__ import annotations

from nrchain.comoving import dense, krylov
from nrchain.comoving.relative import Point

WHOLE = 60
"""Spheres up to which all eigenvalues are computed, in less than 0.1 s. Beyond, those near the axes
are sought by iterations, in seconds for hundreds of spheres."""


def leading_rate(point: Point) -> complex:
    """The eigenvalue Λ of J with the largest real part, motions of the whole apart.

    Raises FloatingPointError where none is found.
    """
    if point.chain.model.count <= WHOLE:
        rates = dense.all_rates(point)
    else:
        rates = krylov.leading_rates(point, 2, krylov.numerical_abscissa(point))
    return complex(rates[0])
