"""The figures of the study of long range: ratios against qd, and errors against neighbours."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nrchain import rod
from nrchain.theory.rod.reach import Direction
from validation.long_range.runs import Run
from validation.report.recorder import Recorder

STYLES: dict[tuple[str, Direction], tuple[str, str, str, str]] = {
    ("2s", "transverse"): ("-", "o", "0.0", "2s bending"),
    ("3a", "transverse"): ("--", "s", "0.0", "3a bending"),
    ("3t", "transverse"): ("-", "^", "0.5", "3t bending"),
    ("4a", "transverse"): ("--", "v", "0.5", "4a bending"),
    ("3t", "longitudinal"): (":", "D", "0.5", "3t along x"),
}
"""2s along x is left out: it has the same ratio as its bending waves."""

READ_AT = 0.05


def draw(recorder: Recorder, runs: list[Run]) -> None:
    recorder.figure(
        "ratio",
        _ratio(runs),
        "Active rate with all pairs over that with nearest neighbours: lines, the lattice sums; "
        "symbols, simulated periodic chains; thin lines, the limits 3/2 − ln qd, 4/3 − ln qd and "
        "ζ(3). The ratio of 2s and 3a grows without bound with the wavelength.",
    )
    recorder.figure(
        "neighbours",
        _neighbours(),
        f"Relative error of the active rate with k neighbours on each side, at qd = "
        f"{READ_AT}. 2s and 3a turn down only where k covers a wavelength, "
        f"k ≈ {2 * np.pi / READ_AT:.0f}; beyond it the sums oscillate.",
    )


def _ratio(runs: list[Run]) -> Figure:
    figure = Figure(figsize=(4.8, 3.7))
    panel = figure.subplots()
    phases, tiny = np.geomspace(0.01, 3.0, 200), np.geomspace(0.01, 1.5, 60)
    for kind, (style, marker, color, name) in STYLES.items():
        panel.semilogx(phases, rod.reach_ratio(kind[0], phases, "all", kind[1]), style, color=color)
        of_kind = [run for run in runs if (run.label, run.direction) == kind]
        panel.plot(
            [run.phase for run in of_kind],
            [run.ratio for run in of_kind],
            marker,
            color=color,
            mfc="white",
            label=name,
        )
    for kind in STYLES:
        if kind[1] == "transverse" and kind[0] != "4a":
            limit = rod.reach_limit(kind[0], tiny)
            panel.plot(
                tiny,
                limit if kind[0] != "3t" else 0 * tiny + limit[0],
                color="0.7",
                lw=0.7,
                zorder=1,
            )
    panel.set(xlabel="qd", ylabel="Λ, all pairs / nearest neighbours", ylim=(0.4, 6.3))
    panel.legend(loc="upper right")
    return figure


def _neighbours() -> Figure:
    figure = Figure(figsize=(4.8, 3.5))
    panel = figure.subplots()
    counts = np.unique(np.geomspace(1, 1000, 160).astype(int))
    for kind, (style, _, color, name) in STYLES.items():
        every = rod.reach_sum(kind[0], READ_AT, "all", kind[1])
        missed = [
            abs(float(rod.reach_sum(kind[0], READ_AT, int(k), kind[1]) / every) - 1) for k in counts
        ]
        panel.loglog(counts, missed, style, color=color, label=name)
    for level in (0.1, 0.01, 0.001):
        panel.axhline(level, color="0.8", linewidth=0.8)
    panel.set(
        xlabel="neighbours k on either side",
        ylabel=r"$|\Lambda_k - \Lambda|\ /\ |\Lambda|$",
        ylim=(1e-6, 1.0),
    )
    panel.legend(loc="lower left")
    return figure
