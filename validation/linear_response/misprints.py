"""Misprints in the paper's linearised equations, each of the expected size.

A misprint is measured by the ratio of the printed term to that of the lattice operator, in the one
cell where it occurs. All other cells agree.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nrchain import Rod, Scene, lattice_operator, rod, steady_stress
from validation.linear_response.cells import cell
from validation.report.recorder import Recorder
from validation.report.uniform_chains import (
    FLUID,
    LIMP,
    SPACING,
    STRENGTHS,
    branch_rates,
    uniform_chain,
)

Complex = NDArray[np.complex128]

PHASE = 0.4
TINY = 1e-3
EXACT = 1e-10


def differences(recorder: Recorder) -> None:
    """Record every misprint of ``rod.MISPRINTS``, the sign of the pre-moment and the laws at q³."""
    _discrete_tables(recorder)
    _continuum_tables(recorder)
    _rotation_equation(recorder)
    _third_order_laws(recorder)


def _over_lattice(
    scene: Scene, name: str, row: str, column: str, entry: tuple[int, int], phase: float = PHASE
) -> complex:
    """An entry of the paper's discrete operator, as printed, over that of the lattice."""
    q = np.array([phase / SPACING])
    printed = rod.discrete_operator(Rod.of(scene), q, misprints=[name])[0]
    lattice = lattice_operator(scene, q)[0]
    return complex(cell(printed, row, column)[entry] / cell(lattice, row, column)[entry])


def _discrete_tables(recorder: Recorder) -> None:
    octupole = uniform_chain({"4a": STRENGTHS["4a"]}, FLUID)
    recorder.difference(
        "4a force of φ, printed over lattice: a sum for a difference, −i cot qd",
        -1j / np.tan(PHASE),
        _over_lattice(octupole, "4a force", "force", "φ", (1, 1)),
        EXACT,
        source="Table discr_forces, polar chiral; Eq. 4a_discr_tr has the difference",
    )
    q = np.array([PHASE / SPACING])
    printed = rod.discrete_operator(Rod.of(octupole), q, misprints=["4a torque"])
    spin = -363 / 5 * STRENGTHS["4a"] / SPACING**5
    sums = [
        cell(operator[0], "torque", "φ")[2, 1] - spin
        for operator in (printed, lattice_operator(octupole, q))
    ]
    recorder.difference(
        "4a torque of φ, printed over lattice: d x̂× for (3/5) d x̂×",
        5 / 3,
        sums[0] / sums[1],
        EXACT,
        source="Table discr_torques, polar chiral; Eq. 4a_discr_rot has 3/5",
    )
    springs = uniform_chain({}, {"elasticity.stretch": 4.0, "elasticity.shear": 3.0})
    for what, row, column, entry, power in (
        ("C¹ in the force of φ", "force", "φ", (1, 2), 1),
        ("D² in the torque of φ_x", "torque", "φ", (0, 0), 2),
    ):
        recorder.difference(
            f"{what}, printed over lattice: d^−{power}, which λ and μ have taken in",
            SPACING**-power,
            _over_lattice(springs, "differences", row, column, entry),
            EXACT,
            source="Appendix B against Eqs. passive_discr_tr and passive_discr_rot",
        )


def _rod_entry(scene: Scene, misprints: list[str], row: str, column: str, entry) -> complex:
    operator = rod.continuum_operator(Rod.of(scene), TINY / SPACING, misprints=misprints)
    return complex(cell(operator, row, column)[entry])


