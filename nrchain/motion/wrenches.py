"""F, T and V from plain arrays: the pair laws and the elastic chain, for scripts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from nrchain.errors import SceneError, Words
from nrchain.hydrodynamics.given_slips import GivenSlip, given_slips
from nrchain.hydrodynamics.slip import Slip
from nrchain.inputs.arguments import finite_array, rotations
from nrchain.inputs.rules import choice, flag, number
from nrchain.potential.chain import Elasticity, terms_of
from nrchain.scene.chain_sections import Ends, Measure
from nrchain.scene.fluid_sections import NEIGHBOURS, Backend
from nrchain.scene.unwrapping import unwrapped


def _poses(positions: Any, frames: Any) -> tuple[np.ndarray, np.ndarray]:
    points = finite_array("positions", positions, (None, 3))
    return points, rotations(frames, len(points))


def active_wrenches(
    positions: np.ndarray,
    frames: np.ndarray,
    slip: Mapping[str, float | np.ndarray | Slip | Mapping[str, Any]],
    *,
    neighbours: int | Literal["all"] = 1,
    radius: float = 1.0,
    viscosity: float = 1.0,
    finite_size: bool = False,
    backend: Literal["native", "pystokes"] = "native",
) -> tuple[np.ndarray, np.ndarray]:
    """F_i = γ_T Σ_j u(r_i − r_j, e_j) and T_i = γ_R Σ_j w(r_i − r_j, e_j), due to slip.

    Parameters
    ----------
    positions, frames
        (N, 3) and (N, 3, 3); ``frames[i, k]`` is e_{k+1} of sphere i in lab components.
    slip
        Strength of each mode by its label: a number, an (N,) array, or a
        :class:`~nrchain.hydrodynamics.slip.Slip`, or its table, with a body axis of its own
        (default e1).
    neighbours
        Neighbours on either side that act on a sphere; ``"all"``: every pair.
    radius, viscosity
        a and η, in γ_T = 6πηa and γ_R = 8πηa³.
    finite_size
        Keep the (a/r)² correction of the 2s velocity, (1 + a²∇²/6)(1 + a²∇²/10).
    backend
        ``"native"``: compiled closed forms; ``"pystokes"``: the same by PyStokes.

    Returns
    -------
    forces, torques
        (N, 3) each, lab frame.

    Raises
    ------
    SceneError
        For input of the wrong shape, numbers that are not finite, unknown modes, coincident
        spheres, and results beyond the range of floats.
    BackendError
        When PyStokes is missing, of an unknown release, or fails its self-check.

    Paper: Eqs. (2s_force) to (4a_torque), with the 4a torque as half the curl of its force law.

    >>> import numpy as np
    >>> positions, frames = np.array([[0.0, 0, 0], [4.0, 0, 0]]), np.tile(np.eye(3), (2, 1, 1))
    >>> forces, torques = active_wrenches(positions, frames, {"2s": 1.0})
    >>> forces.round(3)
    array([[-2.749,  0.   ,  0.   ],
           [ 2.749,  0.   ,  0.   ]])
    """
    r, e = _poses(positions, frames)
    a = number(above=0)("radius", radius)
    eta = number(above=0)("viscosity", viscosity)
    neighbours = NEIGHBOURS("neighbours", neighbours)
    choice(Backend)("backend", backend)
    corrected = flag()("finite_size", finite_size)
    reach = max(len(r) - 1, 1) if neighbours == "all" else neighbours
    slips = given_slips(slip, len(r))
    _refuse_coincident(r, reach)
    with np.errstate(all="ignore"):
        try:
            if backend == "native":
                twists = _native(slips, r, e, reach, a, corrected)
            else:
                twists = _through_pystokes(slips, r, e, neighbours, a, eta, corrected)
        except OverflowError:
            twists = np.full((len(r), 6), np.inf)
        gamma = 6 * math.pi * eta * a
        forces, torques = gamma * twists[:, :3], gamma * (4 * a * a / 3) * twists[:, 3:]
    return _in_range("forces", forces), _in_range("torques", torques)


def _in_range(name: str, computed: np.ndarray) -> np.ndarray:
    """The computed numbers; SceneError if they left the range of floats."""
    if not np.isfinite(computed).all():
        allowed = "leave the range of floating point; choose units that give numbers nearer 1"
        raise SceneError(name, "NaN or inf", allowed)
    return computed


def _refuse_coincident(positions: np.ndarray, reach: int) -> None:
    for places in range(1, min(reach, len(positions) - 1) + 1):
        apart = np.any(positions[places:] != positions[:-places], axis=1)
        if not apart.all():
            i = int(np.argmin(apart))
            raise SceneError(
                "positions", Words(f"spheres {i} and {i + places}"), "must not coincide"
            )


def _native(
    slips: list[GivenSlip],
    positions: np.ndarray,
    frames: np.ndarray,
    reach: int,
    radius: float,
    finite_size: bool,
) -> np.ndarray:
    from nrchain.hydrodynamics.pairs import SlipFlow

    twists = np.zeros((len(positions), 6))
    flow = SlipFlow(
        [slip.label for slip in slips],
        [slip.strengths for slip in slips],
        [tuple(slip.axis) for slip in slips],
        count=len(positions),
        reach=reach,
        radius=radius,
        finite_size=finite_size,
    )
    flow.add_twists(positions, frames, twists)
    return twists


def _through_pystokes(
    slips: list[GivenSlip],
    positions: np.ndarray,
    frames: np.ndarray,
    neighbours: int | Literal["all"],
    radius: float,
    viscosity: float,
    finite_size: bool,
) -> np.ndarray:
    from nrchain.hydrodynamics import pystokes_backend

    velocities, spins = pystokes_backend.twists(
        positions,
        [np.einsum("b,nbk->nk", slip.axis, frames) for slip in slips],
        [slip.strengths for slip in slips],
        neighbours=neighbours,
        radius=radius,
        viscosity=viscosity,
        finite_size=finite_size,
        labels=[slip.label for slip in slips],
    )
    return np.concatenate([velocities, spins], axis=1)


def _read_chain(
    positions: Any,
    frames: Any,
    spacing: float,
    stretch: float,
    shear: float,
    twist: float,
    bend: float,
    ends: Any,
    measure: Any,
) -> tuple[np.ndarray, np.ndarray, Elasticity]:
    """Checked poses, and the elastic energy with these moduli."""
    r, e = _poses(positions, frames)
    if len(r) < 2:
        raise SceneError("positions", r.shape, "a chain has at least two spheres")
    choice(Ends)("ends", ends)
    choice(Measure)("measure", measure)
    d = number(above=0)("spacing", spacing)
    named = {"stretch": stretch, "shear": shear, "twist": twist, "bend": bend}
    moduli = [number(least=0)(name, value) for name, value in named.items()]
    if ends == "periodic" and any(moduli[:2]):
        r = unwrapped(r, d)
    period, isotropic = len(r) * d if ends == "periodic" else 0.0, measure == "isotropic"
    return r, e, Elasticity(d, period, tuple(moduli), isotropic, terms_of(moduli))


def elastic_wrenches(
    positions: np.ndarray,
    frames: np.ndarray,
    *,
    spacing: float,
    stretch: float,
    shear: float,
    twist: float,
    bend: float,
    ends: Literal["free", "clamped", "periodic"] = "free",
    measure: Literal["paper", "isotropic"] = "paper",
) -> tuple[np.ndarray, np.ndarray]:
    """F_i = −∂V/∂r_i and T_i = −Σ_a e_a × ∂V/∂e_a of the elastic chain (paper, Appendix B).

    Parameters
    ----------
    positions, frames
        (N, 3) and (N, 3, 3), N ≥ 2; ``frames[i, k]`` is e_{k+1} of sphere i in lab components.
    spacing
        Rest distance d.
    stretch, shear, twist, bend
        The moduli λ∥, λ⊥, μ∥ and μ⊥; a zero modulus leaves its term out.
    ends
        ``"periodic"`` closes the chain along x with period N d. ``"free"`` and ``"clamped"`` chains
        have the same energy. Positions of a periodic chain may be wrapped: each link takes the
        image nearest to its rest length along x (:func:`nrchain.scene.unwrapping.unwrapped`).
    measure
        Measure of twist and bend: the paper's, or the transversely isotropic one with the same
        linear response (see :mod:`nrchain.potential.chain`).

    Returns
    -------
    forces, torques
        (N, 3) each, lab frame. On an open chain the forces and the torques about the origin sum
        to zero.

    Raises
    ------
    SceneError
        For input of the wrong shape, numbers that are not finite or out of bounds, wrapped
        positions with an ambiguous image, and results beyond the range of floats.

    >>> import numpy as np
    >>> r, e = np.outer(np.arange(3.0), [11.0, 0.0, 0.0]), np.tile(np.eye(3), (3, 1, 1))
    >>> moduli = {"stretch": 20.0, "shear": 20.0, "twist": 100.0, "bend": 100.0}
    >>> forces, torques = elastic_wrenches(r, e, spacing=10.0, **moduli)
    >>> bool(forces[0, 0] > 0.0 > forces[2, 0])  # a stretched chain contracts
    True
    """
    r, e, elasticity = _read_chain(
        positions, frames, spacing, stretch, shear, twist, bend, ends, measure
    )
    wrenches = np.zeros((len(r), 6))
    with np.errstate(all="ignore"):
        elasticity.add_wrenches(r, e, wrenches)
    forces, torques = wrenches[:, :3].copy(), wrenches[:, 3:].copy()
    return _in_range("forces", forces), _in_range("torques", torques)


def elastic_energy(
    positions: np.ndarray,
    frames: np.ndarray,
    *,
    spacing: float,
    stretch: float,
    shear: float,
    twist: float,
    bend: float,
    ends: Literal["free", "clamped", "periodic"] = "free",
    measure: Literal["paper", "isotropic"] = "paper",
) -> float:
    """V = Σ_links (stretch + shear + twist + bend) of the elastic chain (paper, Appendix B).

    Arguments and errors as for :func:`elastic_wrenches`.

    >>> import numpy as np
    >>> r, e = np.outer(np.arange(3.0), [10.0, 0.0, 0.0]), np.tile(np.eye(3), (3, 1, 1))
    >>> moduli = {"stretch": 20.0, "shear": 20.0, "twist": 100.0, "bend": 100.0}
    >>> float(elastic_energy(r, e, spacing=10.0, **moduli))
    0.0
    """
    r, e, elasticity = _read_chain(
        positions, frames, spacing, stretch, shear, twist, bend, ends, measure
    )
    with np.errstate(all="ignore"):
        energy = elasticity.energy(r, e)
    return float(_in_range("energy", np.array(energy)))
