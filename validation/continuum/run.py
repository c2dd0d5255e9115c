"""Do simulated chains follow the continuum laws, and how far do the laws reach?

The paper's Figs. 4c, 5c, 6c and 7c again: chains of growing length at fixed d = 10 and R = 1e12
start from one wavelength of a sine or helix; the transient is dropped and a growing, decaying,
travelling or rotating wave fitted. Here the chains are periodic, so that a plane wave is an exact
mode, and so low that its own tension does not count. Each wave is held against three things: the
law of the paper (Eqs. pass_ac, 2s_tr_displ, 3a_trans_ac_disp, 3t_trans_ac_disp, 4a_trans_ac_disp,
3t_long_tr_disp, pass_op), the exact rate of the discrete chain (:mod:`nrchain.lattice`), and the
next order in qd of that chain, expanded by hand (:mod:`validation.continuum.runs`). What the
amplitude a/10 and open ends change, as in the paper's own runs, is measured beside.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

import nrchain
from nrchain import measure
from validation.continuum import figures
from validation.continuum.ends import free_chains, tension
from validation.continuum.runs import (
    LONGITUDINAL,
    MODES,
    OPTICAL,
    PASSIVE,
    D,
    Point,
    Series,
    wave_scene,
)
from validation.report.recorder import Recorder

LENGTHS = (16, 20, 24, 28, 32, 40, 48, 64, 80, 96)
QUICK_LENGTHS = (16, 28, 48, 80)
Array = NDArray[np.floating]


def study(recorder: Recorder) -> None:
    lengths = QUICK_LENGTHS if recorder.quick else LENGTHS
    taken: dict[str, list[Point]] = {}
    for series in (PASSIVE, *MODES.values(), LONGITUDINAL, OPTICAL):
        strengths = series.strengths
        if recorder.quick:
            strengths = tuple(dict.fromkeys((strengths[0], strengths[-1])))
        recorder.step(f"{series.title}: {len(strengths)} × {len(lengths)} waves")
        points = [series.run(v, n) for v in strengths for n in lengths]
        taken[series.title] = points
        _against_lattice(recorder, series, points)
        _against_law(recorder, series, *_active(series, points))
    for label in MODES:
        _bending_beside(recorder, label, taken[label])
    _soft_3a(recorder, taken["3a"])
    recorder.step("waves at rest in space")
    _at_rest_in_space(recorder)
    recorder.step("tension of high waves")
    high = tension(recorder)
    recorder.step("open chains")
    free = free_chains(recorder)
    recorder.step("figures")
    _show(recorder, taken)
    recorder.figure(
        "ends",
        figures.ends(free, high),
        "What open ends and high waves change. (a) Fits to free chains that start from half a "
        "wavelength, as in the paper: chains of pushers and of pullers relax like a passive one. "
        "(b) A wave of height a/10 around a periodic chain pulls itself straight.",
    )


def _against_lattice(recorder: Recorder, series: Series, points: list[Point]) -> None:
    recorder.bound(
        f"{series.title}: largest |Λ − Λ_lattice|/|Λ_lattice| of {len(points)} waves",
        max(point.miss for point in points),
        most=1e-4,
        source="exact linear response of the discrete chain",
    )
    recorder.bound(
        f"{series.title}: largest standard error of a fit, over |Λ|",
        max(point.rate.error / abs(point.lattice) for point in points),
        most=1e-4,
        source="errors of the regression",
    )


def _active(series: Series, points: list[Point]) -> tuple[Array, Array]:
    """x, and the active part of Λ over its law, without the stated effect of finite stiffness.

    [Λ(V) − Λ(−V)]/2 of the largest strengths; for series without opposite strengths Λ(V) of the
    last.
    """
    first, last = (
        sorted((p for p in points if p.strength == v), key=lambda p: p.x)
        for v in (series.strengths[0], series.strengths[-1])
    )
    x = np.array([p.x for p in last])
    measured, law = (np.array([get(p) for p in last]) for get in _values(series.active))
    if series.strengths[0] < 0:
        measured = measured - [_values(series.active)[0](p) for p in first]
        law = law - [_values(series.active)[1](p) for p in first]
    coefficient, power = series.slack
    return x, measured / law - coefficient * np.array([p.slack for p in last]) * x**power


def _values(part: str):
    if part == "growth":
        return (lambda p: p.rate.growth.value), (lambda p: p.law.real)
    return (lambda p: p.rate.frequency.value), (lambda p: p.law.imag)


def _against_law(recorder: Recorder, series: Series, x: Array, ratio: Array) -> None:
    """The law is met as qd → 0, and left as its own next order says."""
    part = {"growth": "growth rate", "frequency": "frequency"}[series.active]
    law, *_ = _expansion(x, ratio)
    recorder.check(
        f"{series.title}: {part} over the law as qd → 0",
        1.0,
        law,
        1e-4,
        source=f"Eq. ({series.law})",
    )
    _next_order(recorder, f"{series.title}: {part}", series.next, x, ratio)


def _next_order(recorder: Recorder, name: str, stated: float, x: Array, ratio: Array) -> None:
    coefficient = _expansion(x, ratio)[1]
    recorder.check(
        f"{name}: coefficient of (qd)² beyond the law",
        stated,
        coefficient,
        0.03,
        source="expansion of the discrete chain's beam limit",
    )
    longest = np.argsort(x)[:3]
    slope = np.polyfit(np.log(x[longest]), np.log(np.abs(ratio[longest] - 1.0)), 1)[0]
    for side, limits in (("not below", {"least": 1.8}), ("not above", {"most": 2.2})):
        recorder.bound(
            f"{name}: order of the relative difference from the law, {side}",
            slope,
            **limits,
            source="slope over the three longest waves; the next order is (qd)²",
        )


def _expansion(x: Array, ratio: Array) -> Array:
    """c₀, c₁, … of ratio = Σ c_k x^{2k}."""
    terms = 4 if len(x) > 5 else 3
    return np.linalg.lstsq(np.stack([x ** (2 * k) for k in range(terms)], axis=1), ratio)[0]


def _bending_beside(recorder: Recorder, label: str, points: list[Point]) -> None:
    """What of the growth rate does not change sign with V is the bending of the passive chain."""
    if MODES[label].active == "frequency":
        recorder.bound(
            f"{label}: largest relative miss of the growth rate, beside a faster frequency",
            max(abs(p.rate.growth.value / p.lattice.real - 1.0) for p in points),
            most=1e-3,
            source="exact linear response of the discrete chain",
        )
    weakest = min(abs(p.strength) for p in points)
    both = [
        sorted((p for p in points if p.strength == sign * weakest), key=lambda p: p.x)
        for sign in (1, -1)
    ]
    x = np.array([p.x for p in both[0]])
    growth = [(p.rate.growth.value + m.rate.growth.value) / 2 for p, m in zip(*both, strict=True)]
    recorder.check(
        f"{label}: growth rate that does not change sign with V, over bending as qd → 0",
        1.0,
        _expansion(x, np.array(growth) / -(x**4))[0],
        2e-3,
        source="Eq. (pass_ac)",
    )


def _soft_3a(recorder: Recorder, points: list[Point]) -> None:
    """How far the law of 3a is off because shear is not infinitely stiff."""
    series = MODES["3a"]
    x, ratio = _active(series, points)
    longest = int(np.argmin(x))
    slack = min(points, key=lambda p: p.x).slack
    offset = ratio[longest] + series.slack[0] * slack - 1.0 - series.next * x[longest] ** 2
    recorder.check(
        f"3a: what stays of the difference from the law at qd = {x[longest]:.3f}, over μ/λd²",
        series.slack[0],
        offset / slack,
        0.02,
        source="tilt behind slope by μq²/λ; the first order of displacement and tilt cancels in 3a",
    )
    recorder.text(
        "**The 3a law needs more than a small qd.** Its force is the small remainder of two terms, "
        "from the slope of the chain and from the tilt of the frames, that cancel to first order. "
        "Any shear between the two therefore counts: the growth rate is off by the factor "
        "1 + 3μ/λd² however long the wave. With the paper's rule λ ∝ R/(N−1)⁴ the longest chains "
        f"are the worst: {3 * slack:.1%} at qd = {x[longest]:.3f} and R = 1e12. In the figure and "
        "the table of orders this part is taken out, as predicted, for all modes (for the others "
        "it vanishes with qd)."
    )


def _at_rest_in_space(recorder: Recorder) -> None:
    """The phase velocity of a 3t wave along the chain is −V₀: it slides through its shape."""
    count, strength = 48, 1000.0
    x = 2 * math.pi / count
    scene = nrchain.load_scene(wave_scene("3t", strength, count, "sine"), **{"run.end": 60.0})
    trajectory = nrchain.simulate(scene)
    velocity = measure.translation(trajectory)[0].value
    phase = measure.rate(measure.wave(trajectory, kind="y")).phase_velocity.value
    recorder.check(
        "3t: velocity of the chain",
        4 / 5 * strength / D**3,
        velocity,
        1e-6,
        source="Eq. (3t_vel)",
    )
    recorder.check(
        "3t: velocity in space of the transverse wave, over V₀",
        4 / 3 / D**2 * x**2,
        (velocity + phase) / velocity,
        0.01,
        source="−Im Λ/q + V₀ by Eq. (3t_trans_ac_disp): zero up to the friction of turning spheres",
    )
    recorder.text(
        "**3t waves stand still in space.** The law Λ = +iV₀q is that of a wave exp(iqs + Λt) that "
        "moves along the chain towards its tail at V₀, while the chain itself advances at V₀: the "
        "shape stays where it is and the chain slides through it, like a snake through its track. "
        f"Measured at N = {count}: chain {velocity:.6f}, wave along the chain {phase:.6f}, "
        f"difference {velocity + phase:.2g}. The paper's caption (Fig. 6d) has the waveform travel "
        "together with the chain, and its text removes the term in the frame that moves along; it "
        "is the frame fixed in space, at fixed x in place of fixed sphere, that removes it."
    )


def _show(recorder: Recorder, taken: dict[str, list[Point]]) -> None:
    recorder.figure(
        "dispersion",
        figures.dispersion(MODES, {label: taken[label] for label in MODES}),
        "Growth rates, over the power of qd that activity adds, and velocities of transverse waves "
        "(the paper's Figs. 4c, 5c, 6c, 7c). Markers: simulation, with standard errors, which are "
        "far smaller than the markers; dashed: the continuum laws; solid: the discrete chain, "
        "exactly. Im Λ/q is the velocity towards the first sphere. Towards small qd the discrete "
        "chain of 3a leaves its law because R = 1e12 is not stiff enough for the longest chains.",
    )
    recorder.figure(
        "branches",
        figures.branches(taken["passive"], taken["optical"], taken["3t along the chain"]),
        "The branches the paper gives without figures: bending and shear of the passive chain, "
        "and longitudinal waves of 3t (λ∥ = 1, so that they live long enough to travel).",
    )
    orders = {}
    for series in (PASSIVE, *MODES.values(), LONGITUDINAL, OPTICAL):
        x, ratio = _active(series, taken[series.title])
        orders[series.title] = (x, np.abs(ratio - 1.0), abs(series.next))
    recorder.figure(
        "order",
        figures.order(orders),
        "How the simulated chains leave the continuum laws. Markers: relative difference of the "
        "active part; lines: the next order of the discrete chain, c (qd)², computed beforehand.",
    )
    recorder.table(
        "agreement",
        ("branch", "waves", "worst |Λ − lattice|/|lattice|", "worst fit error/|Λ|",
         "law as qd → 0", "(qd)² beyond: stated", "measured"),
        [_row(series, taken[series.title]) for series in
         (PASSIVE, *MODES.values(), LONGITUDINAL, OPTICAL)],
        "Simulated waves against the exact discrete chain, and their active part against the "
        "continuum laws: measured over law as qd → 0, and the coefficient of the next order.",
        first_page=True,
    )  # fmt: skip


def _row(series: Series, points: list[Point]) -> tuple:
    law, coefficient, *_ = _expansion(*_active(series, points))
    return (
        series.title,
        len(points),
        f"{max(p.miss for p in points):.1e}",
        f"{max(p.rate.error / abs(p.lattice) for p in points):.1e}",
        f"{law:.6f}",
        f"{series.next:.4f}",
        f"{coefficient:.4f}",
    )
