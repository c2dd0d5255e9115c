"""Spheres per wavelength against the continuum law, and the order of the difference formulas.

Λ of the discrete chain comes from its lattice operator, exact at every wavelength, in the beam
limit and per mode the slip alone; the cost is that of simulating a passive chain of one wavelength
until its wave has decayed by e.

The elastic potential ties the tilt of an unsheared wave to its slope by four-body formulas,
φ/u′ = 1 + (3/160)(qd)⁴; two-body ones, as on the last links of an open chain, give tan(qd/2)/(qd/2)
= 1 + (qd)²/12. Bends are differences between two neighbours and leave −(qd)²/12 in the rate. The
rate is therefore of second order with either, −1/12 with the one and +1/12 with the other.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain import Branch, Rod, lattice_operator, load_scene, simulate
from nrchain.accuracy.timing import Measured, measure_all
from nrchain.theory.rod import dispersion
from validation.cost import figures
from validation.cost.results import TARGETS, Resolved
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

SHIPPED = {"2s": 38, "3a": 78, "3t": 19, "4a": 19}
"""Spheres in the longest wave (2s, 3a: 2(N−1)) or the starting wave of the shipped scenes."""
COUNTS = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)
SIMULATED = (8, 16, 32, 64, 128)
S = 1.0 / SPACING**2
NEXT = {"passive": 1 / 12 + 4 * S / 3, "2s": 1 / 12, "3a": 5 / 32 + S, "3t": 4 * S / 3,
        "4a": 1 / 4 + 4 * S / 9}  # fmt: skip
"""c of the relative error c (qd)², from the expansion of the lattice.