def _continuum_tables(recorder: Recorder) -> None:
    for label, name, column, entry, stated, what, source in (
        (
            "2s",
            "2s torque",
            "u",
            (2, 1),
            1 + 3 / 4 * SPACING**2,
            "C_∥^{Fε} for C_⊥^{Fε}, 1 + (3/4)(d/a)²",
            "Table cont_torques, apolar achiral",
        ),
        (
            "3a",
            "leading moduli",
            "φ",
            (2, 1),
            3 / 2,
            "M̃ with the other sign and H_↺^{mτ} without its second term",
            "Table moduli, apolar chiral",
        ),
    ):
        scene = uniform_chain({label: STRENGTHS[label]}, FLUID)
        q = TINY / SPACING
        lattice = cell(lattice_operator(scene, q), "torque", column)[entry]
        recorder.check(
            f"{label} torque of {column}, rod over lattice, moduli as derived",
            1,
            _rod_entry(scene, [], "torque", column, entry) / lattice,
            1e-6,
            source=source,
        )
        recorder.difference(
            f"{label} torque of {column}, printed rod over lattice: {what}",
            stated,
            _rod_entry(scene, [name], "torque", column, entry) / lattice,
            1e-6,
            source=source,
        )
    scene = uniform_chain({"4a": STRENGTHS["4a"]}, FLUID)
    lattice = cell(lattice_operator(scene, TINY / SPACING), "torque", "φ")[2, 1]
    lost = 1 - _rod_entry(scene, ["leading moduli"], "torque", "φ", (2, 1)) / lattice
    recorder.difference(
        "4a torque of φ at q = 0: share of it that the printed moduli lose",
        1,
        lost.real,
        1e-5,
        source="Table moduli: H_⊥^{mε} − C_↺^{Fε} vanishes, the dropped term is all there is",
    )
    stress = steady_stress(uniform_chain({"3a": STRENGTHS["3a"]}, FLUID))[3]
    theory = Rod.of(uniform_chain({"3a": STRENGTHS["3a"]}, FLUID))
    recorder.difference(
        "3a pre-moment, printed over right on left (the side of the prestress)",
        -1,
        rod.moduli(theory, printed=True)["M_pre"] / stress,
        EXACT,
        source="Eq. 3a_pretorque against Eq. 2s_prestress",
    )


def _rotation_equation(recorder: Recorder) -> None:
    """−κ_T φ′ would leave a uniform shear without a gap."""
    scene = uniform_chain({}, {"elasticity.stretch": 1e6, "elasticity.shear": 1e6})
    lattice = cell(lattice_operator(scene, TINY / SPACING), "torque", "φ")[1, 1]
    recorder.difference(
        "passive torque of φ, printed over lattice: φ′ for φ, iq",
        1j * TINY / SPACING,
        _rod_entry(scene, ["rotation"], "torque", "φ", (1, 1)) / lattice,
        2e-3,
        source="Eq. rot_part",
    )


def _beam_rate(scene: Scene, phases: np.ndarray) -> Complex:
    """Λ = v†ΓMv/v†Γv of the rod's unsheared wave φ = x̂ × u′, hand +."""
    theory, q = Rod.of(scene), phases / SPACING
    theory = Rod(**{name: getattr(theory, name) for name in ("radius", "spacing", "strengths")})
    friction = np.repeat([theory.gamma_T, theory.gamma_R], 3)
    wave = np.array([0.0, 1.0, -1j])
    v = np.concatenate([np.tile(wave, (len(q), 1)), -q[:, None] * wave], axis=1)
    pushed = np.einsum("ni,i,nij,nj->n", v.conj(), friction, rod.continuum_operator(theory, q), v)
    return pushed / np.einsum("ni,i,ni->n", v.conj(), friction, v)


def _third_order_laws(recorder: Recorder) -> None:
    """Laws of the rod at the third order in q; its moduli are matched to the second."""
    phases = np.array([0.02])
    dipoles = uniform_chain({"3a": STRENGTHS["3a"]}, LIMP)
    recorder.difference(
        "3a: growth rate of the rod over that of the lattice, the paper's “slight difference”",
        3 / 2,
        (_beam_rate(dipoles, phases) / branch_rates(dipoles, phases))[0].real,
        1e-3,
        source="Eq. 3a_beam_lim against Eq. 3a_trans_ac_disp: −(13/12) for −(13/18)",
    )
    sources = uniform_chain({"3t": STRENGTHS["3t"]}, LIMP)
    unit = STRENGTHS["3t"] / SPACING**4 * phases**3
    gap = (_beam_rate(sources, phases) - branch_rates(sources, phases)).imag / unit
    recorder.difference(
        "3t: third order of Im Λ, rod less lattice, over (a³V/d⁴)(qd)³",
        1 / 5,
        gap[0],
        1e-3,
        source="−H_⊥^{mτ} u‴ in Eq. 3t_beam_lim; on the lattice 1/5 − 1/5 = 0",
    )
