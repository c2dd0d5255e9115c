"""Are the moduli of the simulated chain those of the paper, of any reach, and of uniform strain?"""

from __future__ import annotations

import numpy as np
from scipy.special import zeta

import nrchain
from nrchain import Rod, Scene, lattice_operator, rod
from validation.report.recorder import Recorder
from validation.report.uniform_chains import FLUID, SPACING, STRENGTHS, uniform_chain
from validation.solid.printed import CUT, value

EXACT = 1e-12
UNITS = {"a/d = 0.1": {}, "own units": {"chain.radius": 1.3, "chain.spacing": 7.0,
                                        "chain.viscosity": 0.4}}  # fmt: skip
PHASE = 1e-3
"""qd at which entries of all pairs are compared with the lattice."""


def compare(recorder: Recorder) -> None:
    """Record Table moduli, its misprints, elasticity, reaches, and uniform strain."""
    for name, units in UNITS.items():
        _table(recorder, name, units)
        _cut(recorder, name, units)
    _zeros(recorder)
    _misprints(recorder)
    _elasticity(recorder)
    _reaches(recorder)
    _logarithms(recorder)
    _show(recorder)


def _chain(label: str, changes: dict) -> Scene:
    return uniform_chain({label: STRENGTHS[label]}, FLUID | changes)


def _table(recorder: Recorder, name: str, units: dict) -> None:
    for label in STRENGTHS:
        scene = _chain(label, units)
        found = nrchain.moduli(scene).active.symbols()
        for row in rod.TABLE:
            if row.mode == label and row.terms:
                recorder.check(
                    f"{label}: {row.symbol}, {name}",
                    row.value(Rod.of(scene)),
                    found[row.symbol],
                    EXACT,
                    source="Table moduli" + (": as it has to be read" if row.note else ""),
                )


def _zeros(recorder: Recorder) -> None:
    """Entries that the table gives as 0, and all constants that it does not list."""
    for label in STRENGTHS:
        found = nrchain.moduli(_chain(label, {})).active.symbols()
        rows = {row.symbol: row.terms for row in rod.TABLE if row.mode == label}
        for symbol in (s for s, terms in rows.items() if not terms):
            recorder.check(
                f"{label}: {symbol}", 0, found[symbol] / STRENGTHS[label], 1e-14,
                source="Table moduli: 0",
            )  # fmt: skip
        others = [abs(v) for symbol, v in found.items() if symbol not in rows]
        recorder.check(
            f"{label}: the largest of the {len(others)} constants outside its class",
            0,
            max(others) / STRENGTHS[label],
            1e-14,
            source="Table syms",
        )


def _misprints(recorder: Recorder) -> None:
    for row in rod.TABLE:
        if row.printed is not None:
            scene = _chain(row.mode, {})
            chain = Rod.of(scene)
            stated = {
                "M_pre": -1.0,
                "H_odd_m_tau": 1.0 / (1.0 - 4 / 3 / SPACING**2),
                "H_perp_m_eps": 1.0 / (1.0 - 20 / 3 / SPACING**2),
            }[row.symbol]
            recorder.difference(
                f"{row.mode}: {row.symbol}, printed over that of the chain",
                stated,
                row.value(chain, printed=True) / nrchain.moduli(scene).active.symbols()[row.symbol],
                EXACT,
                source=f"Table moduli: {row.note}",
            )
    found = nrchain.moduli(_chain("2s", {}))
    recorder.difference(
        "block of ↺: m₂ per ε₃ of 2s over H_↺^{mε}; the printed matrix has +1",
        -1.0,
        found.active.H[4, 2] / found.active.symbols()["H_odd_m_eps"],
        EXACT,
        source="Eq. transverse_isotropy_moving_frame against its vector form and Eq. rot_cont_eom",
    )


def _elasticity(recorder: Recorder) -> None:
    springs = {"stretch": 40.0, "shear": 25.0, "twist": 300.0, "bend": 500.0}
    scene = uniform_chain({}, {f"elasticity.{name}": v for name, v in springs.items()})
    names = dict(zip(springs, ("C_par_F_eps", "C_perp_F_eps", "C_par_M_tau", "C_perp_M_tau"),
                     strict=True))  # fmt: skip
    for stress in ("linear", "cut"):
        found = nrchain.moduli(scene, stress).elastic.symbols()
        for name, symbol in names.items():
            recorder.check(
                f"springs, {stress} stress: {symbol}",
                springs[name] * SPACING,
                found[symbol],
                1e-11,
                source="κ_T = λd, κ_R = μd, Eq. cons_id",
            )


