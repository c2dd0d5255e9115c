"""Pictures of the study: stress and sources at finite strain, and the work in cycles."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nrchain import Material, rod
from validation.report.recorder import Recorder
from validation.report.style import MARKERS, SHADES
from validation.report.uniform_chains import SPACING, STRENGTHS
from validation.solid.work import CHAINS, chain, cycle, measured, scale

AXES = {"ε₁": 0, "ε₂": 1, "τ₃ d": 5}
NAMES = [f"{letter}{n}" for letter in "FM" for n in "₁₂₃"] + [
    f"{letter}{n}" for letter in "fm" for n in "₁₂₃"
]


def draw(recorder: Recorder) -> None:
    """Record both figures."""
    recorder.figure(
        "response",
        _response(21 if recorder.quick else 61),
        "Stress (upper row of each mode) and sources (lower row) of a chain in uniform strain, "
        "nearest neighbours, less their values at rest: the simulated chain (lines) and the moduli "
        "of uniform strain (dashed). M and m are over d. Each row is over its largest value; "
        "components below a hundredth of it are left out. A twist τ₁ changes nothing, as all axes "
        "are e₁.",
    )
    recorder.figure(
        "work",
        _work(4 if recorder.quick else 7),
        "Work of the chain per cycle of strain less that of its moduli, over the work of the "
        "largest modulus, against the size of the cycle (symbols), and the fourth power (line). "
        "3t does no work at any strain.",
    )


def _response(points: int) -> Figure:
    figure = Figure(figsize=(8.4, 11.5))
    panels = figure.subplots(8, len(AXES), sharex="col")
    shown = np.linspace(-0.3, 0.3, points)
    scales = np.repeat([1.0, 1.0 / SPACING], 3)
    for row, label in enumerate(STRENGTHS):
        scene = chain(label)
        material = Material.of(scene, "cut")
        strains = np.zeros((len(AXES), points, 6))
        for column, axis in enumerate(AXES.values()):
            strains[column, :, axis] = shown / (SPACING if axis > 2 else 1.0)
        found, rest = (rod.uniform_response(scene, s) for s in (strains, np.zeros(6)))
        for half, curves, lines in (
            (0, found.stress - rest.stress, material.stress(strains)),
            (1, found.source - rest.source, material.source(strains)),
        ):
            lines = lines - lines[:, points // 2, None]
            largest = np.abs(curves * scales).max()
            for column in range(len(AXES)):
                values, linear = (c[column] * scales / largest for c in (curves, lines))
                _draw_components(panels[2 * row + half, column], shown, values, linear, 6 * half)
            panels[2 * row + half, 0].set_ylabel(f"{label} {('stress', 'source')[half]}")
    for panel, name in zip(panels[-1], AXES, strict=True):
        panel.set_xlabel(name)
    return figure


def _draw_components(panel, shown, values, linear, first) -> None:
    for k in range(6):
        if np.abs(values[:, k]).max() > 0.01:
            color = SHADES[k]
            panel.plot(shown, values[:, k], color=color, label=NAMES[first + k])
            panel.plot(shown, linear[:, k], "--", color=color, linewidth=0.7)
    panel.set_ylim(-1.1, 1.1)
    if panel.lines:
        panel.legend(loc="best", fontsize=6)


def _work(count: int) -> Figure:
    figure = Figure(figsize=(4.8, 3.4))
    panel = figure.subplots()
    sizes = np.geomspace(0.01, 0.08, count)
    for n, name in enumerate(CHAINS):
        if name == "3t":
            continue
        scene = chain(name)
        material = Material.of(scene, "cut")
        apart = [abs(measured(scene, cycle(s)) - material.work(cycle(s)).value) for s in sizes]
        unit = scale(scene)
        panel.loglog(
            sizes, np.array(apart) / unit, MARKERS[n], color=SHADES[n], markerfacecolor="none",
            label=name,
        )  # fmt: skip
    panel.loglog(sizes, sizes**4, color="0.5", linewidth=0.8, label="fourth power")
    panel.set(xlabel="strain of the cycle", ylabel="work less that of the moduli")
    panel.legend()
    return figure
