"""What does a straight chain exert on itself, and how fast does it swim and spin?

Every sphere is in the flow of its neighbours. By symmetry the forces of 2s and the torques of 3a
cancel on each sphere and leave a prestress and a pre-moment. Those of 3t and 4a add up and move the
chain. Source: the paper, Eqs. (2s_prestress), (3a_pretorque), (3t_pre_force), (3t_vel),
(4a_pre_torque) and (4a_ang_vel), for nearest neighbours. Longer reaches multiply them by a sum over
neighbours.

Each quantity is measured twice: from the pair forces on a straight chain, and from the elastic
forces of a chain simulated until it is at rest.
"""

from __future__ import annotations

from math import pi

import numpy as np
from matplotlib.figure import Figure
from scipy.special import zeta

from validation.report.recorder import Recorder
from validation.rest.measures import (
    COUNT,
    HALF,
    RESTING,
    Reach,
    Resting,
    exerted,
    sprung,
    steady,
)

EXACT = 1e-11
STRENGTHS = {"2s": 100.0, "3a": 5000.0, "3t": 1000.0, "4a": 10000.0}
Series = dict[str, tuple[list[float], list[float]]]
"""Strengths, and the values measured on simulated chains, by mode."""


def study(recorder: Recorder) -> None:
    recorder.step("straight chains")
    for label, law in RESTING.items():
        _nearest(recorder, label, law)
        _reaches(recorder, label, law)
    _sign_of_pre_moment(recorder)
    _logarithm(recorder)
    fractions = (-1.0, 1.0) if recorder.quick else (-1.0, -0.5, 0.5, 1.0)
    series: Series = {}
    for label, law in RESTING.items():
        recorder.step(f"simulated chains, {label}")
        strengths = [fraction * STRENGTHS[label] for fraction in fractions]
        series[label] = strengths, [_simulated(recorder, label, law, v) for v in strengths]
        _simulated_beyond(recorder, label, law)
    recorder.step("figures")
    _show(recorder, series)
    _findings(recorder)


def _nearest(recorder: Recorder, label: str, law: Resting) -> None:
    for radius, spacing, viscosity in ((1.0, 10.0, 1.0), (1.3, 7.0, 0.4)):
        recorder.check(
            f"{law.name} of {label}, over V: a = {radius:g}, d = {spacing:g}, η = {viscosity:g}",
            law.nearest(radius, spacing, viscosity),
            exerted(label, radius=radius, spacing=spacing, viscosity=viscosity),
            EXACT,
            source=f"Eq. ({law.equation})",
        )


def _reaches(recorder: Recorder, label: str, law: Resting) -> None:
    alone = exerted(label)
    sums: dict[Reach, float] = {k: law.factor(k) for k in (2, 3, 10)}
    sums["all"] = law.across(HALF) if law.stress else law.factor(HALF)
    for reach, factor in sums.items():
        recorder.check(
            f"{law.name} of {label}: {reach} neighbours over nearest, {HALF} spheres a side",
            factor,
            exerted(label, reach=reach) / alone,
            EXACT,
            source=f"Σ m^−{law.decay}",
        )
    if law.decay > 1:
        recorder.check(
            f"{law.name} of {label}: all pairs of an endless chain, ζ({law.decay})",
            zeta(law.decay),
            exerted(label, reach=HALF) / alone + zeta(law.decay, HALF + 1),
            EXACT,
            source=f"Σ m^−{law.decay} = ζ({law.decay}), its tail beyond m = {HALF} added",
        )


def _sign_of_pre_moment(recorder: Recorder) -> None:
    recorder.difference(
        "pre-moment of 3a over the printed one: −1",
        -1.0,
        exerted("3a") / (13 / 12 * 8 * pi / 10.0**4),
        EXACT,
        source="Eq. (3a_pretorque), in the convention of Eq. (2s_prestress): what the side at "
        "larger x exerts on the other",
    )


def _logarithm(recorder: Recorder) -> None:
    doubled = exerted("2s", reach="all", half=2 * HALF) - exerted("2s", reach="all")
    recorder.check(
        "prestress of 2s, all pairs: twice the spheres add ln 2 of the nearest",
        np.log(2.0),
        doubled / exerted("2s"),
        1e-3,
        source="Σ 1/m grows as a logarithm; the next term is of order 1/N²",
    )


def _simulated(recorder: Recorder, label: str, law: Resting, strength: float) -> float:
    """Stress or velocity of a simulated chain with nearest neighbours."""
    measured = sprung(label, strength, 1) if law.stress else steady(label, strength, 1, "periodic")
    moving = {"3t": "3t_vel", "4a": "4a_ang_vel"}
    value = f"{strength:g}".replace("-", "−")
    recorder.check(
        f"simulated: {law.seen} of {label}, V = {value}",
        law.nearest() * strength / law.drag,
        measured,
        # the prestress stretches the bonds that measure it by a millionth of d
        1e-5 if law.stress else 1e-7,
        source=f"Eq. ({moving.get(label, law.equation)})",
    )
    return measured


