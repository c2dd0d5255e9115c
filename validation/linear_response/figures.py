"""The figures of the study of linear response."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from nrchain import Rod, rod
from validation.linear_response.laws import BEYOND
from validation.report.recorder import Recorder
from validation.report.uniform_chains import (
    BENDING,
    LIMP,
    SPACING,
    STRENGTHS,
    branch_rates,
    uniform_chain,
)

MARKERS = {
    "passive": ("D", "0.0"),
    "2s": ("o", "0.0"),
    "3a": ("s", "0.45"),
    "3t": ("^", "0.0"),
    "4a": ("v", "0.45"),
}
Part = Callable[[NDArray], NDArray]

PARTS: dict[str, tuple[str, Part, str]] = {
    "2s": ("growth rate", np.real, "2s, stresslet"),
    "3a": ("growth rate", np.real, "3a, torque dipole"),
    "3t": ("angular frequency", np.imag, "3t, source dipole"),
    "4a": ("angular frequency", np.imag, "4a, chiral octupole"),
}


def draw(recorder: Recorder) -> None:
    recorder.figure(
        "order",
        _order(),
        "Relative difference between the continuum laws of bending waves and the lattice, at "
        "a/d = 0.1: symbols, the lattice operator; lines, c (qd)² with c in closed form. Above "
        "qd ≈ 1 the expansion does not hold.",
    )
    recorder.figure(
        "dispersion",
        _dispersion(),
        "Active part of the bending waves of hand +, over the whole zone, in units of the law at "
        "qd = 1: the law of the paper, the lattice operator of the simulation, and the paper's "
        "discrete equations of motion for λ → ∞. The law holds at qd below about 0.5.",
    )


def _chain(name: str):
    slip = {} if name == "passive" else {name: STRENGTHS[name]}
    return uniform_chain(slip, BENDING if name == "passive" else LIMP)


def _order() -> Figure:
    figure = Figure(figsize=(4.8, 3.7))
    panel = figure.subplots()
    phases, line = np.geomspace(0.012, 3.0, 13), np.geomspace(0.01, 1.0, 2)
    for name, beyond in BEYOND.items():
        scene = _chain(name)
        law = rod.transverse(Rod.of(scene), phases / SPACING)
        difference = np.abs(1 - branch_rates(scene, phases) / law)
        marker, grey = MARKERS[name]
        panel.loglog(phases, difference, marker, color=grey, mfc="none", label=name)
        panel.loglog(line, beyond.at(1.0) * line**2, color=grey, linewidth=0.8)
    panel.set(xlabel="qd", ylabel="|Λ − law| / |law|", xlim=(0.009, 4.0))
    panel.text(0.13, 3e-5, "slope 2", color="0.3")
    panel.legend(loc="upper left")
    return figure


def _dispersion() -> Figure:
    figure = Figure(figsize=(7.2, 5.0))
    dense, sparse = np.linspace(1e-3, np.pi, 200), np.linspace(0.15, np.pi, 16)
    for panel, (name, (quantity, part, title)) in zip(
        figure.subplots(2, 2).ravel(), PARTS.items(), strict=True
    ):
        scene = _chain(name)
        theory = Rod.of(scene)

        def scaled(rates: NDArray, part=part, theory=theory) -> NDArray:
            return part(rates) / abs(rod.transverse(theory, 1.0 / SPACING))

        panel.axhline(0, color="0.8", linewidth=0.8)
        panel.plot(
            dense, scaled(rod.transverse(theory, dense / SPACING)), "--", color="0.5", label="law"
        )
        panel.plot(dense, scaled(branch_rates(scene, dense)), color="0.0", label="lattice operator")
        panel.plot(
            sparse,
            scaled(rod.beam_rates(theory, sparse / SPACING)[:, 0]),
            "o",
            color="0.0",
            mfc="white",
            label="paper, discrete equations",
        )
        top = np.abs(scaled(branch_rates(scene, dense))).max()
        low, high = panel.get_ylim()
        panel.set_ylim(max(low, -1.6 * top), min(high, 1.6 * top))
        panel.set(title=title, xlabel="qd", ylabel=f"{quantity} / |law at qd = 1|")
        panel.set_xticks([0, np.pi / 2, np.pi], ["0", "π/2", "π"])
        if name == "2s":
            panel.legend(loc="best")
    return figure
