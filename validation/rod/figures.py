"""The same shape by both: spheres of the chain and the line of the rod."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from validation.report.recorder import Recorder
from validation.report.style import SHADES
from validation.rod.cases import CASES, chain_of, chain_positions, rod_motion, start

SPHERES = 31


def draw(recorder: Recorder) -> None:
    """Record the figure."""
    recorder.figure(
        "shapes",
        _shapes(),
        f"Chains of {SPHERES} spheres (circles) and their rods (lines) at the end of the runs, and "
        "the start (dotted), over L. Upper row along y, lower row along z.",
    )


def _shapes() -> Figure:
    figure = Figure(figsize=(11.0, 4.4))
    panels = figure.subplots(2, len(CASES))
    for column, case in enumerate(CASES.values()):
        scene = chain_of(case, SPHERES)
        spheres = chain_positions(case, scene)
        shape, positions, frames = rod_motion(case, scene)
        fine = np.linspace(0.0, shape.length, 200)
        line = shape.at(fine, positions, frames)[0]
        before = start(case, shape.length, fine)[0]
        for row, axis in enumerate((1, 2)):
            panel = panels[row, column]
            for curve, style in ((before, ":"), (line, "-")):
                panel.plot(*(curve[:, [0, axis]] / shape.length).T, style, color=SHADES[0])
            panel.plot(
                *(spheres[:, [0, axis]] / shape.length).T, "o", color=SHADES[2],
                markerfacecolor="none", markersize=4,
            )  # fmt: skip
            panel.set_aspect("equal", adjustable="datalim")
        panels[0, column].set_title(case.title, fontsize=9)
    panels[0, 0].set_ylabel("y/L")
    panels[1, 0].set_ylabel("z/L")
    figure.supxlabel("x/L", fontsize=9)
    return figure
