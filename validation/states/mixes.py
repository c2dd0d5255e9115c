"""2s with 3t: from buckled through straight to oscillations that sustain themselves.

3t straightens a chain of pushers that has buckled, and a straight chain flutters where 3t is larger
still. Links of isotropic measure let the chain go round its axis steadily: such a rotating wave is
a state in axes that go along, with a branch of its own. Its period is 2π/Ω, and its Floquet
multipliers are exp(2πΛ/Ω).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

import nrchain
from validation.report.recorder import Recorder
from validation.states.buckling import ISSUE, LINKS
from validation.states.confirmed import rate_in_run

WITHIN = 1e-2
"""Of rates and frequencies in runs and of modes."""

SAME = 1e-7
"""Of thresholds by two ways, relative."""

SQUARE_ROOT = 0.03
"""Of the exponent of amplitudes near a threshold and 1/2."""


@dataclass(frozen=True)
class Mix:
    """A clamped chain of pushers, buckled at 3t = 0, and the largest 3t."""

    count: int
    reach: int | str
    push: float
    top: float
    links: Mapping[str, object]

    @property
    def title(self) -> str:
        pairs = "all pairs" if self.reach == "all" else "nearest neighbours"
        return f"2s + 3t, N = {self.count}, {pairs}"

    @property
    def scene(self) -> nrchain.Scene:
        changes = {"chain.particles": self.count, "slip.2s": self.push}
        return nrchain.load_scene(
            "buckling", **self.links, **changes, **{"slip.neighbours": self.reach}
        )


MIXES = (
    Mix(10, 1, 260.0, 16500.0, ISSUE),
    Mix(20, 1, 60.0, 2000.0, ISSUE),
    Mix(40, 1, 13.05, 200.0, LINKS),
    Mix(10, "all", 130.0, 16500.0, ISSUE),
    Mix(20, "all", 25.0, 2000.0, ISSUE),
    Mix(40, "all", 4.75, 100.0, LINKS),
)


def mixes(recorder: Recorder) -> nrchain.BranchDiagram:
    """All mixes; returns the branches of N = 20 and nearest neighbours."""
    rows, drawn = [], None
    for mix in MIXES[1:2] if recorder.quick else MIXES:
        recorder.step(mix.title)
        row, found = _mix(recorder, mix)
        rows.append(row)
        if (mix.count, mix.reach) == (20, 1):
            drawn = found
    recorder.table(
        "Self-sustained oscillations of pushers with 3t",
        [
            *("N", "Pairs", "2s", "Straight from 3t =", "Oscillates from 3t ="),
            *("ω there", "3t", "Amplitude", "Period", "Largest |μ|"),
        ],
        rows,
        "Clamped chains with isotropic links: pushers of strength 2s are buckled at 3t = 0, "
        "straight between the two thresholds, and go round beyond. Amplitude, period and the "
        "largest Floquet multiplier beside the trivial ones are those of the rotating wave at the "
        "3t of the next column; waves with a multiplier above 1 are unstable.",
        first_page=True,
    )
    assert drawn is not None
    return drawn


def _mix(
    recorder: Recorder, mix: Mix
) -> tuple[tuple[str | int | float, ...], nrchain.BranchDiagram]:
    scene, name = mix.scene, mix.title
    found = nrchain.continue_state(scene, {"slip.3t": (0.0, mix.top)}, branches=3, step=0.04)
    straight, bent, waves = found.branches
    first, onset = straight.special[:2]
    for word, point in (("straightens", first), ("flutters", onset)):
        sides = 0.97 * point.value, 1.03 * point.value
        known = nrchain.critical_strength(scene, "slip.3t", sides)
        recorder.check(
            f"{name}: {word}, over the zero of the spectrum",
            1.0,
            point.value / known.value,
            SAME,
            source="nrchain.critical_strength, which follows no branch",
        )
    recorder.bound(
        f"{name}: stable states of the buckled branch, of {len(bent)}",
        int(bent.is_stable[1:].sum()),
        least=len(bent) - 1,
        source="a pitchfork to the stable side",
    )
    amplitude, away = waves.amplitude[:5], waves.values[:5] - onset.value
    slope = np.polyfit(np.log(away), np.log(amplitude), 1)[0]
    recorder.check(
        f"{name}: exponent of the amplitude of the rotating wave",
        0.5,
        slope,
        SQUARE_ROOT,
        source="a Hopf point",
    )
    spins = np.abs(waves.rotation[:5, 0])
    limit = np.polyfit(away[:3], spins[:3], 1)[-1]
    recorder.check(
        f"{name}: rotation of the wave at its onset over the frequency of the mode",
        1.0,
        limit / onset.frequency,
        WITHIN,
        source="Ω → Im Λ as the amplitude vanishes",
    )
    # where the run is shortest
    turns = np.abs(waves.rates[:, 0].real) / np.abs(waves.rotation[:, 0])
    index = int(np.argmax(turns))
    return _confirmed(recorder, mix, waves, index, (first.value, onset)), found


def _confirmed(
    recorder: Recorder,
    mix: Mix,
    waves: nrchain.StateBranch,
    index: int,
    thresholds: tuple[float, nrchain.SpecialPoint],
) -> tuple[str | int | float, ...]:
    """A rotating wave against a run that starts off it; returns a row of the table."""
    name, state = mix.title, waves.state(index)
    mode, spin = state.spectrum.leading, abs(float(state.rotation[0]))
    multiplier = math.exp(2.0 * math.pi * mode.growth / spin)
    recorder.bound(
        f"{name}: stable by its multipliers and by the count of growing rates",
        float((multiplier < 1.0) == bool(waves.is_stable[index])),
        least=1.0,
        source="|exp(2πΛ/Ω)| < 1",
    )
    rate = rate_in_run(state, mode)
    recorder.check(
        f"simulated: {name}, rate of the rotating wave at 3t = {waves.values[index]:.5g}",
        1.0,
        rate / mode.growth,
        WITHIN,
        source="a run that starts off the wave by 1e-4 a",
    )
    period = measured_period(state)
    recorder.check(
        f"simulated: {name}, period over 2π/Ω",
        1.0,
        period * spin / (2.0 * math.pi),
        1e-6,
        source="passages of the middle sphere through a plane",
    )
    first, onset = thresholds
    return (
        *(mix.count, "all" if mix.reach == "all" else "nearest", mix.push),
        *(first, onset.value, onset.frequency),
        *(float(waves.values[index]), float(waves.amplitude[index])),
        *(2.0 * math.pi / spin, multiplier),
    )


def measured_period(state: nrchain.State) -> float:
    """Mean time between passages of the middle sphere through z = 0, y > 0, in a run."""
    spin = abs(float(state.rotation[0]))
    end = 3.25 * 2.0 * math.pi / spin
    tight = {"run.rtol": 1e-8, "run.atol": 1e-11}
    scene = nrchain.load_scene(state.scene, **{"run.end": end, "run.snapshots": 2001}, **tight)
    run = nrchain.simulate(scene, positions=state.positions, frames=state.frames)
    middle = run.positions[:, len(state.positions) // 2, 1:]
    angle = np.unwrap(np.arctan2(middle[:, 1], middle[:, 0]))
    turns = np.abs(angle - angle[0]) / (2.0 * math.pi)
    passages = [float(np.interp(k, turns, run.time)) for k in range(4)]
    return float(np.mean([late - early for early, late in pairwise(passages)]))
