"""Figures of the continuum study: markers, simulation; dashed lines, laws; solid lines, lattice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from validation.continuum.ends import Free, High
from validation.continuum.runs import D, Point, Series, bending_theory
from validation.report.style import MARKERS, SHADES

TITLES = {"2s": "2s", "3a": "3a, right-handed", "3t": "3t", "4a": "4a, right-handed"}
POWERS = {"2s": 2, "3a": 3}
"""n of the (qd)^n that a growing mode adds to the growth rate."""

LENGTHS = range(14, 101)
TIME = r"\,[\mu/\gamma_T d^2]"
SPEED = r"\,[a\,\mu/\gamma_T d^2]"


def dispersion(modes: Mapping[str, Series], taken: Mapping[str, list[Point]]) -> Figure:
    """2 × 2 panels, one a mode: growth rates or phase velocities of all strengths."""
    figure = Figure(figsize=(7.4, 5.8))
    panels = figure.subplots(2, 2).flat
    for letter, axes, (label, points) in zip("abcd", panels, taken.items(), strict=True):
        for k, strength in enumerate(sorted({p.strength for p in points}, reverse=True)):
            row = [p for p in points if p.strength == strength]
            _draw_strength(axes, modes[label], row, k)
        power = POWERS.get(label)
        axes.set_xlim(0.05, 0.45)
        axes.set_xlabel("wavenumber  $qd$")
        if power:
            axes.set_ylabel(f"Re $\\Lambda/(qd)^{power}{TIME}$")
        else:
            axes.set_ylabel(f"Im $\\Lambda/q{SPEED}$")
        axes.set_title(f"({letter})  {TITLES[label]},  $V$ =", loc="left", fontsize=9, pad=18)
        legend = axes.legend(
            loc="lower left", bbox_to_anchor=(-0.03, 0.98), ncols=4, fontsize=8,
            handlelength=1.0, handletextpad=0.3, columnspacing=1.0,
        )  # fmt: skip
        legend.set_in_layout(False)
    return figure


def _draw_strength(axes: Axes, series: Series, row: list[Point], k: int) -> None:
    strength, colour, power = row[0].strength, SHADES[k], POWERS.get(series.title)

    def shown(x: NDArray, rates: Sequence[complex] | NDArray) -> NDArray:
        values = np.asarray(rates)
        return values.real / x**power if power else values.imag / (x / D)

    fine = 2 * np.pi / np.array(LENGTHS)
    lattice, law = zip(*(bending_theory(series.title, strength, n) for n in LENGTHS), strict=True)
    axes.plot(fine, shown(fine, lattice), "-", color=colour, lw=0.9)
    axes.plot(fine, shown(fine, law), "--", color=colour, lw=0.9)
    x = _column(row, "x")
    measured = shown(x, [p.rate.value for p in row])
    errors = shown(x, [complex(p.rate.growth.error, p.rate.frequency.error) for p in row])
    axes.errorbar(x, measured, errors, fmt="none", ecolor=colour, capsize=2)
    name = f"{strength:+g}".replace("-", "−")
    axes.plot(x, measured, MARKERS[k], color=colour, mfc="white", label=name)


def branches(passive: list[Point], optical: list[Point], along: list[Point]) -> Figure:
    """Bending and shear of the passive chain, velocity of longitudinal 3t waves."""
    figure = Figure(figsize=(8.4, 2.9))
    left, middle, right = figure.subplots(1, 3)
    x = _column(passive, "x")
    left.loglog(x, x**4, "k--", label="law")
    left.loglog(x, [-p.lattice.real for p in passive], "-", color=SHADES[1], label="lattice")
    left.loglog(
        x, [-p.rate.growth.value for p in passive], "o", color=SHADES[0], mfc="white",
        label="simulation",
    )  # fmt: skip
    _plain_wavenumbers(left)
    left.set_ylabel(f"decay rate  $-\\Lambda{TIME}$")
    left.set_title("(a)  passive, bending", loc="left", fontsize=9)
    left.legend()
    for k, modulus in enumerate(sorted({p.strength for p in optical})):
        row = sorted((p for p in optical if p.strength == modulus), key=lambda p: p.x)
        x = _column(row, "x")
        middle.plot(
            x, [1e3 * (p.lattice.real / p.law.real - 1) for p in row], "-", color=SHADES[k], lw=0.9
        )
        middle.plot(
            x, [1e3 * (p.rate.growth.value / p.law.real - 1) for p in row], MARKERS[k],
            color=SHADES[k], mfc="white", label=f"{modulus / 1e5:g}",
        )  # fmt: skip
    middle.axhline(0.0, color="k", ls="--", lw=0.9)
    middle.set_ylabel("$10^3$ [$\\Lambda$ over gap $-\\kappa_T/\\Gamma_R$, less 1]")
    middle.set_title("(b)  passive, shear", loc="left", fontsize=9)
    middle.legend(title="$\\lambda/10^5$", title_fontsize=8)
    for k, strength in enumerate(sorted({p.strength for p in along}, reverse=True)):
        row = sorted((p for p in along if p.strength == strength), key=lambda p: p.x)
        x = _column(row, "x")
        right.plot(x, [p.law.imag * D / p.x for p in row], "--", color=SHADES[k], lw=0.9)
        right.plot(x, [p.lattice.imag * D / p.x for p in row], "-", color=SHADES[k], lw=0.9)
        right.plot(
            x, [p.rate.frequency.value * D / p.x for p in row], MARKERS[k], color=SHADES[k],
            mfc="white", label=f"{strength:+g}".replace("-", "−"),
        )  # fmt: skip
    right.set_ylabel(f"Im $\\Lambda/q{SPEED}$")
    right.set_title("(c)  3t, along the chain", loc="left", fontsize=9)
    right.legend(title="strength $V$", title_fontsize=8, ncols=2)
    for axes in (left, middle, right):
        axes.set_xlabel("wavenumber  $qd$")
    return figure


def order(
    orders: dict[str, tuple[NDArray[np.floating], NDArray[np.floating], float]],
) -> Figure:
    """Relative differences from the laws against qd, with their stated next orders."""
    figure = Figure(figsize=(5.2, 4.0))
    axes = figure.subplots()
    for k, (name, (x, difference, coefficient)) in enumerate(orders.items()):
        axes.loglog(x, coefficient * x**2, "-", color=SHADES[k], lw=0.9)
        axes.loglog(x, difference, MARKERS[k], color=SHADES[k], mfc="white", label=name)
    axes.set_xlabel("wavenumber  $qd$")
    axes.set_ylabel("relative difference from the law")
    _plain_wavenumbers(axes)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def ends(free: list[Free], high: list[High]) -> Figure:
    """Rates of free 2s and passive chains, and the change by height a/10."""
    figure = Figure(figsize=(7.4, 3.1))
    left, right = figure.subplots(1, 2)
    for k, strength in enumerate((100.0, 0.0, -100.0)):
        row = [f for f in free if f.label in ("2s", "") and f.strength == strength]
        x = np.pi / (np.array([f.count for f in row]) - 1)
        name = f"{strength:+g}".replace("-", "−") if strength else "0, passive"
        left.plot(x, [f.law.real for f in row], "--", color=SHADES[k], lw=0.9)
        left.plot(
            x, [f.fit.rate.growth.value for f in row], MARKERS[k], color=SHADES[k], mfc="none",
            label=name, ms=8.5 - 2.5 * k,
        )  # fmt: skip
    left.set_yscale("symlog", linthresh=1e-5)
    left.set_yticks([-1e-2, -1e-4, 0.0, 1e-4, 1e-2])
    left.set_xlabel("wavenumber  $qd = \\pi/(N - 1)$")
    left.set_ylabel(f"growth rate  Re $\\Lambda{TIME}$")
    left.set_title("(a)  2s on free chains", loc="left", fontsize=9)
    left.legend(title="strength $V$: fits, dashed law", title_fontsize=8)
    n = [h.count for h in high]
    right.loglog(n, [h.predicted for h in high], "k-", label="tension $\\lambda d(Aq)^2/2$")
    right.loglog(n, [h.measured for h in high], "o", color=SHADES[0], mfc="white",
                 label="simulation")  # fmt: skip
    right.set_xticks(n, [str(v) for v in n], minor=False)
    right.minorticks_off()
    right.set_xlabel("spheres  $N$")
    right.set_ylabel("relative change of the decay rate")
    right.set_title("(b)  height $a/10$ around a period", loc="left", fontsize=9)
    right.legend()
    return figure


def _plain_wavenumbers(axes: Axes) -> None:
    axes.set_xticks([0.07, 0.1, 0.2, 0.4], ["0.07", "0.1", "0.2", "0.4"])
    axes.xaxis.set_minor_formatter(NullFormatter())


def _column(points: list[Point], name: str) -> NDArray[np.floating]:
    return np.array([getattr(p, name) for p in points])
