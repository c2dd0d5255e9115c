"""u_i = Σ_j u(r_i − r_j), (v, ω)_i = Σ_j μ_ij · (F, T)_j by PyStokes: the reference backend.

At first use the factors of the installed release are compared with the closed forms
(:mod:`nrchain.hydrodynamics.pystokes_check`). A release without known factors is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from nrchain.errors import BackendError, SceneError
from nrchain.hydrodynamics.pystokes import (
    MOBILITIES,
    PI,
    RELEASES,
    Array,
    irreducible_tensor,
    library,
    radius_power,
    sum_flow,
    sum_mobility,
)
from nrchain.hydrodynamics.pystokes_check import check


def twists(
    positions: Array,
    axes: Sequence[Array],
    strengths: Sequence[Array],
    *,
    neighbours: int | str,
    radius: float,
    viscosity: float,
    finite_size: bool,
    labels: Sequence[str],
) -> tuple[Array, Array]:
    """u_i = Σ_j u(r_i − r_j), w_i = Σ_j w(r_i − r_j): what the slip of all others does to sphere i.

    Parameters
    ----------
    positions
        Centres, ``(N, 3)``, of an open chain.
    axes, strengths, labels
        For each mode its unit vectors in the lab ``(N, 3)``, its strengths ``(N,)`` and its label.
    neighbours
        How far along the chain the sum goes: a number of neighbours on either side, or ``"all"``.
    radius, viscosity
        Of the spheres and of the fluid.
    finite_size
        Whether 2s has its finite-size part; the other modes have none.

    Returns
    -------
    Velocities and angular velocities in the lab, each ``(N, 3)``.

    Raises
    ------
    SceneError
        A mode that PyStokes has no routine for.
    BackendError
        PyStokes is missing, of an unknown release, or fails its self-check.
    """
    table = RELEASES[_verified(library().__version__)]
    for label in labels:
        if label not in table:
            raise SceneError(
                "backend", "pystokes", f"has {', '.join(table)} only; mode {label!r} needs 'native'"
            )
    centres = np.array(positions, dtype=np.float64).T
    velocities, spins = np.zeros_like(centres), np.zeros_like(centres)
    for label, axis, strength in zip(labels, axes, strengths, strict=True):
        if not np.any(strength):
            continue
        mode = table[label]
        tensor = irreducible_tensor(mode.rank, axis, strength)
        velocity = mode.finite_size if finite_size and mode.finite_size else mode.velocity
        for total, routine in ((velocities, velocity), (spins, mode.spin)):
            if routine is not None:
                output = sum_flow(routine, centres, tensor, neighbours, radius, viscosity)
                total += output * radius ** radius_power(label) / float(routine.ratio)
    return velocities.T.copy(), spins.T.copy()


def mobility(
    positions: Array, wrenches: Array, neighbours: int | str, radius: float, viscosity: float
) -> Array:
    """(v, ω)_i = Σ_j μ_ij · (F, T)_j with the mobilities of Rotne, Prager and Yamakawa.

    Parameters
    ----------
    positions, wrenches
        Centres ``(N, 3)`` of an open chain, and the force and torque on each sphere ``(N, 6)``.
    neighbours
        How far along the chain the sum goes: a number of neighbours on either side, or ``"all"``.
    radius, viscosity
        Of the spheres and of the fluid.

    Returns
    -------
    Twists ``(N, 6)`` in the lab, with what each wrench does to its own sphere.

    Raises
    ------
    BackendError
        Two spheres within reach overlap, for which PyStokes has no mobility; and as
        :func:`twists`.
    """
    release = _verified(library().__version__)
    centres = np.array(positions, dtype=np.float64).T
    wrenches = np.array(wrenches, dtype=np.float64).T
    _refuse_overlap(centres, neighbours, radius)
    result = np.zeros_like(wrenches)
    for method, (quantity, cause) in MOBILITIES.items():
        output = sum_mobility(method, centres, wrenches[cause], neighbours, radius, viscosity)
        result[quantity] += output * (PI[release] / np.pi)
    return result.T.copy()


def _refuse_overlap(centres: Array, neighbours: int | str, radius: float) -> None:
    count = centres.shape[1]
    gaps = count - 1 if neighbours == "all" else min(int(neighbours), count - 1)
    for m in range(1, gaps + 1):
        distances = np.linalg.norm(centres[:, m:] - centres[:, :-m], axis=0)
        if np.any(distances < 2 * radius):
            i = int(np.argmin(distances))
            raise BackendError(
                f"spheres {i} and {i + m} are {distances[i]:.6g} apart, less than two radii of "
                f"{radius:.6g}: PyStokes has no mobility of overlapping spheres; use the native "
                "backend"
            )


@cache
def _verified(version: str) -> str:
    """The release, once it has passed its check; a failure is raised anew each time."""
    check(version)
    return version
