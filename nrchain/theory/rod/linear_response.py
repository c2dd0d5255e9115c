"""w(∂) (u, φ) = Σ_n w_n ∂ⁿ(u, φ)/∂sⁿ: moduli from the Jacobian blocks of the simulation.

The linearised wrench per length on the spheres of a straight chain is expanded in gradients of u
and φ. The coefficients are moments of the Jacobian blocks, summed over all neighbours of the scene,
in closed form for all pairs. The moduli are those with which the linearised rod,

    F′ + f⋆,     M′ + r′ × F + m⋆,     ε = u′ + x̂ × φ,  τ = φ′,

has the same terms in u′, u″, φ, φ′ and φ″. Terms in u‴, of the order of those in φ″, are dropped as
in the paper. The prestress is half of what the right of a cut exerts on the left less what the left
exerts on the right, with torques about the own sphere. Sources are what is left.

Active wrenches are the friction of a sphere times the twist that slip gives it. With friction
between spheres they are the friction matrix of the chain times these twists.

All pairs: where the m-th neighbours contribute as 1/m, the sum ends at the wavelength. Σ 1/m is
then Σ 2(1 − cos mθ)/(m³θ²) → 3/2 − ln θ for θ = qd → 0, and the entry is value + coefficient ·
ln(1/qd).

Source: paper, Sec. "Linearized elastohydrodynamics" and Appendix C, for nearest neighbours and axes
along e₁; here for any mode, axis and reach.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain.effects.shared.image_sums import refuse_reach
from nrchain.errors import SceneError
from nrchain.scene.checks import NO_SUM
from nrchain.scene.scene import Scene
from nrchain.theory.lattice_sums import MOST_TERMS, Reach, power_sum
from nrchain.theory.line_mobility import LineMobility, Sides
from nrchain.theory.line_slip import add_powers, slip_powers
from nrchain.theory.rod.constants import TURN, Constants, cross
from nrchain.theory.rod.uniform_scene import body_wrench, uniform_slip
from nrchain.theory.straight_chain import elastic_row

ORDERS = 3
"""Gradients kept: 0 to 2."""

CANCELLED = 1e-12
"""Relative size at which the sum of the two sides counts as rounding."""

ROUNDING = 1e-14
"""Relative error of the sum over the neighbours on one side."""


def active_constants(
    scene: Scene, resistance: np.ndarray
) -> tuple[Constants, Constants, Constants]:
    """Constants of the slip and of fields, coefficients of ln(1/qd), and bounds of their errors.

    ``resistance`` is that of :func:`resistance_gradients`.
    """
    d, reach = scene.chain.spacing, scene.slip.neighbours
    body, (twists, blocks) = body_wrench(scene) / d, _all_slip(scene)
    velocity, v_size = _moments(twists, (6,), d, reach)
    change, c_size = _moments(blocks, (6, 6), d, reach)
    # a uniform displacement of all spheres changes nothing
    change[:, 0, :, :3] = c_size[0, :, :3] = 0.0
    # derivatives in the moving frame: δ(v, ω) − φ × (v, ω)
    change[:, 0, :, 3:] += _crossed(velocity[:, 0])
    wrench, response = _product(resistance, velocity), _product(resistance, change)
    response[:, 0, :, 3:] -= _crossed(wrench[:, 0])
    value, logarithm = (_match(wrench[k], response[k]) for k in range(2))
    value = Constants(value.C, value.H, value.prestress, value.presource + body)
    v_size, c_size = (
        ROUNDING * _product(np.abs(resistance), size[None])[0] for size in (v_size, c_size)
    )
    return value, logarithm, _match(v_size, c_size, absolute=True)


def _all_slip(scene: Scene) -> tuple[Sides, Sides]:
    """Twists and blocks of all modes together, by powers of the distance."""
    refuse_reach(scene, "slip.neighbours", scene.slip.neighbours, MOST_TERMS)
    if scene.slip.neighbours == "all" and not scene.slip_has_sum:
        raise SceneError("slip.neighbours", "all", NO_SUM)
    twists: Sides = {}
    blocks: Sides = {}
    for label, slip in uniform_slip(scene).items():
        for total, share in zip((twists, blocks), slip_powers(scene, label, slip), strict=True):
            add_powers(total, share)
    return twists, blocks


def _moments(
    sides: Sides, shape: tuple[int, ...], spacing: float, reach: Reach
) -> tuple[np.ndarray, np.ndarray]:
    """Σ_m (±md)ⁿ/n! of both sides (2, n, 6, …), and the sum (n, 6, …) of the absolute values.

    Row 0 is the value, row 1 the coefficient of ln(1/qd). Sums that diverge more strongly are 0 by
    symmetry, or belong to flows of order 1/r.
    """
    total, size = np.zeros((2, ORDERS, *shape)), np.zeros((ORDERS, *shape))
    for power, (right, left) in sides.items():
        for n in range(ORDERS):
            scale = spacing**n / math.factorial(n)
            both = right + (-1.0) ** n * left
            both[np.abs(both) <= CANCELLED * (np.abs(right) + np.abs(left))] = 0.0
            value, coefficient = _sum(power - n, reach)
            total[0, n] += scale * value * both
            total[1, n] += scale * coefficient * both
            size[n] += scale * abs(value) * (np.abs(right) + np.abs(left))
    return total, size


def _sum(power: int, reach: Reach) -> tuple[float, float]:
    """Σ 1/m^p as value + coefficient · ln(1/qd)."""
    if reach != "all" or power > 1:
        return power_sum(power, reach), 0.0
    return (1.5, 1.0) if power == 1 else (0.0, 0.0)


def resistance_gradients(scene: Scene) -> np.ndarray:
    """ζ_n/d (n, 6, 6): the friction matrix of the chain per length in gradients, Σ ζ_n ∂ⁿ.

    Raises :class:`~nrchain.errors.SceneError` for friction between all pairs.
    """
    zeta = np.zeros((ORDERS, 6, 6))
    own = np.diag(1.0 / np.repeat(scene.drag, 3))
    if scene.friction.kind == "one-body":
        zeta[0] = np.linalg.inv(own)
        return zeta / scene.chain.spacing
    reach = scene.friction.neighbours
    if reach == "all":
        allowed = (
            "the drag per length of an infinite chain falls as 1/ln of the wavelength: moduli have"
            " no limit; use a number"
        )
        raise SceneError("friction.neighbours", reach, allowed)
    refuse_reach(scene, "friction.neighbours", reach, MOST_TERMS)
    powers = LineMobility(scene.chain, reach).powers
    mobility = _moments(powers, (6, 6), scene.chain.spacing, reach)[0][0]
    mobility[0] += own
    zeta[0] = np.linalg.inv(mobility[0])
    for n in range(1, ORDERS):
        zeta[n] = -zeta[0] @ sum(mobility[k] @ zeta[n - k] for k in range(1, n + 1))
    return zeta / scene.chain.spacing


def _product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Σ_k left_k right_{n−k} of two series in gradients; ``right`` is (2, n, 6, …)."""
    total = np.zeros_like(right)
    for n in range(right.shape[1]):
        for k in range(n + 1):
            total[:, n] += np.einsum("ij,sj...->si...", left[k], right[:, n - k])
    return total


