"""Figures: chain against rod, and a clamped pusher on its way from buckling to flutter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

import nrchain
from validation.spectrum import laws, simulated
from validation.spectrum.cases import NEAR, settling_time

ORDER_CAPTION = (
    "Distance of the critical strength of a clamped chain from that of the rod, against the number "
    "of links; the line falls as 1/(N − 1)²."
)
FLUTTER_CAPTION = (
    "Growth and frequency of the leading modes of a clamped pusher, p = 1.28 · 4π², against the "
    "load f̂ of 3t: eigenvalues of the chain of N = 20 (lines), runs (symbols) and the rod "
    "(dashed), in units of κ/ΓL⁴. The chain buckles to the left of the first zero and oscillates "
    "to the right of the second."
)
MARKERS = ("o", "s", "v", "^", "x")


def order(misses: Mapping[str, Sequence[tuple[int, float]]]) -> Figure:
    """Relative distance of chain and rod against N − 1."""
    figure = Figure(figsize=(5.6, 3.5))
    panel = figure.subplots()
    for marker, (title, points) in zip(MARKERS, misses.items(), strict=True):
        links = [count - 1 for count, _ in points]
        panel.plot(links, [abs(miss) for _, miss in points], marker, color="0.2", label=title)
    ends = np.array([30.0, 200.0])
    panel.plot(ends, 10.0 / ends**2, color="0.6", linewidth=0.8)
    panel.set(xscale="log", yscale="log", xlabel="N − 1", ylabel="|chain / rod − 1|")
    panel.set_xticks([40, 80, 160], ["40", "80", "160"])
    panel.set_xticks([], minor=True)
    panel.legend(fontsize="small")
    return figure


def flutter(quick: bool) -> Figure:
    """Growth and frequency of the leading modes against f̂."""
    case = NEAR[3]
    scene, unit = case.scene(20), case.unit(20)
    time = settling_time(scene)
    loads = np.linspace(20.0, 500.0, 13 if quick else 49)
    chain, rod = [], []
    for load in loads:
        given = nrchain.load_scene(scene, **{case.key: load / unit})
        modes = nrchain.spectrum(given, modes=4).modes
        across = [mode.rate * time for mode in modes if mode.multiplicity == 2]
        chain.append((across * 2)[:2] if across[0].imag else across[:2])
        rod.append(laws.rates(laws.Loads(p=case.fixed["2s"], f=load))[:2])
    figure = Figure(figsize=(7.6, 3.2))
    growth, frequency = figure.subplots(1, 2)
    for panel, part in ((growth, np.real), (frequency, lambda rates: np.abs(np.imag(rates)))):
        panel.plot(loads, part(np.array(chain)), color="0.1", linewidth=1.0)
        panel.plot(loads, part(np.array(rod)), "--", color="0.5", linewidth=0.8)
        panel.set(xlabel="f̂ of 3t")
    for load in loads[:: 3 if quick else 6]:
        given = nrchain.load_scene(scene, **{case.key: load / unit})
        rate = simulated.growth(given, 0.02 * time) * time
        growth.plot(load, rate.real, "o", color="0.1", markerfacecolor="none")
        frequency.plot(load, rate.imag, "o", color="0.1", markerfacecolor="none")
    growth.axhline(0.0, color="0.8", linewidth=0.8)
    growth.set(ylabel="Re Λ ΓL⁴/κ", ylim=(-450.0, 250.0))
    frequency.set(ylabel="|Im Λ| ΓL⁴/κ")
    return figure
