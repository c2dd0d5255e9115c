"""Figure 6 of the paper: the polar, achiral chain, 3t."""

from __future__ import annotations

from nrchain.figures.mode import Mode, draw_mode
from nrchain.figures.sheet import FULL, Detail, Sheet, Width
from nrchain.figures.waves import Waves

MODE = Mode(
    title="The polar, achiral chain (3t)",
    waves=Waves("3t", (1000.0, 500.0, -500.0, -1000.0), "sine", "velocity"),
    scenes=("wave",),
    planar=True,
)


def draw(width: Width = "two", detail: Detail = FULL, title: bool = False) -> Sheet:
    """Draw the figure."""
    return draw_mode(MODE, width, detail, title)