def _simulated_beyond(recorder: Recorder, label: str, law: Resting) -> None:
    """Longer reaches, and free chains, whose end spheres have half the neighbours."""
    strength = STRENGTHS[label]
    nearest = law.nearest() * strength / law.drag
    if law.stress:
        recorder.check(
            f"simulated: {law.seen} of {label}, all pairs of {COUNT} spheres",
            nearest * law.across(COUNT // 2),
            sprung(label, strength, "all"),
            1e-5,
            source=f"Σ 1/(j − i)^{law.pair_decay} over the pairs across the middle",
        )
        return
    places = np.arange(1.0, COUNT)
    shares = (1 - places / COUNT) * places**-law.decay
    cases: tuple[tuple[str, str, Reach, float, str], ...] = (
        ("periodic, 3 neighbours", "periodic", 3, law.factor(3), f"Σ m^−{law.decay}"),
        (f"free, N = {COUNT}", "free", 1, shares[0], "1 − 1/N: each end has one neighbour"),
        (f"free, N = {COUNT}, all pairs", "free", "all", shares.sum(), "Σ (1 − m/N) m^−s"),
    )
    for title, ends, reach, factor, source in cases:
        recorder.check(
            f"simulated: {law.seen} of {label}, {title}",
            nearest * factor,
            steady(label, strength, reach, ends),
            1e-6,
            source=source,
        )


def _show(recorder: Recorder, series: Series) -> None:
    recorder.figure(
        "strength",
        _strength_figure(series),
        "The chain at rest against the strength of its slip, nearest neighbours, a = η = 1, "
        f"d = 10: simulated chains of {COUNT} spheres (symbols), the paper (dashed; the pre-moment "
        "with the opposite sign). Prestress and pre-moment are measured by the elastic forces of a "
        "free chain, V₀ and Ω₀ on a periodic one.",
    )
    recorder.figure(
        "reach",
        _reach_figure(),
        "The same quantities when every sphere acts on k neighbours a side, over nearest "
        "neighbours: from the forces on a straight chain (symbols) and the sums of 1/mˢ (lines). "
        "All but the prestress converge to a zeta value; the prestress grows as a logarithm.",
    )
    rows = []
    for label, law in RESTING.items():
        beyond = "grows as ln N" if law.decay == 1 else f"ζ({law.decay}) = {zeta(law.decay):.4f}"
        strength, shown = (values[-1] for values in series[label])
        rows.append(
            (
                label,
                law.name,
                law.formula,
                strength,
                law.nearest() * strength,
                shown * law.drag,
                beyond,
            )
        )
    recorder.table(
        "The chain at rest",
        ["Mode", "Quantity", "Paper, nearest", "V", "Predicted", "Simulated", "All pairs"],
        rows,
        "a = η = 1, d = 10. Pre-force and pre-torque are Γ_T V₀ and Γ_R Ω₀ of the simulated chain. "
        "The pre-moment has the sign of the pair law, opposite to the paper's. The last column is "
        "the value with all pairs of an endless chain over that with nearest neighbours.",
    )


def _findings(recorder: Recorder) -> None:
    recorder.text(
        "For nearest neighbours the straight chain agrees with the paper, except for one sign. In "
        "the convention of the printed prestress of 2s (what the side at larger x exerts on the "
        "other), the **pre-moment of 3a is −13a³γ_R V/12d⁴**. The paper prints it positive. The "
        "linear response does not fix that sign: there the pre-moment is added to a modulus that "
        "is fitted."
    )
    law = RESTING["3t"]
    close = next(k for k in range(1, HALF) if law.factor(k) > 0.99 * zeta(law.decay))
    recorder.text(
        "With all pairs the **prestress of 2s has no limit**: m pairs of m-th neighbours lie "
        "across a cut, each with a force ∝ 1/m², and the sum grows as ln N. The others tend to "
        "ζ(3), ζ(3) and ζ(5) times the value of nearest neighbours. With "
        f"{close} neighbours on each side they are within 1 % of that limit."
    )


def _strength_figure(series: Series) -> Figure:
    figure = Figure(figsize=(9.6, 2.7))
    titles = {
        "2s": "prestress (2s)",
        "3a": "pre-moment (3a)",
        "3t": "velocity V₀ (3t)",
        "4a": "angular velocity Ω₀ (4a)",
    }
    units = {"2s": "ηa²/time", "3a": "ηa³/time", "3t": "a/time", "4a": "rad/time"}
    for panel, (label, (strengths, measured)) in zip(
        figure.subplots(1, 4), series.items(), strict=True
    ):
        law, full = RESTING[label], STRENGTHS[label]
        ends = np.array([-1.15, 1.15]) * full
        panel.axhline(0, color="0.8", linewidth=0.8)
        panel.plot(ends, law.nearest() / law.drag * ends, "--", color="0.5", label="paper")
        panel.plot(strengths, measured, "o", color="0.1", label="simulated")
        panel.set(title=titles[label], xlabel="V (a/time)", ylabel=units[label])
        panel.set_xticks([-full, 0, full])
    figure.axes[0].legend()
    return figure


def _reach_figure() -> Figure:
    figure = Figure(figsize=(5.6, 3.5))
    panel = figure.subplots()
    reaches = np.unique(np.geomspace(1, HALF, 14).round().astype(int))
    smooth = np.arange(1, HALF + 1)
    looks = (("o", "0.1", "0.1"), ("s", "0.1", "none"), ("x", "0.1", "none"), ("v", "0.5", "none"))
    for (label, law), (marker, color, face) in zip(RESTING.items(), looks, strict=True):
        alone = exerted(label)
        measured = [exerted(label, reach=int(reach)) / alone for reach in reaches]
        panel.plot(smooth, np.cumsum(smooth ** -float(law.decay)), color=color, linewidth=0.8)
        panel.plot(
            reaches,
            measured,
            marker,
            color=color,
            markerfacecolor=face,
            label=f"{law.name} ({label})",
        )
    for value, name, up in ((zeta(3), "ζ(3)", 3), (zeta(5), "ζ(5)", -3)):
        panel.annotate(
            name,
            (1.0, value),
            xytext=(4, up),
            xycoords=panel.get_yaxis_transform(),
            textcoords="offset points",
            va="center",
        )
    panel.set(xlabel="neighbours k on each side", ylabel="over nearest neighbours", xscale="log")
    panel.set_xticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"])
    panel.set_xticks([], minor=True)
    panel.legend(loc="upper left")
    return figure