def _crossed(pairs: np.ndarray) -> np.ndarray:
    """The matrices (…, 6, 3) of φ ↦ (v × φ, ω × φ) for pairs (…, 6)."""
    matrices = np.zeros((*pairs.shape, 3))
    for index in np.ndindex(pairs.shape[:-1]):
        matrices[index] = np.concatenate([cross(pairs[index][:3]), cross(pairs[index][3:])])
    return matrices


def _match(wrench: np.ndarray, response: np.ndarray, absolute: bool = False) -> Constants:
    """The constants of the rod with these coefficients of ∂ⁿ: of w (n, 6) and w(u, φ) (n, 6, 6).

    With ``absolute``, all terms add up: bounds of the errors, from bounds of the coefficients.
    """
    size, sign = (np.abs, 1.0) if absolute else (np.asarray, -1.0)
    turn = size(TURN)
    F, M = 0.5 * wrench[1, :3], 0.5 * wrench[1, 3:]
    C, H = response[2].copy(), response[1].copy()
    tension, couple = size(cross(F)), size(cross(M))
    H[:3, 3:] += sign * C[:3, :3] @ turn + tension
    H[3:, :3] += sign * turn @ C[:3, :3] + tension
    H[3:, 3:] += sign * (C[3:, :3] @ turn + turn @ C[:3, 3:]) + couple
    presource = wrench[0].copy()
    presource[3:] += sign * turn @ F
    return Constants(C, H, np.concatenate([F, M]), presource)


def elastic_constants(scene: Scene) -> tuple[Constants, Constants]:
    """Constants of the elasticity, and bounds of their errors."""
    row, d = elastic_row(scene, scene.moduli), scene.chain.spacing
    offsets = d * (np.arange(len(row)) - len(row) // 2)
    weights = np.array([offsets**n / (math.factorial(n) * d) for n in range(ORDERS)])
    series = np.einsum("nm,mij->nij", weights, row)
    bound = ROUNDING * np.einsum("nm,mij->nij", np.abs(weights), np.abs(row))
    none = np.zeros((ORDERS, 6))
    return _match(none, series), _match(none, bound, absolute=True)