def _cut(recorder: Recorder, name: str, units: dict) -> None:
    """Moduli of uniform strain: closed forms where they differ, and Table moduli elsewhere."""
    for label, strength in STRENGTHS.items():
        scene = _chain(label, units)
        found = nrchain.moduli(scene, "cut").active.symbols()
        chain = Rod.of(scene)
        for row in rod.TABLE:
            if row.mode == label and (terms := CUT[label].get(row.symbol, row.terms)):
                own = "half of Table moduli, and lever arms" if row.symbol in CUT[label] else ""
                recorder.check(
                    f"{label}, uniform strain: {row.symbol}, {name}",
                    value(terms, chain, strength),
                    found[row.symbol],
                    1e-9,
                    source="by hand: half of Table moduli, and lever arms"
                    if own
                    else "Table moduli",
                )


def _reaches(recorder: Recorder) -> None:
    """k neighbours and all pairs over nearest neighbours: Σ m^−s with the power s of each entry."""
    powers = {
        ("2s", "H_odd_m_eps"): 3,
        ("3a", "M_pre"): 3,
        ("3a", "C_par_M_eps"): 3,
        ("3a", "H_odd_f_eps"): 3,
        ("3t", "f_pre"): 3,
        ("3t", "H_par_f_eps"): 3,
        ("4a", "m_pre"): 5,
        ("4a", "C_odd_F_eps"): 3,
        ("4a", "C_odd_M_tau"): 3,
        ("4a", "H_par_m_eps"): 5,
    }
    for (label, symbol), power in powers.items():
        near = nrchain.moduli(_chain(label, {})).active.symbols()[symbol]
        for reach, factor in ((3, 1 + 2.0**-power + 3.0**-power), ("all", zeta(power))):
            found = nrchain.moduli(_chain(label, {"slip.neighbours": reach})).active.symbols()
            recorder.check(
                f"{label}: {symbol}, {reach} neighbours over nearest",
                factor,
                found[symbol] / near,
                EXACT,
                source=f"Σ m^−{power}",
            )


def _logarithms(recorder: Recorder) -> None:
    """All pairs: 3/2 + ln(1/qd) over nearest neighbours, against the exact lattice."""
    q = PHASE / SPACING
    for label, symbol, (row, column), scale in (
        ("2s", "C_par_F_eps", (0, 0), -1.0),
        ("2s", "C_perp_F_eps", (1, 1), -1.0),
        ("2s", "C_perp_M_tau", (4, 4), -1.0),
        ("3a", "C_perp_F_tau", (1, 4), -1.0),
        ("3t", "C_odd_F_tau", (1, 5), 1.0),
    ):
        scene = _chain(label, {"slip.neighbours": "all"})
        found, near = nrchain.moduli(scene), nrchain.moduli(_chain(label, {}))
        alone = near.active.symbols()[symbol]
        recorder.check(
            f"{label}: coefficient of ln(1/qd) in {symbol}, over nearest neighbours",
            1,
            found.logarithm.symbols()[symbol] / alone,
            EXACT,
            source="Σ 2(1 − cos mθ)/(m³θ²) → 3/2 − ln θ",
        )
        wave, rest = (lattice_operator(scene, k)[row, column].real for k in (q, 0.0))
        drag = found.drag[row, row]
        recorder.check(
            f"{label}: {symbol} at qd = {PHASE:g}, second order of the lattice over nearest",
            1.5 - np.log(PHASE),
            scale * (wave - rest) * drag / q**2 / alone,
            1e-5,
            source="the exact lattice of all pairs; the next order is (qd)²",
        )
        recorder.check(
            f"{label}: {symbol} at qd = {PHASE:g}, moduli over nearest",
            1.5 - np.log(PHASE),
            found.at(q).symbols()[symbol] / alone,
            EXACT,
            source="value + coefficient · ln(1/qd)",
        )


def _show(recorder: Recorder) -> None:
    rows = []
    for label in STRENGTHS:
        near, cut = (nrchain.moduli(_chain(label, {}), stress) for stress in ("linear", "cut"))
        every = nrchain.moduli(_chain(label, {"slip.neighbours": "all"}))
        columns = [c.symbols() for c in (near.active, cut.active, every.active, every.logarithm)]
        for row in (row for row in rod.TABLE if row.mode == label):
            linear, uniform, value_of_all, logarithm = (c[row.symbol] for c in columns)
            shown = f"{value_of_all:.6g}"
            if abs(logarithm) > 1e-9:
                shown += f" + {logarithm:.6g} ln(1/qd)"
            printed = row.value(Rod.of(_chain(label, {})), printed=True)
            rows.append((label, row.symbol, printed, linear, uniform, shown.replace("-", "−")))
    recorder.table(
        "Effective moduli",
        ["Mode", "Constant", "Printed", "Linear response", "Uniform strain", "All pairs"],
        rows,
        "a = η = 1, d = 10, strengths of the paper's snapshots. Nearest neighbours in all columns "
        "but the last, which is of linear response.",
    )
