"""Right-hand sides with and without an effect: what a scene does not name costs nothing."""

from __future__ import annotations

import numpy as np

from nrchain.motion.model import Model
from validation.performance.scenes import ALL_PAIRS, MODES, PROJECT, curved
from validation.performance.timing import in_turns, rates_of
from validation.report.recorder import Recorder
from validation.report.threads import one_thread


def compare(recorder: Recorder) -> None:
    """Record the time of right-hand sides with and without an effect."""
    rounds = 9 if recorder.quick else 41
    far = {**ALL_PAIRS, "slip.2s": 100.0}
    zeros = {label: 0.0 for label in MODES if label != "slip.2s"}
    shear = {"flow.gradient": [[0, 1e-3, 0], [0] * 3, [0] * 3]}
    cases: list[tuple[str, dict, dict]] = [
        ("3a, 3t and 4a beside 2s, all pairs", far, {**ALL_PAIRS, **MODES}),
        ("zero strengths of 3a, 3t, 4a, all pairs", far, {**far, **zeros}),
        ("finite size of 2s, all pairs", far, {**far, "slip.finite_size": True}),
        ("friction between spheres, all pairs", far, {**far, "friction": "pairwise"}),
        ("all pairs in place of neighbours", {"slip.2s": 100.0}, far),
        ("2s, neighbours", {}, {"slip.2s": 100.0}),
        ("twist, passive", {"elasticity.twist": 0.0}, {}),
        ("twist and bend, passive", {"elasticity.twist": 0.0, "elasticity.bend": 0.0}, {}),
        ("stretch and shear, passive", {"elasticity.stretch": 0.0, "elasticity.shear": 0.0}, {}),
        ("uniform force", {}, {"field.force": [0.0, 0.0, -1.0]}),
        ("shear flow and its disturbance, neighbours", {}, {**shear, "flow.neighbours": 1}),
        ("shear flow and its disturbance, all pairs", {}, shear),
    ]
    rows = []
    for name, less, more in cases:
        tasks = {"without": rates_of(curved(1024, **less)), "with": rates_of(curved(1024, **more))}
        with one_thread():
            found = in_turns(tasks, rounds=rounds)
        ratio = float(np.median(found["with"] / found["without"]))
        without, with_it = (float(np.median(found[key])) for key in ("without", "with"))
        rows.append((name, 1e6 * without, 1e6 * with_it, ratio))
        what = "one right-hand side of 1024 spheres, without and with the effect"
        recorder.benchmark(f"dropping: {name}", without, with_it, what=what)
    recorder.table(
        "Effects left out",
        ["Effect", "Without (μs)", "With (μs)", "With / without"],
        rows,
        "One right-hand side of a chain of 1024 spheres with and without an effect: medians of "
        f"{rounds} turns, one thread; the last column is the median of the ratios turn by turn.",
    )
    ratios = {row[0]: row[3] for row in rows}
    recorder.bound(
        "all-pairs right-hand side with four modes over that with 2s alone",
        ratios[cases[0][0]],
        least=1.6,
        source=PROJECT,
    )
    recorder.bound(
        "modes of zero strength over modes that are absent",
        ratios[cases[1][0]],
        most=1.02,
        source=PROJECT,
    )
    model = Model(curved(16, **cases[1][2]))
    recorder.check(
        "modes in the kernel of a scene with one mode and three of zero strength",
        1,
        len(model.slip.labels),
        0.0,
        source="zero is as good as absent",
    )
