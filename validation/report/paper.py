"""The equations of the paper as printed, in plain NumPy.

n is the unit vector from the acting to the feeling sphere (the paper prints its length), r their
distance, e the axis of the acting sphere, c = e·n and V the strength. One equation is not as
printed: the torque of 4a is half the curl of its force (see :func:`printed_4a_spin`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LABELS = ("2s", "3a", "3t", "4a")
VELOCITY_POWER = {"2s": 2, "3a": 3, "3t": 3, "4a": 4}
"""k of u ∝ (a/r)^k."""
EQUATIONS = {
    "2s": ("2s_force", "2s_torque"),
    "3a": ("3a_force", "3a_torque"),
    "3t": ("3t_force", "3t_torque"),
    "4a": ("4a_force", "4a_torque"),
}


def velocity(label: str, separation: Array, axis: Array, radius: float = 1.0) -> Array:
    """u/V = F/(γ_T V) at separations (M, 3) from a sphere with axis (3,): Eqs. (2s_force) …"""
    r, n, c = _polar(separation, axis)
    e, cross = axis[None, :], np.cross(axis, n)
    s = radius / r
    if label == "2s":
        return 7 / 6 * s**2 * (3 * c**2 - 1) * n
    if label == "3a":
        return 13 / 12 * s**3 * c * cross
    if label == "3t":
        return -1 / 5 * s**3 * (e - 3 * c * n)
    return 363 / 40 * s**4 * (1 - 5 * c**2) * cross


def spin(label: str, separation: Array, axis: Array, radius: float = 1.0) -> Array:
    """w/V = T/(γ_R V) at separations (M, 3): Eqs. (2s_torque) …, for 4a half the curl of u."""
    r, n, c = _polar(separation, axis)
    e, cross = axis[None, :], np.cross(axis, n)
    s = radius / r
    if label == "2s":
        return 7 / 2 * s**2 / r * c * cross
    if label == "3a":
        return 13 / 24 * s**3 / r * ((5 * c**2 - 1) * n - 2 * c * e)
    if label == "3t":
        return np.zeros_like(n)
    return 363 / 80 * s**4 / r * (-3 * e + 15 * (c * n + c**2 * e) - 35 * c**3 * n)


def printed_4a_spin(separation: Array, axis: Array) -> Array:
    """−3e + 15 [(e·n) n + (e·n)²] e − 35 (e·n)³ n, read with the bracket where it is printed.

    A bracket of a vector and a number has no meaning; as a factor of e the first term can only be
    contracted with it, (e·n)(n·e) e, and the bracket becomes 2c².
    """
    r, n, c = _polar(separation, axis)
    return 363 / 80 / r**5 * (-3 * axis + 30 * c**2 * axis - 35 * c**3 * n)


def finite_size_2s(separation: Array, axis: Array, radius: float = 1.0) -> Array:
    """(4a²/15) ∇²u = −(28/15)(a/r)⁴ [(5c² − 1) n − 2c e]: what a finite size adds to 2s.

    (1 + a²∇²/6)(1 + a²∇²/10) is 1 + (4/15) a²∇² on a biharmonic flow (Table active_force_torque).
    """
    r, n, c = _polar(separation, axis)
    return -28 / 15 * (radius / r) ** 4 * ((5 * c**2 - 1) * n - 2 * c * axis)


PolarSlip = Callable[[Array], tuple[Array, Array, Array]]
"""v_r, v_θ and v_φ over V at angles θ."""

SLIP: dict[str, PolarSlip] = {
    "2s": lambda t: (2 / 3 - np.sin(t) ** 2, -np.sin(2 * t) / 2, 0 * t),
    "3a": lambda t: (0 * t, 0 * t, np.sin(2 * t) / 18),
    "3t": lambda t: (np.cos(t) / 45, np.sin(t) / 45, 0 * t),
    "4a": lambda t: (0 * t, 0 * t, np.sin(t) * (np.cos(t) ** 2 - 1 / 5) / 60),
}
"""The slip on the sphere, as Table slip prints it."""


def slip_3t(theta: Array) -> tuple[Array, Array, Array]:
    """The slip of 3t with v_r = (2/45) V cos θ, whose mean is zero."""
    return 2 * np.cos(theta) / 45, np.sin(theta) / 45, 0 * theta


def slip_expansion(label: str, normal: Array, axis: Array) -> Array:
    """v_slip/V of Eq. (slip) at unit vectors (M, 3), with Y^(l) = (−1)^l ρ^{l+1} ∇^l ρ⁻¹.

    The tensors V are V(ee − I/3), V e and V(eee − the three symmetric e δ/5).
    """
    eye = np.eye(3)
    if label == "2s":
        return normal @ irreducible(2, axis)
    second = 3 * np.einsum("mi,mj->mij", normal, normal) - eye
    if label == "3t":
        return second @ axis / 15
    if label == "3a":
        return -np.einsum("abc,cd,mbd->ma", _EPSILON, irreducible(2, axis), second) / 9
    third = 15 * np.einsum("mi,mj,mk->mijk", normal, normal, normal)
    for pattern in ("mi,jk->mijk", "mj,ik->mijk", "mk,ij->mijk"):
        third -= 3 * np.einsum(pattern, normal, eye)
    return -np.einsum("abc,cde,mbde->ma", _EPSILON, irreducible(3, axis), third) / 60


def greens_function_velocity(label: str, separation: Array, axis: Array) -> Array:
    """F/(γ_T V) of Table active_force_torque at one separation (3,), a = 1, for a dilute pair.

    G = (I + nn)/8πηr; ∇ with respect to r_j is −∇ with respect to the separation.
    """

    def curl_g(x: Array) -> Array:
        return np.einsum("abc,bcd->ad", _EPSILON, _gradient(_stokeslet)(x))

    if label == "2s":
        slope = -_gradient(_stokeslet)(separation)
        return -28 / 3 / 8 * np.einsum("cab,bc->a", slope, irreducible(2, axis))
    if label == "3t":
        second = _gradient(_gradient(_stokeslet))(separation)
        return 4 / 5 / 8 * np.einsum("ccab,b->a", second, axis)
    if label == "3a":
        slope = _gradient(curl_g)(separation)
        return -13 / 9 / 8 * np.einsum("cab,bc->a", slope, irreducible(2, axis))
    second = -_gradient(_gradient(curl_g))(separation)
    return 121 / 10 / 8 * np.einsum("dcab,bcd->a", second, irreducible(3, axis))


def irreducible(rank: int, axis: Array) -> Array:
    """The symmetric traceless part of e…e: e, ee − I/3, or eee − (three terms e δ)/5."""
    e, eye = np.asarray(axis, float), np.eye(3)
    if rank == 1:
        return e
    if rank == 2:
        return np.outer(e, e) - eye / 3
    traces = sum(np.einsum(p, e, eye) for p in ("i,jk->ijk", "j,ik->ijk", "k,ij->ijk"))
    return np.einsum("i,j,k->ijk", e, e, e) - traces / 5


def half_curl(field: Callable[[Array], Array], points: Array, step: float = 3e-3) -> Array:
    """∇ × u / 2 at points (M, 3), by differences of the sixth order over ``step`` · distance.

    ``field`` takes all points of the stencil at once, (18 M, 3).
    """
    widths = step * np.linalg.norm(points, axis=1)
    moves = np.einsum("k,ij->kij", _OFFSETS, np.eye(3))
    stencil = points + np.einsum("kij,m->kimj", moves, widths)
    values = field(stencil.reshape(-1, 3)).reshape(stencil.shape)
    slopes = np.einsum("k,kima->mia", _WEIGHTS, values) / widths[:, None, None]
    return 0.5 * np.einsum("abc,mbc->ma", _EPSILON, slopes)


_OFFSETS = np.array([-3.0, -2.0, -1.0, 1.0, 2.0, 3.0])
_WEIGHTS = np.array([-1.0, 9.0, -45.0, 45.0, -9.0, 1.0]) / 60.0
_EPSILON = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _EPSILON[_i, _j, _k], _EPSILON[_i, _k, _j] = 1.0, -1.0


def _polar(separation: Array, axis: Array) -> tuple[Array, Array, Array]:
    r = np.linalg.norm(separation, axis=-1, keepdims=True)
    n = separation / r
    return r, n, (n @ axis)[..., None]


def _stokeslet(x: Array) -> Array:
    """8πη G."""
    r = np.linalg.norm(x)
    return np.eye(3) / r + np.outer(x, x) / r**3


def _gradient(field: Callable[[Array], Array], step: float = 0.02) -> Callable[[Array], Array]:
    """∂_i of a tensor field, i first, by differences of the sixth order."""

    def gradient(x: Array) -> Array:
        return np.stack(
            [
                sum(w * field(x + k * step * unit) for w, k in zip(_WEIGHTS, _OFFSETS, strict=True))
                / step
                for unit in np.eye(3)
            ]
        )

    return gradient
