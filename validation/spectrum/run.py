"""Do finite chains grow at their eigenvalues, and turn unstable where the spectrum says?

A periodic chain has the rates of plane waves at q = 2πk/Nd, which the lattice gives by another way.
Clamped chains of 2s buckle, those of 3a coil. With 3t, whose forces follow the tangents, 2s
flutters and the coil of 3a travels. Each critical strength is found three times: by
:func:`nrchain.critical_strength`; from runs that start with a small bend; and by the law of a rod,
with the prestress, the pre-moment and the following force of the paper's Appendix C. Chain and rod
differ by the order (d/L)².
"""

from __future__ import annotations

import math

import numpy as np

import nrchain
from validation.report.recorder import Recorder
from validation.spectrum import figures, laws, simulated
from validation.spectrum.cases import DISTANT, LINKS, NEAR, Case, settling_time

COUNTS = (40, 80, 160)

CLOSE = 3e-3
"""Of the rod and the limit of chains by (N − 1)⁻²: a coefficient that is off by 1 % is found."""

LARGEST = 25.0
"""Bound on the distance of chain and rod, in (N − 1)⁻²."""

WITHIN = 1e-2
"""Of thresholds in runs and in spectra."""

DECAYED = 0.02
"""Length of runs, in units of ΓL⁴/κ: the third mode has decayed by e⁻¹⁰ and more."""

EULER_SOURCE = "Euler's load of a rod with clamped ends, 4π²κ/L²"


def study(recorder: Recorder) -> None:
    recorder.step("the rod")
    _rod(recorder)
    recorder.step("periodic chains and plane waves")
    _waves(recorder)
    rows, misses = [], {}
    counts = COUNTS[:2] if recorder.quick else COUNTS
    for case in NEAR:
        recorder.step(case.title)
        misses[case.title] = _against_the_rod(recorder, case, counts)
        rows.append(_against_runs(recorder, case, 20))
    for case in DISTANT[:1] if recorder.quick else DISTANT:
        recorder.step(case.title)
        rows.append(_against_runs(recorder, case, 20))
    if not recorder.quick:
        recorder.step("longer chains")
        rows += [_against_runs(recorder, case, 40) for case in NEAR]
    recorder.step("figures")
    recorder.table(
        "Critical strengths of clamped chains",
        ["Chain", "N", "Key", "Spectrum", "Runs", "Rod", "Frequency", "In runs"],
        rows,
        "Strengths at which the straight chain turns unstable, or stable (3t straightens 2s), and "
        "the frequency of the leading mode there. λ = 10³, a = η = 1, d = 10.",
    )
    recorder.figure("order", figures.order(misses), figures.ORDER_CAPTION)
    recorder.figure("flutter", figures.flutter(recorder.quick), figures.FLUTTER_CAPTION)
    recorder.text(
        "Clamped pushers buckle at **Euler's load of their prestress**, V = 12π²μd/7a²γ_T(N−1)², "
        "and chains of 3a coil at the moment at which a clamped shaft does. A pusher that is "
        "buckled is straightened by 3t and flutters at larger 3t: the law of the rod with the "
        "tension of the following forces gives both strengths and the frequency."
    )


def _rod(recorder: Recorder) -> None:
    """The collocation of the rod, against closed results."""
    for name, expected, source in (
        ("p", laws.EULER, EULER_SOURCE),
        ("m", laws.GREENHILL, "Greenhill's shaft with fixed ends, tan x = x"),
    ):
        value, _ = laws.critical(laws.Loads(), name, 0.5 * expected, 1.5 * expected)
        recorder.check(f"rod: critical {name}", expected, value, 1e-8, source=source)
    first = laws.rates(laws.Loads())[0].real
    recorder.check(
        "rod: slowest rate, passive",
        -(4.730040744862704**4),
        first,
        1e-8,
        source="cos βL cosh βL = 1",
    )


def _waves(recorder: Recorder) -> None:
    """All 6N eigenvalues of a ring, against the exact lattice."""
    count, strengths = 12, {"2s": 3.0, "3a": 20.0, "3t": 50.0, "4a": 200.0}
    mixes = [{label: value} for label, value in strengths.items()] + [strengths]
    for mix in mixes:
        for reach, far in (("nearest", {}), ("all pairs", {"slip.neighbours": "all"})):
            scene = nrchain.load_scene(
                {
                    "chain": {"particles": count, "ends": "periodic"},
                    "start.shape": "straight",
                    "run": {"end": 1.0},
                }
                | {f"slip.{label}": value for label, value in mix.items()}
                | LINKS
                | far
            )
            found = nrchain.spectrum(scene)
            waves = 2.0 * math.pi * np.arange(-5, 7) / (count * scene.chain.spacing)
            exact = nrchain.lattice_rates(scene, waves, frame="spinning").ravel()
            every = np.concatenate([found.rates, found.neutral.rates])
            apart = np.abs(every[:, None] - exact)
            worst = max(apart.min(axis=0).max(), apart.min(axis=1).max()) / np.abs(exact).max()
            recorder.bound(
                f"a ring of {' + '.join(mix)}, {reach}: rates and plane waves, over the largest",
                worst,
                most=1e-10,
                source="lattice_rates at q = 2πk/Nd",
            )


def _against_the_rod(
    recorder: Recorder, case: Case, counts: tuple[int, ...]
) -> list[tuple[int, float]]:
    """Relative distance of chain and rod at each N; it falls as 1/(N − 1)²."""
    load, turning = case.law()
    ratios, turns = [], []
    for count in counts:
        found = case.found(count)
        ratios.append(found.value * case.unit(count) / load)
        turns.append(found.frequency * settling_time(case.scene(count)))
    recorder.check(
        f"{case.title}: critical strength of long chains over that of the rod",
        1.0,
        _limit(counts, ratios),
        CLOSE,
        source="the rod with prestress, pre-moment and following force (Appendix C)",
    )
    recorder.bound(
        f"{case.title}: chain of N = {counts[-1]} and rod, distance times (N − 1)²",
        abs(ratios[-1] - 1.0) * (counts[-1] - 1) ** 2,
        most=LARGEST,
        source="the order (d/L)²",
    )
    if turning > 1.0:
        recorder.check(
            f"{case.title}: frequency of long chains over that of the rod",
            1.0,
            _limit(counts, turns) / turning,
            CLOSE,
            source="the same law",
        )
    return [(count, ratio - 1.0) for count, ratio in zip(counts, ratios, strict=True)]


def _limit(counts: tuple[int, ...], values: list[float]) -> float:
    """The limit of values that approach it as (N − 1)⁻², from the last two."""
    short, long = ((count - 1) ** 2 for count in counts[-2:])
    return (long * values[-1] - short * values[-2]) / (long - short)


def _against_runs(recorder: Recorder, case: Case, count: int) -> tuple[str | int | float, ...]:
    """The threshold in runs; returns a row of the table."""
    scene, found = case.scene(count), case.found(count)
    end = DECAYED * settling_time(scene)
    value, frequency = simulated.critical(scene, case.key, found.value, end)
    recorder.check(
        f"simulated: {case.title}, N = {count}: critical strength over that of the spectrum",
        1.0,
        value / found.value,
        WITHIN,
        source="growth of a small bend in runs, interpolated to zero",
    )
    if found.frequency:
        recorder.check(
            f"simulated: {case.title}, N = {count}: frequency over that of the spectrum",
            1.0,
            frequency / found.frequency,
            WITHIN,
            source="the same runs",
        )
    rod = "" if case.far else case.law()[0] / case.unit(count)
    return case.title, count, case.key, found.value, value, rod, found.frequency, frequency
