"""Λ(q): the plane waves u_i, φ_i ∝ exp(i q d i + Λ t) of the infinite straight chain of a scene.

The operator is built from the analytic Jacobian blocks of the simulation itself, taken on a
straight stretch of chain: with B_m = ∂(v, ω)_i / ∂(u, φ)_{i+m},

    M(q) = Σ_m B_m e^{imqd},      Λ = the eigenvalues of M,

for overdamped motion. Elasticity gives wrenches K(q), which friction turns into twists; slip adds
twists: M = μ(q) K(q) + Σ_slip. One-body friction has 1/γ_T and 1/γ_R on the diagonal of μ; friction
between spheres adds the Fourier sum of the pair mobilities. The infinite sums over all pairs are
exact to rounding: on a line the blocks of a slip flow and the mobilities are sums of pure powers of
the distance (:mod:`nrchain.theory.lattice_sums`). Forces between spheres sum to zero: the 1/r term
of the mobilities converges at every q > 0 and vanishes at q = 0. A uniform force on every sphere
adds Σ_m ∂(μ_m·F), which converges; the velocity due to it converges only if friction is cut. The
number of spheres of the scene has an effect only through its stiffness rule.

Frames. i is the index of a sphere, a material coordinate: a chain that translates at V0 is
described in a frame that moves with it; in coordinates fixed in space Λ becomes Λ − i q V0. A chain
that spins at Ω0 about its axis has φ̇ = δω + Ω0 × φ in the lab (``frame="lab"``), where u and φ
have lab components. In components along axes that spin with it (``frame="spinning"``), u̇ = δv − Ω0
× u and φ̇ = δω. The spin Ω0 x̂ multiplies a wave of hand ±, w_y ± i w_z for w = u and φ, by e^{±iΩ0
t}:

    Λ(lab) = Λ(spinning) ± i Ω0    for the branches of hand ±,

and the same Λ for the longitudinal ones. Rates and phase velocities read from the displacements of
a simulated chain are those of the lab.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nrchain.effects.shared.image_sums import has_sum
from nrchain.errors import SceneError
from nrchain.inputs.arguments import finite_array
from nrchain.scene.loading import load_scene, require_scene
from nrchain.scene.scene import Scene
from nrchain.theory.eigenvalues import matched_eigenvalues, two_branches
from nrchain.theory.lattice_sums import Reach, power_sum
from nrchain.theory.straight_chain import Complex, StraightChain

Frame = Literal["lab", "spinning"]

WAVENUMBERS = 64
"""Number of wavenumbers, from π/(N d) to π/d, that are tested for growth."""


class Branch(IntEnum):
    """The columns of :func:`lattice_rates`.

    BEND and SHEAR are the acoustic and the optical transverse branch. PLUS is the hand of waves in
    w_y + i w_z, on which x̂ × acts as +i: for q > 0 the right-handed helix (cos qx, sin qx); MINUS
    is the opposite hand. A change of sign of q swaps the hands: Λ_PLUS(−q) is the conjugate of
    Λ_MINUS(q).

    Within a hand, BEND is the branch that becomes the unsheared wave, in which the tangent follows
    e_1, as its coupling to shear vanishes; SHEAR is the other branch. For q → 0 the BEND
    rate vanishes and the SHEAR rate is the gap. STRETCH is the wave of u_x; TWIST that of φ_x.

    >>> from nrchain import lattice_rates, load_scene
    >>> rates = lattice_rates(load_scene("buckling"), [0.01])
    >>> bool(rates[0, Branch.BEND_PLUS].real > 0.0)
    True
    """

    BEND_PLUS = 0
    BEND_MINUS = 1
    STRETCH = 2
    TWIST = 3
    SHEAR_PLUS = 4
    SHEAR_MINUS = 5

    @property
    def hand(self) -> int:
        """+1 or −1, and 0 for the longitudinal branches."""
        return 0 if self.name in ("STRETCH", "TWIST") else 1 if self.name.endswith("PLUS") else -1

    @property
    def spoken(self) -> str:
        """The name in a table or a picture, such as "bend +"."""
        return self.name.lower().replace("_plus", " +").replace("_minus", " −")


def chain_waves(scene: Scene) -> NDArray[np.float64]:
    """q (WAVENUMBERS,), from π/(N d) (half a wave on the chain) to π/d (a wave of two spheres)."""
    count, d = scene.chain.particles, scene.chain.spacing
    return np.linspace(math.pi / (count * d), math.pi / d, WAVENUMBERS)


def lattice_rates(scene: Scene, wavenumbers: ArrayLike, *, frame: Frame = "lab") -> Complex:
    """Λ(q) (..., 6) of the infinite straight chain, in the columns of :class:`Branch`.

    Parameters
    ----------
    wavenumbers
        q, in 1/length: qd is the phase from one sphere to the next. Any shape.
    frame
        ``"lab"`` or ``"spinning"``, see the module; they differ if the chain spins.

    The relative error is 1e-15 at any stiffness against stretch and shear, and about 3e-15/(qd)²
    for the bending waves of 3a, whose force cancels to that order. Body axes other than ±e_1 make
    the chain anisotropic and mix the hands: each column is then the branch with the largest share
    in that of the isotropic chain, and the error is 1e-16 of the largest rate.

    Raises :class:`~nrchain.errors.SceneError` for strengths that differ between spheres, a straight
    chain that is not a steady state, a sum that diverges, and a cut mobility that is not positive
    definite, which may happen if spheres nearly touch.

    >>> lattice_rates(load_scene("buckling"), [0.01, 0.02]).shape
    (2, 6)
    """
    chain, phases = _read(scene, wavenumbers)
    soft = chain.soft_operator(phases)
    _add_spin(chain, soft, frame)
    reduced = _reduce(chain, soft, phases)
    if not chain.isotropic:
        return matched_eigenvalues(reduced)
    rates = np.empty((*phases.shape, 6), complex)
    for bend, shear in (
        (Branch.BEND_PLUS, Branch.SHEAR_PLUS),
        (Branch.BEND_MINUS, Branch.SHEAR_MINUS),
    ):
        a, b = reduced[..., bend, bend], reduced[..., bend, shear]
        c, d = reduced[..., shear, bend], reduced[..., shear, shear]
        rates[..., bend], rates[..., shear] = two_branches(a, b, c, d)
    # rotating a sphere about its own axis does not change its flow: u_x and φ_x are triangular
    for branch in (Branch.STRETCH, Branch.TWIST):
        rates[..., branch] = reduced[..., branch, branch]
    return rates


def lattice_operator(scene: Scene, wavenumbers: ArrayLike, *, frame: Frame = "lab") -> Complex:
    """M(q) (..., 6, 6) with d/dt (u, φ) = M (u, φ), in cartesian components.

    Arguments and errors as for :func:`lattice_rates`.

    >>> lattice_operator(load_scene("buckling"), 0.01).shape
    (6, 6)
    """
    chain, phases = _read(scene, wavenumbers)
    operator = chain.soft_operator(phases)
    _add_spin(chain, operator, frame)
    stiff = chain.elastic(phases, (scene.moduli.stretch, scene.moduli.shear, 0.0, 0.0))
    return operator + chain.mobility(phases) @ stiff


def steady_velocity(scene: Scene) -> NDArray[np.float64]:
    """V0 (3,): the velocity at which the infinite straight chain translates, frames along the lab.

    All pairs give ζ(3) = 1.202 times the nearest-neighbour value for 3t (paper, Eq. 3t_vel).
    Errors as for :func:`lattice_rates`.

    >>> round(float(steady_velocity(load_scene("wave"))[0]), 3)
    0.8
    """
    return StraightChain(scene).twist[:3]


def steady_rotation(scene: Scene) -> NDArray[np.float64]:
    """Ω0 (3,), along x: the angular velocity at which the infinite straight chain spins.

    All pairs give ζ(5) = 1.037 times the nearest-neighbour value for 4a (paper, Eq. 4a_ang_vel).
    Errors as for :func:`lattice_rates`.

    >>> round(float(steady_rotation(load_scene("spiral-left"))[0]), 2)
    -7.26
    """
    return StraightChain(scene).twist[3:]


def steady_stress(scene: Scene, spheres: int | None = None) -> NDArray[np.float64]:
    """(F, T) (6,): the slip force and torque of all spheres right of a cut on all left of it.

    γ_T and γ_R times the induced velocities and angular velocities, with each torque about its own
    sphere. For modes that propel the chain, the action of left on right is different. Right on left
    is the sign of a stress and of the paper's prestress (Eq. 2s_prestress); the paper's pre-moment
    (Eq. 3a_pretorque) is left on right.

    ``spheres`` is the number on either side, infinite if None. A pair at distance m crosses m cuts:
    all pairs of an infinite 2s chain give an infinite force. Friction between spheres, fields and
    flows are not included. Errors as for :func:`lattice_rates`.

    >>> steady_stress(load_scene("buckling")).shape
    (6,)
    """
    alone = {name: None for name in require_scene(scene).further}
    chain = StraightChain(load_scene(scene, friction="one-body", **alone))
    friction = np.repeat(scene.drag, 3)
    stress = np.zeros(6)
    for power, sides in chain.twists.items():
        pairs = _crossing_pairs(power, chain.reach, spheres)
        acting = sides[0] != 0.0
        stress[acting] += (friction * sides[0])[acting] * pairs
    return stress


def _read(scene: Scene, wavenumbers: ArrayLike) -> tuple[StraightChain, NDArray[np.float64]]:
    """The chain and the phases qd."""
    waves = finite_array("wavenumbers", wavenumbers)
    return StraightChain(scene), waves * scene.chain.spacing


def _crossing_pairs(power: int, reach: Reach, spheres: int | None) -> float:
    """Σ over the pairs across a cut of 1/m^power."""
    if spheres is None:
        return power_sum(power - 1, reach)
    longest = 2 * spheres - 1 if reach == "all" else min(reach, 2 * spheres - 1)
    m = np.arange(1.0, longest + 1)
    return float(np.sum(np.minimum(m, 2 * spheres - m) * m**-power))


def _add_spin(chain: StraightChain, operator: Complex, frame: Frame) -> None:
    """Add Ω0 × φ (lab) or −Ω0 × u (spinning axes) to M, in place."""
    spin = chain.twist[3]
    if spin and chain.turning and chain.fixed:
        allowed = (
            "rotates the anisotropy of the chain relative to that of the lab: no axes have steady"
            " coefficients"
        )
        raise SceneError("steady rotation", float(spin), allowed)
    if frame == "lab":
        if spin and chain.turning:
            allowed = (
                "an anisotropic chain that spins has steady coefficients only in axes that"
                " spin with it: use frame='spinning'"
            )
            raise SceneError("frame", frame, allowed)
        operator[..., 4, 5] -= spin
        operator[..., 5, 4] += spin
    elif frame == "spinning":
        if spin and chain.fixed:
            allowed = (
                "a chain that spins in an anisotropic field or flow has steady coefficients only in"
                " the lab: use frame='lab'"
            )
            raise SceneError("frame", frame, allowed)
        operator[..., 1, 2] += spin
        operator[..., 2, 1] -= spin
    else:
        raise SceneError("frame", frame, "must be 'lab' or 'spinning'")


def _reduce(chain: StraightChain, soft: Complex, phases: np.ndarray) -> Complex:
    """Q† L⁻¹ M L Q with L L† = μ, in the order of :class:`Branch`.

    Stretch and shear act on three strains alone, −μ g g†. In a unitary basis of the strains L† g
    and the directions across them, the stiffness is in three diagonal entries. The other rates are
    then as exact as without it.
    """
    moduli, root = chain.scene.moduli, _root(chain, phases)
    adjoint = root.conj().swapaxes(-1, -2)
    basis = np.zeros((*phases.shape, 6, 6), complex)
    basis[..., 0, Branch.STRETCH] = basis[..., 3, Branch.TWIST] = 1.0
    stretch, shear = (
        adjoint @ chain.elastic(phases, tuple(alone)) @ root for alone in np.eye(len(moduli))[:2]
    )
    stiff = {Branch.STRETCH: moduli.stretch * stretch[..., 0, 0].real}
    for hand, bend, sheared in (
        (1, Branch.BEND_PLUS, Branch.SHEAR_PLUS),
        (-1, Branch.BEND_MINUS, Branch.SHEAR_MINUS),
    ):
        # fields w with w_y ∓ i w_z = 0 and x̂ × w = ± i w
        unit = np.zeros((6, 2), complex)
        unit[1, 0] = unit[4, 1] = math.sqrt(0.5)
        unit[2, 0] = unit[5, 1] = -1j * hand * math.sqrt(0.5)
        pair = unit.conj().T @ shear @ unit
        larger = np.argmax(np.abs([pair[..., 0, 0], pair[..., 1, 1]]), axis=0)
        strain = np.take_along_axis(pair, larger[..., None, None], axis=-1)[..., 0]
        strain /= np.linalg.norm(strain, axis=-1, keepdims=True)
        across = np.stack([strain[..., 1].conj(), -strain[..., 0].conj()], axis=-1)
        basis[..., sheared] = strain @ unit.T
        basis[..., bend] = across @ unit.T
        stiff[sheared] = moduli.shear * np.trace(pair, axis1=-2, axis2=-1).real
    reduced = basis.conj().swapaxes(-1, -2) @ np.linalg.solve(root, soft @ root) @ basis
    for branch, rate in stiff.items():
        reduced[..., branch, branch] += rate
    return reduced


def _root(chain: StraightChain, phases: np.ndarray) -> Complex:
    """L of μ = L L†, which separates the hands, and along x from across, as μ does."""
    try:
        return np.linalg.cholesky(chain.mobility(phases)).astype(complex, copy=False)
    except np.linalg.LinAlgError:
        allowed = (
            "the cut mobility of spheres this close is not positive definite: use more neighbours"
        )
        if has_sum(chain.scene, "friction.neighbours"):
            allowed += ", or 'all'"
        reach = chain.scene.friction.neighbours
        raise SceneError("friction.neighbours", reach, allowed) from None