The expansion is derived in :mod:`validation.continuum.runs`.
"""


def compare(recorder: Recorder) -> None:
    """Record errors by spheres per wavelength, what they need, and the order of the formulas."""
    recorder.step("resolution: waves")
    costs = _costs(recorder)
    points = [
        Resolved(n, {kind: law_error(kind, n) for kind in NEXT}, costs.get(n)) for n in COUNTS
    ]
    x = 2 * math.pi / np.array([p.count for p in points if p.count >= 48])
    for kind, coefficient in NEXT.items():
        errors = np.array([p.errors[kind] for p in points if p.count >= 48])
        slope = np.polyfit(np.log(x), np.log(errors), 1)[0]
        recorder.check(
            f"{kind}: error of the continuum law ∝ (qd)^", 2, slope, 0.05,
            source="expansion of the lattice", relative=False,
        )  # fmt: skip
        recorder.check(
            f"{kind}: error over (qd)² at n = {COUNTS[-1]}", coefficient, errors[-1] / x[-1] ** 2,
            0.02, source="expansion of the lattice",
        )  # fmt: skip
    needed = {kind: [_needed(kind, level) for level in TARGETS] for kind in NEXT}
    rows = [
        (
            p.count, 2 * math.pi / p.count, *(p.errors[kind] for kind in NEXT),
            p.measured and p.measured.median, p.measured and p.measured.work.steps,
            p.measured and p.measured.work.evaluations,
            p.measured and p.measured.work.jacobians,
        )
        for p in points
    ]  # fmt: skip
    recorder.table(
        "Resolution",
        ["Spheres a wavelength", "qd", *NEXT, "Seconds", "Steps", "Right-hand sides", "Jacobians"],
        rows,
        "Relative error of the continuum law of each wave (nearest neighbours, beam limit; modes: "
        "the slip alone), and the cost of one decay time of the passive wave.",
    )
    recorder.table(
        "Spheres a wavelength that an error of the continuum law needs",
        ["Wave", "1 %", "0.1 %", "1e-6", "Shipped scene has"],
        [(kind, *needed[kind], SHIPPED.get(kind)) for kind in NEXT],
        "The least number, from the lattice operator.",
    )
    formulas = _formulas(recorder)
    recorder.figure(
        "Resolution",
        figures.resolution(points, needed, SHIPPED, formulas),
        "(a) Relative error of the continuum law against spheres per wavelength; squares: 1 %, "
        "0.1 % and 1e-6, rings: the longest or starting wave of the shipped scene. (b) Error of "
        "the passive wave against the processor time of one decay time. (c) Difference formulas: "
        "tilt over slope of an unsheared wave, and the rate that follows with each.",
    )


def law_error(kind: str, count: int) -> float:
    """|Λ/law − 1| of a bending wave of ``count`` spheres, on the endless lattice."""
    phase = np.array([2 * math.pi / count])
    passive = kind == "passive"
    scene = uniform_chain({} if passive else {kind: STRENGTHS[kind]}, BENDING if passive else LIMP)
    rate = branch_rates(scene, phase)[0]
    law = dispersion.transverse(Rod.of(scene), phase / SPACING)[0]
    return float(abs(rate / law - 1))


def _needed(kind: str, level: float) -> int:
    """The least n from which on the error is within the level, by bisection."""
    guess = 2 * math.pi * math.sqrt(NEXT[kind] / level)
    low, high = 2, math.ceil(1.5 * guess) + 8
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if law_error(kind, middle) <= level else (middle, high)
    return high


def _costs(recorder: Recorder) -> dict[int, Measured]:
    counts = SIMULATED[::2] if recorder.quick else SIMULATED
    # stiff enough for the beam limit, and not so stiff that rounding drives the steps
    stiff = {"elasticity.stretch": 1e6, "elasticity.shear": 1e6}
    scenes = {}
    for n in counts:
        decay = (n / (2 * math.pi)) ** 4
        start = {"start.shape": "helix-right", "start.amplitude": 1e-4}
        run = {"run.end": decay, "run.snapshots": 11, "run.rtol": 1e-7, "run.atol": 1e-11}
        ends = {"chain.particles": n, "chain.ends": "periodic"}
        scenes[str(n)] = load_scene(uniform_chain({}), **stiff, **ends, **start, **run)
    found = {}
    for name, scene in scenes.items():
        run_scene = {name: scene}
        found[int(name)] = measure_all(
            run_scene, simulate(scene), repeats=3 if recorder.quick else 7, budget=5.0
        )[name]
    return found


def tilt_over_slope(phase: float) -> float:
    """φ/u′ of the wave that the shear term of the lattice operator lets pass."""
    scene = uniform_chain({}, FLUID | {"elasticity.shear": 1.0})
    operator = lattice_operator(scene, phase / SPACING)
    u, tilt = operator[1, 1], operator[1, 5]
    return float((-u / tilt / (1j * phase / SPACING)).real)


def _formulas(recorder: Recorder) -> dict[str, np.ndarray]:
    phases = np.geomspace(0.05, 1.0, 25)
    four = np.array([tilt_over_slope(x) for x in phases])
    two = np.tan(phases / 2) / (phases / 2)
    rate = branch_rates(uniform_chain({}), phases, Branch.BEND_PLUS).real
    predicted, two_rate = (-_passive_rate(phases, ratio) for ratio in (four, two))
    recorder.check(
        "four-body formulas: tilt over slope − 1, over (qd)⁴", 3 / 160,
        (four[6] - 1) / phases[6] ** 4, 0.01, source="expansion of C¹/C⁰",
    )  # fmt: skip
    recorder.check(
        "two-body formulas: tilt over slope − 1, over (qd)²", 1 / 12,
        (two[6] - 1) / phases[6] ** 2, 0.01, source="tan(qd/2)/(qd/2)",
    )  # fmt: skip
    recorder.bound(
        "passive rate from tilt over slope, against the lattice",
        np.abs(predicted / rate - 1).max(), most=1e-9,
        source="Λ = −2μ(1 − cos qd)|φ|²/(γ_T|u|² + γ_R|φ|²)",
    )  # fmt: skip
    thin = {k: np.abs(v) for k, v in {"four-body": four - 1, "two-body": two - 1}.items()}
    return {
        "phases": phases,
        **thin,
        "rate, four-body": np.abs(rate / phases**4 + 1),
        "rate, two-body": np.abs(two_rate / phases**4 + 1),
    }


def _passive_rate(phases: np.ndarray, tilt: np.ndarray) -> np.ndarray:
    """−Λ of the beam limit, in units of the paper, for a given ratio of tilt to slope."""
    square = (tilt * phases) ** 2
    return 2 * (1 - np.cos(phases)) * square / (1 + 4 / 3 * S * square)
