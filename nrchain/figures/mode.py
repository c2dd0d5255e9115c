"""A figure of one mode of slip: flow, response, waves and runs, as panels (a) to (e)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nrchain.figures.evolution import draw_evolution, run
from nrchain.figures.response import draw_response, fit
from nrchain.figures.sheet import Detail, Sheet, Width, new_sheet
from nrchain.figures.squirmer import draw_bar, draw_squirmer, misfit_of_pystokes
from nrchain.figures.waves import Waves, draw_waves
from nrchain.view.style import write_letter

HEIGHT = 5.0
"""Of a figure of two columns, in inches."""

ROWS = (2.65, 1.4, 2.3)
"""Heights of (a), (b) and (c) in one column, in inches; (d) and (e) have that of (b)."""


@dataclass(frozen=True)
class Mode:
    """What the figure of a mode shows.

    Attributes
    ----------
    title
        Of the figure, where one is asked for.
    waves
        Of panel (c); its first strength is that of panel (b).
    scenes
        The shipped scenes of panels (d) and (e).
    frames
        Whether those show e₁ and e₂.
    planar
        Whether those stay in the plane z = 0, and only x and y are drawn.
    """

    title: str
    waves: Waves
    scenes: tuple[str, ...]
    frames: bool = False
    planar: bool = False


def draw_mode(mode: Mode, width: Width, detail: Detail, title: bool) -> Sheet:
    """Draw the figure of a mode."""
    height = HEIGHT if width == "two" else sum(ROWS) + len(mode.scenes) * ROWS[1]
    figure = new_sheet(width, height, mode.title if title else "")
    label = mode.waves.label
    flow, response, waves, runs = _panels(figure, width, mode)
    image = draw_squirmer(flow, label, detail.points, 2 if width == "two" else 3)
    draw_bar(flow, image)
    draw_response(response, label, mode.waves.strengths[0])
    worst = draw_waves(waves, mode.waves, detail.lengths, detail.strengths)
    drawn = [
        draw_evolution(panels, run(name, detail.changes), frames=mode.frames)
        for panels, name in zip(runs, mode.scenes, strict=True)
    ]
    heads = (flow, response[0], waves, *(panels[0] for panels in runs))
    for letter, axes in zip("abcde", heads, strict=False):
        write_letter(axes, letter)
    # scales of axes follow from their places
    figure.get_layout_engine().execute(figure)
    fit(response)
    for one in drawn:
        one.stretch()
    remarks = (
        f"flow at the tracers: PyStokes differs by {misfit_of_pystokes(label):.1e} of the largest",
        f"waves: runs differ from the lattice by {worst:.1e} of its rate at most",
    )
    return Sheet(figure, remarks)


def _panels(figure: Any, width: Width, mode: Mode) -> tuple[Any, Any, Any, list[Any]]:
    """Axes of (a); the two of (b); of (c); and one axes or two for each run."""
    scenes, count = len(mode.scenes), 2 - mode.planar
    if width == "two":
        top, bottom = figure.add_gridspec(2, 1, height_ratios=[1.45, 1.0])
        places = list(top.subgridspec(1, 3, width_ratios=[1.0, 1.15, 1.0]))
        flow, waves = figure.add_subplot(places[0]), figure.add_subplot(places[2])
        pairs = [places[1].subgridspec(2, 1)]
        pairs += [end.subgridspec(count, 1) for end in bottom.subgridspec(1, scenes)]
        response, *runs = [[figure.add_subplot(part) for part in pair] for pair in pairs]
        return flow, response, waves, runs
    parts = figure.subfigures(3 + scenes, 1, height_ratios=[*ROWS, *[ROWS[1]] * scenes])
    flow, waves = parts[0].subplots(), parts[2].subplots()
    response = list(parts[1].subplots(1, 2))
    return (
        flow,
        response,
        waves,
        [list(part.subplots(1, count, squeeze=False)[0]) for part in parts[3:]],
    )
