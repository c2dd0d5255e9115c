"""A figure of one mode of slip: flow, response, waves and runs, as panels (a) to (e)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nrchain.figures.evolution import draw_evolution, run
from nrchain.figures.response import draw_response
from nrchain.figures.sheet import Detail, Sheet, Width, new_sheet
from nrchain.figures.squirmer import draw_bar, draw_squirmer, misfit_of_pystokes
from nrchain.figures.waves import Waves, draw_waves
from nrchain.view.style import write_letter

HEIGHTS = {"one": 9.6, "two": 5.0}
"""Of a figure, in inches."""


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
    """

    title: str
    waves: Waves
    scenes: tuple[str, ...]
    frames: bool = False


def draw_mode(mode: Mode, width: Width, detail: Detail, title: bool) -> Sheet:
    """Draw the figure of a mode."""
    figure = new_sheet(width, HEIGHTS[width], mode.title if title else "")
    label = mode.waves.label
    flow, response, waves, runs = _panels(figure, width, len(mode.scenes))
    image = draw_squirmer(flow, label, detail.points)
    draw_bar(flow, image)
    draw_response(response, label, mode.waves.strengths[0])
    worst = draw_waves(waves, mode.waves, detail.lengths, detail.strengths)
    for panels, name in zip(runs, mode.scenes, strict=True):
        draw_evolution(panels, run(name, detail.changes), frames=mode.frames)
    heads = (flow, response[0], waves, *(panels[0] for panels in runs))
    for letter, axes in zip("abcde", heads, strict=False):
        write_letter(axes, letter)
    remarks = (
        f"flow at the tracers: PyStokes differs by {misfit_of_pystokes(label):.1e} of the largest",
        f"waves: runs differ from the lattice by {worst:.1e} of its rate at most",
    )
    return Sheet(figure, remarks)


def _panels(figure: Any, width: Width, scenes: int) -> tuple[Any, Any, Any, list[Any]]:
    """Axes of (a); the two of (b); of (c); and pairs of axes for each run."""
    if width == "two":
        top, bottom = figure.add_gridspec(2, 1, height_ratios=[1.45, 1.0])
        places = list(top.subgridspec(1, 3))
        ends = list(bottom.subgridspec(1, scenes))
    else:
        heights = [2.2, 2.0, 2.0] + [2.0] * scenes
        every = list(figure.add_gridspec(3 + scenes, 1, height_ratios=heights))
        places, ends = every[:3], every[3:]
    flow, waves = figure.add_subplot(places[0]), figure.add_subplot(places[2])
    response = _pair(figure, places[1])
    return flow, response, waves, [_pair(figure, place) for place in ends]


def _pair(figure: Any, place: Any) -> list[Any]:
    """Two axes, one above the other."""
    return [figure.add_subplot(part) for part in place.subgridspec(2, 1)]
