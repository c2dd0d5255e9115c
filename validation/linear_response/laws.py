"""How fast do the continuum laws approach the lattice as qd → 0?

The next order of each law is known in closed form: expanding Λ = v†ΓMv/v†Γv of the unsheared wave
v = (C⁰, ±iC¹) gives a factor 1 − c (qd)², with c in :data:`BEYOND`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from nrchain import Branch, Rod, lattice_rates, rod
from validation.linear_response.cells import order_of
from validation.report.recorder import Recorder
from validation.report.uniform_chains import (
    BENDING,
    FLUID,
    LIMP,
    SPACING,
    STRENGTHS,
    branch_rates,
    uniform_chain,
)

LONG = np.array([0.02, 0.04])
"""qd at which orders and coefficients are measured."""


class Beyond(NamedTuple):
    """Λ = law · (1 − c (qd)²): c = plain + finite (a/d)², and its origin."""

    plain: float
    finite: float
    source: str

    def at(self, radius: float) -> float:
        return self.plain + self.finite * (radius / SPACING) ** 2


BEYOND = {
    "passive": Beyond(1 / 12, 4 / 3, "2(1 − cos qd), and the friction of rotation"),
    "2s": Beyond(1 / 12, 0, "2(1 − cos qd); rotation and torque cancel"),
    "3a": Beyond(5 / 32, 1, "sin qd − qd cos qd, C¹/C⁰, rotation and torque"),
    "3t": Beyond(0, 4 / 3, "no third order from the force; the friction of rotation"),
    "4a": Beyond(1 / 4, 4 / 9, "2qd sin qd − 2(1 − cos qd), rotation and torque"),
}


def compare(recorder: Recorder) -> None:
    """Record orders and coefficients for every law, the third order of 3t, and the beam limit."""
    _laws(recorder)
    _longitudinal_laws(recorder)
    _third_order(recorder)
    _stiffness(recorder)


def _law_difference(name: str, phases: np.ndarray, radius: float = 1.0) -> np.ndarray:
    """1 − Λ/law of bending waves of hand + on the lattice, in the beam limit."""
    changes = {"chain.radius": radius}
    scene = (
        uniform_chain({}, BENDING | changes)
        if name == "passive"
        else uniform_chain({name: STRENGTHS[name]}, LIMP | changes)
    )
    law = rod.transverse(Rod.of(scene), phases / SPACING)
    return (1.0 - branch_rates(scene, phases) / law).real


def _laws(recorder: Recorder) -> None:
    equations = {name: law.source for name, law in rod.dispersion.TRANSVERSE.items()}
    equations["passive"] = "Eq. pass_ac"
    rows = []
    for name, beyond in BEYOND.items():
        difference = _law_difference(name, LONG)
        order, leading = order_of(LONG, difference, 2)
        recorder.check(f"{name}: order of law less lattice", 2, order, 2e-3, source=equations[name])
        recorder.check(
            f"{name}: law less lattice over (qd)², a/d = 0.1",
            beyond.at(1.0),
            leading,
            2e-5,
            source=beyond.source,
        )
        for radius in (0.2, 3.0):
            _, other = order_of(LONG, _law_difference(name, LONG, radius), 2)
            recorder.check(
                f"{name}: law less lattice over (qd)², a/d = {radius / SPACING:g}",
                beyond.at(radius),
                other,
                2e-5,
                source=beyond.source,
            )
        written = f"{beyond.plain:.5g} + {beyond.finite:.5g} (a/d)²"
        rows.append((name, equations[name], order, written, beyond.at(1.0), leading))
    recorder.table(
        "Next order of the continuum laws",
        ["Chain", "Law", "Order measured", "c in closed form", "c at a/d = 0.1", "c measured"],
        rows,
        "The dispersion laws of bending waves hold up to a factor 1 − c (qd)² on the lattice.",
    )


def _longitudinal_laws(recorder: Recorder) -> None:
    """Waves of u_x and φ_x, and the gap."""
    cases: tuple[tuple[str, dict, dict, Branch, Callable, int, float], ...] = (
        ("2s along x", {"2s": 100.0}, FLUID, Branch.STRETCH, rod.longitudinal, 2, 1 / 12),
        ("3t along x", {"3t": 1000.0}, FLUID, Branch.STRETCH, rod.longitudinal, 2, 1 / 6),
        ("stretch", {}, {"elasticity.stretch": 10.0, "elasticity.shear": 10.0}, Branch.STRETCH,
         rod.longitudinal, 4, 3 / 320),
        ("twist", {}, {}, Branch.TWIST, rod.twisting, 2, 1 / 12),
    )  # fmt: skip
    sources = ("C_par_F_eps of Table moduli", "Eq. 3t_long_tr_disp", "Eq. passive_cont_tr",
               "Eq. passive_cont_rot")  # fmt: skip
    phases = np.array([0.1, 0.2])
    for (name, slip, changes, branch, law, power, expected), source in zip(
        cases, sources, strict=True
    ):
        scene = uniform_chain(slip, changes)
        left_out = 1 - branch_rates(scene, phases, branch) / law(Rod.of(scene), phases / SPACING)
        order, leading = order_of(phases, np.real(left_out), power)
        recorder.check(f"{name}: order of law less lattice", power, order, 1e-2, source=source)
        recorder.check(
            f"{name}: law less lattice over (qd)^{power}", expected, leading, 1e-5, source=source
        )
    for label in ("passive", "2s", "4a"):
        slip = {} if label == "passive" else {label: STRENGTHS[label]}
        scene = uniform_chain(slip, {"elasticity.stretch": 10.0, "elasticity.shear": 10.0})
        rate = lattice_rates(scene, 0.0)[Branch.SHEAR_PLUS]
        recorder.check(
            f"{label}: the gap, Λ of a uniform shear",
            rod.optical(Rod.of(scene)),
            rate,
            1e-12,
            source="Eq. pass_op" if label == "passive" else rod.dispersion.OPTICAL[label].source,
        )


def _third_order(recorder: Recorder) -> None:
    """3t: the third order of Im Λ, over (a³V/d⁴)(qd)³."""
    unit = STRENGTHS["3t"] / SPACING**4
    zeta = 1.2020569031595942
    for name, reach, lead, plain in (
        ("nearest neighbours", 1, 1.0, 0.0),
        ("all pairs", "all", zeta, -1 / 15),
    ):
        scene = uniform_chain({"3t": STRENGTHS["3t"]}, LIMP | {"slip.neighbours": reach})
        rate = branch_rates(scene, LONG).imag / unit
        _, third = order_of(LONG, 0.8 * lead * LONG - rate, 3)
        recorder.check(
            f"3t: third order of Im Λ, {name}",
            plain - 16 / 15 * 0.01 * lead,
            -third,
            1e-5,
            source="−(16/15)(a/d)² of rotation, and −1/15 which only an endless sum has",
        )


def _stiffness(recorder: Recorder) -> None:
    """The beam limit is approached as 1/λ."""
    phase = np.array([0.3])
    for label in STRENGTHS:
        away = []
        for stiffness in (1e7, 1e8):
            changes = {"elasticity.stretch": stiffness, "elasticity.shear": stiffness}
            scene = uniform_chain({label: STRENGTHS[label]}, changes)
            limit = rod.beam_rates(Rod.of(scene), phase / SPACING)[0, 0]
            away.append(abs(branch_rates(scene, phase)[0] / limit - 1))
        recorder.check(
            f"{label}: power of λ with which the beam limit is reached",
            -1,
            np.log10(away[1] / away[0]),
            1e-3,
            source="Λ = v†ΓMv/v†Γv of unsheared waves, λ → ∞",
        )
