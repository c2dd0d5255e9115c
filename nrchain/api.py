"""Forces and torques from arrays, for scripts: pair laws and elastic chain by themselves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from nrchain import slip_modes
from nrchain.errors import SceneError
from nrchain.scene import Slip


def _array(name: str, given: Any, shape: tuple[int | None, ...]) -> np.ndarray:
    try:
        array = np.asarray(given, float, order="C")
    except (TypeError, ValueError):
        raise SceneError(name, given, f"must be numbers of shape {_named(shape)}") from None
    matches = array.ndim == len(shape) and all(
        want in (None, have) for want, have in zip(shape, array.shape, strict=False)
    )
    if not matches:
        raise SceneError(name, array.shape, f"the shape must be {_named(shape)}")
    if not np.isfinite(array).all():
        raise SceneError(name, "NaN or inf", "all numbers must be finite")
    return array


def _named(shape: tuple[int | None, ...]) -> str:
    return "(" + ", ".join("N" if size is None else str(size) for size in shape) + ")"


def _poses(positions: Any, frames: Any) -> tuple[np.ndarray, np.ndarray]:
    r = _array("positions", positions, (None, 3))
    e = _array("frames", frames, (len(r), 3, 3))
    gram = np.einsum("nak,nbk->nab", e, e)
    if np.abs(gram - np.eye(3)).max(initial=0.0) > 1e-8 or np.linalg.det(e).min(initial=1.0) < 0:
        raise SceneError(
            "frames", "not rotations", "rows must be orthonormal and right-handed to 1e-8"
        )
    return r, e


def _number(name: str, value: Any, least: float, *, strict: bool) -> float:
    ok = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not ok or not math.isfinite(value) or value < least or (strict and value == least):
        bound = "more than" if strict else "at least"
        raise SceneError(name, value, f"must be a finite number of {bound} {least:g}")
    return float(value)


def _choice(name: str, value: Any, allowed: tuple[Any, ...]) -> None:
    if value not in allowed:
        raise SceneError(name, value, f"must be one of {', '.join(map(repr, allowed))}")


def _reach(neighbours: Any, count: int) -> int:
    if neighbours == "all":
        return max(count - 1, 1)
    whole = isinstance(neighbours, int | np.integer) and not isinstance(neighbours, bool)
    if not whole or neighbours < 1:
        raise SceneError("neighbours", neighbours, 'must be a whole number of at least 1, or "all"')
    return int(neighbours)


def active_wrenches(
    positions: np.ndarray,
    frames: np.ndarray,
    slip: Mapping[str, float | np.ndarray | Slip],
    *,
    neighbours: int | Literal["all"] = 1,
    radius: float = 1.0,
    viscosity: float = 1.0,
    finite_size: bool = False,
    backend: Literal["native", "pystokes"] = "native",
) -> tuple[np.ndarray, np.ndarray]:
    """F_i = γ_T Σ_j u(r_i − r_j, e_j) and T_i = γ_R Σ_j w(r_i − r_j, e_j): what slip exerts.

    Parameters
    ----------
    positions, frames
        (N, 3) and (N, 3, 3); ``frames[i, k]`` is e_{k+1} of sphere i in lab components.
    slip
        Strength of each mode by its label: a number, an (N,) array, or a
        :class:`~nrchain.scene.Slip` with a body axis of its own (default e1).
    neighbours
        Spheres up to this many places along the chain act on each other; ``"all"``: every pair.
    radius, viscosity
        a and η, in γ_T = 6πηa and γ_R = 8πηa³.
    finite_size
        Keep the (a/r)² correction of the 2s velocity, (1 + a²∇²/6)(1 + a²∇²/10).
    backend
        ``"native"``: compiled closed forms; ``"pystokes"``: the same through PyStokes.

    Returns
    -------
    forces, torques
        (N, 3) each, lab frame.

    Raises
    ------
    SceneError
        For input of the wrong shape, non-finite numbers, unknown modes and coincident spheres.
    BackendError
        When PyStokes is missing, of an unknown release, or fails its self-check.

    Paper: Eqs. (2s_force) to (4a_torque), with the 4a torque as half the curl of its force law.
    """
    r, e = _poses(positions, frames)
    count = len(r)
    a = _number("radius", radius, 0.0, strict=True)
    eta = _number("viscosity", viscosity, 0.0, strict=True)
    _choice("backend", backend, ("native", "pystokes"))
    reach = _reach(neighbours, count)
    labels, strengths, axes = [], [], []
    for label, given in slip.items():
        slip_modes.find(label)
        mode = given if isinstance(given, Slip) else None
        strength = np.asarray(given if mode is None else mode.strength, float)
        shape = () if strength.ndim == 0 else (count,)
        strengths.append(np.broadcast_to(_array(f"slip[{label!r}]", strength, shape), (count,)))
        labels.append(label)
        axes.append((1.0, 0.0, 0.0) if mode is None else mode.axis)
    _refuse_coincident(r, reach)
    if backend == "native":
        twists = _native(labels, strengths, axes, r, e, reach, a, finite_size)
    else:
        twists = _through_pystokes(labels, strengths, axes, r, e, neighbours, a, eta, finite_size)
    gamma = 6 * math.pi * eta * a
    return gamma * twists[:, :3], gamma * (4 * a * a / 3) * twists[:, 3:]


def _refuse_coincident(positions: np.ndarray, reach: int) -> None:
    for places in range(1, min(reach, len(positions) - 1) + 1):
        apart = np.any(positions[places:] != positions[:-places], axis=1)
        if not apart.all():
            i = int(np.argmin(apart))
            raise SceneError(
                "positions", f"spheres {i} and {i + places}", "two spheres are at one place"
            )


def _native(labels, strengths, axes, positions, frames, reach, radius, finite_size):
    from nrchain.hydrodynamics.pairs import SlipFlow

    twists = np.zeros((len(positions), 6))
    flow = SlipFlow(
        labels,
        strengths,
        axes,
        count=len(positions),
        reach=reach,
        radius=radius,
        finite_size=finite_size,
    )
    if flow and len(positions) > 1:
        flow.add_twists(positions, frames, twists)
    return twists


def _through_pystokes(
    labels, strengths, axes, positions, frames, neighbours, radius, viscosity, finite_size
):
    from nrchain.hydrodynamics import pystokes

    units = [np.asarray(axis, float) / np.linalg.norm(axis) for axis in axes]
    velocities, spins = pystokes.twists(
        positions,
        [np.einsum("b,nbk->nk", unit, frames) for unit in units],
        strengths,
        neighbours=neighbours,
        radius=radius,
        viscosity=viscosity,
        finite_size=finite_size,
        labels=labels,
    )
    return np.concatenate([velocities, spins], axis=1)


def _read_chain(positions, frames, spacing, stretch, shear, twist, bend, ends, measure):
    r, e = _poses(positions, frames)
    if len(r) < 2:
        raise SceneError("positions", r.shape, "a chain has at least two spheres")
    _choice("ends", ends, ("free", "clamped", "periodic"))
    _choice("measure", measure, ("paper", "isotropic"))
    d = _number("spacing", spacing, 0.0, strict=True)
    named = {"stretch": stretch, "shear": shear, "twist": twist, "bend": bend}
    moduli = [_number(name, value, 0.0, strict=False) for name, value in named.items()]
    from nrchain.effects.cosserat import Elasticity, terms_of

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
        The moduli λ∥, λ⊥, μ∥ and μ⊥; zero leaves a term out.
    ends
        ``"periodic"`` closes the chain along x with period N d; ``"free"`` and ``"clamped"``
        chains have the same forces (a clamp holds poses, it does not change the energy).
    measure
        Of twist and bend: the paper's, or the transversely isotropic one with the same linear
        response (see :mod:`nrchain.effects.cosserat`).

    Returns
    -------
    forces, torques
        (N, 3) each, lab frame. On an open chain both sum to nothing, torques about the origin
        included.
    """
    r, e, elasticity = _read_chain(
        positions, frames, spacing, stretch, shear, twist, bend, ends, measure
    )
    wrenches = np.zeros((len(r), 6))
    elasticity.add_wrenches(r, e, wrenches)
    return wrenches[:, :3].copy(), wrenches[:, 3:].copy()


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

    Arguments as for :func:`elastic_wrenches`.
    """
    r, e, elasticity = _read_chain(
        positions, frames, spacing, stretch, shear, twist, bend, ends, measure
    )
    return elasticity.energy(r, e)
