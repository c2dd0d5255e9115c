"""Figure 4 of the paper: the apolar, achiral chain, 2s."""

from __future__ import annotations

from nrchain.figures.mode import Mode, draw_mode
from nrchain.figures.sheet import FULL, Detail, Sheet, Width
from nrchain.figures.waves import Waves

MODE = Mode(
    title="The apolar, achiral chain (2s)",
    waves=Waves("2s", (100.0, 50.0, -50.0, -100.0), "helix-right", "growth"),
    scenes=("buckling", "stable"),
)


def draw(width: Width = "two", detail: Detail = FULL, title: bool = False) -> Sheet:
    """Draw the figure."""
    return draw_mode(MODE, width, detail, title)
