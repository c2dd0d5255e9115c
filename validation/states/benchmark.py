"""A neighbour's problem with an effect of one's own: a clamped filament with a follower force.

An elastic filament in a viscous fluid, clamped at one end and pushed by a force along its own axis
at the other, loses its straight state by a double Hopf bifurcation at σ = FL²/κ = 37.695, with the
frequency ω = 191.26 κ/ζL⁴: numbers that :mod:`validation.states.beam` solves for. Beyond, the
filament whirls; waves in a plane exist too, and are unstable (Ling, Guo and Kanso, J. R. Soc.
Interface 15, 20180594, 2018; Clarke, Hwang and Keaveny, Phys. Rev. Fluids 9, 073101, 2024;
Schnitzer, J. Fluid Mech., 2025, arXiv:2406.18756). De Canio, Lauga and Goldstein, J. R. Soc.
Interface 14, 20170491 (2017) have the flapping in a plane.

The chain has κ = μ⊥d, ζ = γ_T/d and L = (N − 1)d. It differs from the beam by the order 1/N, as
its last sphere has the drag of a whole link; from a beam with that drag at its end, by 1/N².
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

import nrchain
from validation.report.recorder import Recorder
from validation.states import beam
from validation.states.cantilever import cantilevers

STIFF = 1e5
"""Stiffness of stretch and shear, and of the springs at the clamp: bending has 1.9."""

COUNTS, FEWER = (20, 40, 80), (10, 20, 40)

WHIRLING = 10
"""Spheres of the chain that whirls."""

ABOVE = (1.01, 1.02, 1.04)
"""F over its threshold in states that whirl."""

BEAM = "beam with a follower force: determinant of four rows"
KNOWN = "Clarke, Hwang & Keaveny 2024; Schnitzer 2025: whirling is stable, planar beating is not"


@dataclass(frozen=True)
class Threshold:
    """σ and ω of a chain of N spheres at its flutter, in units of the beam."""

    count: int
    force: float
    frequency: float
    scene: nrchain.Scene

    @property
    def link(self) -> float:
        """d/L."""
        return 1.0 / (self.count - 1)


def cantilever(count: int, force: float = 1.0, **changes: Any) -> nrchain.Scene:
    """A chain that is held at its first sphere, with a follower force (in units of force)."""
    links = {"elasticity.ratio": None, "elasticity.stretch": STIFF, "elasticity.shear": STIFF}
    ends = {"chain.ends": "free", "chain.particles": count, "elasticity.measure": "isotropic"}
    held = {"cantilever.hold": STIFF, "cantilever.force": force, "start.shape": "straight"}
    return nrchain.load_scene("passive", **links | ends | held | changes)


def units(scene: nrchain.Scene) -> tuple[float, float, float]:
    """L, κ/L² and κ/ζL⁴ of a chain."""
    spacing = scene.chain.spacing
    length = (scene.chain.particles - 1) * spacing
    bending, drag = scene.moduli.bend * spacing, scene.drag.translation / spacing
    return length, bending / length**2, bending / (drag * length**4)


def threshold(count: int) -> Threshold:
    """The critical strength of ``cantilever.force``."""
    scene = cantilever(count)
    _, force, rate = units(scene)
    between = (30.0 * force, 45.0 * force)
    found = nrchain.critical_strength(scene, "cantilever.force", between)
    at = nrchain.load_scene(scene, **{"cantilever.force": found.value})
    return Threshold(count, found.value / force, abs(found.frequency) / rate, at)


def benchmark(recorder: Recorder) -> None:
    """Thresholds, frequencies and whirling against the beam and what others have found."""
    expected = beam.flutter()
    merging = beam.merging()
    recorder.check("Beck's column, P L²/κ", beam.BECK, merging, 1e-6, source="Beck 1952")
    with cantilevers():
        found = []
        for count in FEWER if recorder.quick else COUNTS:
            recorder.step(f"follower force, N = {count}")
            found.append(threshold(count))
        _converge(recorder, found, expected)
        recorder.step("filaments that whirl")
        _whirl(recorder)


def _converge(recorder: Recorder, found: list[Threshold], expected: tuple[float, float]) -> None:
    """The limit N → ∞, and the orders in 1/N."""
    links = np.array([one.link for one in found])
    rows = []
    for k, name in enumerate(("force", "frequency")):
        values = np.array([getattr(one, name) for one in found])
        dragged = np.array([beam.flutter(link)[k] for link in links])
        limit = float(np.linalg.solve(np.vander(links, len(links)), values)[-1])
        most = 1e-2 if recorder.quick else 1e-3
        recorder.check(f"follower force: {name} at N → ∞", expected[k], limit, most, source=BEAM)
        first = order(links, values - expected[k])
        recorder.check(f"follower force: order of the {name}", 1.0, first, 0.1, source="1/N")
        second = order(links, values - dragged)
        words = "1/N², with the drag of half a link at the end"
        recorder.bound(
            f"follower force: order of the {name} beside the drag at the end",
            second,
            least=1.5,
            most=2.2,
            source=words,
        )
        rows += [
            [name, one.count, f"{value:.4f}", f"{near:.4f}", f"{expected[k]:.4f}"]
            for one, value, near in zip(found, values, dragged, strict=True)
        ]
    recorder.table(
        "Flutter of a clamped filament under a follower force",
        ["At the threshold", "N", "Chain", "Beam with the drag of half a link", "Beam"],
        rows,
        "Force FL²/κ and frequency ωζL⁴/κ at which the straight chain begins to flutter, with an"
        " effect of one's own. Isotropic measure, λ = 10⁵, a = η = 1, d = 10.",
    )


def order(links: np.ndarray, misses: np.ndarray) -> float:
    """The exponent of d/L of the last two misses."""
    ratio = abs(misses[-2] / misses[-1])
    return math.log(ratio) / math.log(links[-2] / links[-1])


def _whirl(recorder: Recorder) -> None:
    """Whirling beyond the threshold: stable, with the square-root law, and found by a run."""
    onset = threshold(WHIRLING)
    force = onset.scene.cantilever.force
    length, _, rate = units(onset.scene)
    ratios, squares, turns = np.array(ABOVE), [], []
    for ratio in ABOVE:
        state = whirling(ratio * force)
        recorder.bound(
            f"whirling at {ratio} of the threshold: growth of the leading mode",
            state.spectrum.leading.growth / rate,
            most=0.0,
            source=KNOWN,
        )
        squares.append((np.linalg.norm(state.positions[:, 1:], axis=1).max() / length) ** 2)
        turns.append(abs(state.rotation[0]) / rate)
    law = np.polynomial.Polynomial.fit(ratios - 1.0, squares, 2, domain=[-1, 1])
    recorder.bound(
        "whirling: square of the amplitude at the threshold, over its slope",
        abs(law(0.0) / law.deriv()(0.0)),
        most=1e-3,
        source="amplitudes beyond a Hopf point grow as the square root",
    )
    at_onset = np.polynomial.Polynomial.fit(ratios - 1.0, turns, 2, domain=[-1, 1])(0.0)
    recorder.check(
        "whirling: rate of rotation at the threshold",
        onset.frequency,
        at_onset,
        1e-3,
        source="frequency of the leading mode there",
    )
    _runs(recorder, ABOVE[-1] * force)


def whirling(force: float) -> nrchain.State:
    """The state of a chain that whirls steadily."""
    return nrchain.find_state(cantilever(WHIRLING, force), nudge=0.5)


def _runs(recorder: Recorder, force: float) -> None:
    """What runs end in, from a random start and from one in a plane."""
    state = whirling(force)
    period = 2.0 * math.pi / abs(state.rotation[0])
    times = {"run.end": 40.0 * period, "run.snapshots": 1601, "start.amplitude": 2.0}
    random = nrchain.simulate(cantilever(WHIRLING, force, **times, **{"start.shape": "random"}))
    found = nrchain.measure.attractor(random)
    is_whirling = found.kind is nrchain.measure.Attracted.ROTATING
    recorder.check("whirling: a random start ends in it", 1, is_whirling, 0.0, source=KNOWN)
    recorder.check(
        "whirling: period of the run", period, found.period or 0.0, 1e-3, source="find_state"
    )
    plane = nrchain.simulate(cantilever(WHIRLING, force, **times, **{"start.shape": "sine"}))
    beating = nrchain.measure.attractor(plane)
    recorder.check(
        "planar beating: small changes grow",
        1,
        beating.kind.is_oscillation and beating.confidence.startswith("unstable"),
        0.0,
        source=KNOWN,
    )
    recorder.text(
        f"At {ABOVE[-1]} of the threshold the filament of N = {WHIRLING} whirls with the period"
        f" {found.period:.1f}. In a plane it beats with the period {beating.period or 0.0:.1f}, and"
        f" changes out of the plane grow at the rate {beating.numbers.get('exponent', 0.0):.2g}."
    )
