"""Are the waves of the rod those of the paper and the chain, and does a push grow as its pinch?"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from nrchain import Material, Rod, Scene, lattice_operator, rod
from validation.report.recorder import Recorder
from validation.report.style import SHADES
from validation.report.uniform_chains import FLUID, SPACING, STRENGTHS, uniform_chain
from validation.solid.work import MIX

CHAINS = {label: {label: strength} for label, strength in STRENGTHS.items()} | {"mix": MIX}

SPREADING = (2 + math.sqrt(7)) / 3 * math.sqrt(2 * (math.sqrt(7) - 1) / 3)
"""Speed at which Λ = q² − q⁴ spreads: W. van Saarloos, Phys. Rep. 386, 29 (2003)."""

BENDING = {"2s": 4, "3a": 3, "3t": 3, "4a": 4}
"""Order in q of what the rod drops from the rate of a bending wave."""

FIRM = {"elasticity.stretch": 1e5, "elasticity.shear": 1e5}
"""λ at which a chain of 2s hardly shears."""

BENDS = (4.0, 16.0)
"""Bending moduli of a chain, over γ_T d²; q* falls as their root."""

STEPS = np.arange(1600.0, 2000.0, 8.0)
"""Times at which a push is looked at, over the bending modulus."""


def compare(recorder: Recorder) -> None:
    """Record the symbol, its order against the lattice, thresholds, and the growth of pushes."""
    for name, slip in CHAINS.items():
        _symbol(recorder, name, uniform_chain(slip, {}))
    for label, order in BENDING.items():
        _bending(recorder, label, order)
    _thresholds(recorder)
    for dipole in (800.0, 1600.0):
        _pushes(recorder, dipole)
    recorder.figure(
        "pinch",
        _picture(5 if recorder.quick else 13),
        "2s at V = 100 with 3t, μ⊥ = 4 γ_T d²: growth of a push at its place, over the largest "
        "growth of a wave, against V of 3t. Pinch of the rod (line), of the beam limit (dashed), "
        "and the push on the exact lattice (symbols). Above 0 the instability is absolute.",
    )


def _symbol(recorder: Recorder, name: str, scene: Scene) -> None:
    material, q = Material.of(scene), np.linspace(-0.3, 0.3, 13)
    expected = rod.continuum_operator(Rod.of(scene), q)
    # differences in each entry, over the part of it that the slip makes
    passive = rod.continuum_operator(Rod.of(uniform_chain({}, {})), q)
    slip = np.abs(expected - passive).max(axis=0)
    apart = np.abs(rod.rod_symbol(material).operator(q) - expected).max(axis=0)
    kept = slip > 0.0
    recorder.check(
        f"{name}: largest difference of the symbol from the paper's, over the part of slip",
        0,
        float((apart[kept] / slip[kept]).max()),
        1e-7,
        source="tables cont_forces and cont_torques, written from the text",
    )

    limp = uniform_chain(CHAINS[name], FLUID)
    alone = rod.rod_symbol(Material.of(limp))
    recorder.check(
        f"{name}: order in q of the symbol of slip less that of the exact lattice",
        3,
        _order(lambda k: float(np.abs(alone.operator(k) - lattice_operator(limp, k)).max())),
        0.01,
        source="moduli match up to second derivatives",
    )


def _bending(recorder: Recorder, label: str, order: int) -> None:
    scene = uniform_chain({label: STRENGTHS[label]}, {})
    material, theory = Material.of(scene), Rod.of(scene)

    def apart(k: float) -> float:
        found = rod.rod_waves(material, [k], beam=True).rates[0, 0]
        return float(abs(found - rod.beam_rates(theory, [k])[0, 0]))

    recorder.check(
        f"{label}: order in q of bending rates in the beam limit, rod less chain",
        order,
        _order(apart),
        0.06,
        source="(qd)² times the law; for 3a the rod drops a term of the order of the law",
    )


def _order(error: Callable[[float], float], q: float = 0.01) -> float:
    return float(np.log2(error(q) / error(q / 2.0)))


def _thresholds(recorder: Recorder) -> None:
    """Speeds of the observer at which Re Λ* = 0, by bisection of the kind."""

    def threshold(symbol: rod.Symbol, low: float, high: float) -> float:
        while high - low > 1e-6:
            middle = 0.5 * (low + high)
            absolute = rod.instability(symbol.moving(middle)).kind == "absolute"
            low, high = (middle, high) if absolute else (low, middle)
        return 0.5 * (low + high)

    def scalar(*coefficients: float) -> rod.Symbol:
        return rod.Symbol(np.array(coefficients)[:, None, None], np.ones((1, 1, 1)))

    for name, symbol, expected in (
        ("Λ = μ + iqv − Dq²", scalar(0.3, 0.0, 2.0), 2.0 * math.sqrt(0.3 * 2.0)),
        ("Λ = q² + iqv − q⁴", scalar(0.0, 0.0, -1.0, 0.0, -1.0), SPREADING),
    ):
        recorder.check(
            f"{name}: v at which absolute instability ends",
            expected,
            threshold(symbol, 0.5, 3.0),
            1e-5,
            source="2 √(μD), and the spreading speed of Dee and Langer",
        )


def mixed(dipole: float, bend: float) -> Scene:
    """A chain of 2s and 3t that hardly shears."""
    mu = bend * 6.0 * math.pi * SPACING**2
    stiff = FIRM | {"elasticity.bend": mu, "elasticity.twist": mu}
    return uniform_chain({"2s": 100.0, "3t": dipole}, stiff)


def pushed(scene: Scene, times: NDArray[np.float64], spheres: int = 4096) -> NDArray[np.float64]:
    """u_y of the pushed sphere (n,): ∫ exp(M(q)t) dq/2π of the exact lattice."""
    phases = 2.0 * np.pi * np.fft.fftfreq(spheres)
    values, vectors = np.linalg.eig(lattice_operator(scene, phases / scene.chain.spacing))
    weights = vectors[:, 1] * np.linalg.inv(vectors)[:, :, 1]
    return np.array([(weights * np.exp(values * t)).sum().real / spheres for t in times])


def push_rate(signal: NDArray[np.float64], times: NDArray[np.float64]) -> complex:
    """Λ of Re(A exp(Λt))/√t with Im Λ > 0, from the recurrence of equal steps."""
    g = signal * np.sqrt(times)
    size = np.exp(np.linspace(0.0, 1.0, len(g)) * math.log(abs(g[-1] / g[0])))
    rows = np.stack([g[1:-1], g[:-2]], axis=1) / size[1:-1, None]
    first, second = np.linalg.lstsq(rows, g[2:] / size[1:-1], rcond=None)[0]
    root = (first + cmath.sqrt(first**2 + 4.0 * second)) / 2.0
    rate = cmath.log(root) / (times[1] - times[0])
    return complex(rate.real, abs(rate.imag))


def _pushes(recorder: Recorder, dipole: float) -> None:
    """Growth at the place of a push, lattice over rod, at two bending moduli and extrapolated."""
    ratios = []
    for bend in BENDS:
        scene, times = mixed(dipole / math.sqrt(bend), bend), bend * STEPS
        found = rod.rod_instability(Material.of(scene), beam=False)
        rate = complex(found.rate.real, abs(found.rate.imag))
        ratios.append(push_rate(pushed(scene, times), times) / rate)
    recorder.check(
        f"2s with 3t at {dipole:g}/√bend: growth of a push, lattice over Λ* of the rod, qd → 0",
        1,
        (4.0 * ratios[1] - ratios[0]) / 3.0,
        2e-3,
        source="the pinch of the rod; the lattice differs by (q*d)², which falls fourfold",
    )


def _picture(points: int) -> Figure:
    figure = Figure(figsize=(5.2, 3.6))
    panel = figure.subplots()
    bend = BENDS[0]
    dipoles = np.linspace(0.0, 1500.0, points)
    scenes = [mixed(dipole, bend) for dipole in dipoles]
    for limit, style in ((False, "-"), (True, "--")):
        found = [rod.rod_instability(Material.of(s), beam=limit) for s in scenes]
        values = [one.rate.real / one.growth for one in found]
        panel.plot(dipoles, values, style, color=SHADES[0], label="beam limit" if limit else "rod")
    # by half the times: the rounding of the fastest waves is still below a push that decays
    times = 0.5 * bend * STEPS
    grown = [push_rate(pushed(s, times), times).real for s in scenes[1:]]
    largest = [rod.rod_instability(Material.of(s)).growth for s in scenes[1:]]
    panel.plot(
        dipoles[1:], np.array(grown) / largest, "o", color=SHADES[2], markerfacecolor="none",
        label="push on the lattice",
    )  # fmt: skip
    panel.axhline(0.0, color="0.5", linewidth=0.8)
    panel.set(xlabel="V of 3t", ylabel="Re Λ* / largest growth")
    panel.legend()
    return figure
