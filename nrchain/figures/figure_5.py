"""Figure 5 of the paper: the apolar, chiral chain, 3a."""

from __future__ import annotations

from nrchain.figures.mode import Mode, draw_mode
from nrchain.figures.sheet import FULL, Detail, Sheet, Width
from nrchain.figures.waves import Waves

MODE = Mode(
    title="The apolar, chiral chain (3a)",
    waves=Waves("3a", (5000.0, 2500.0, -2500.0, -5000.0), "helix-right", "growth"),
    scenes=("helix-left", "helix-right"),
)


def draw(width: Width = "two", detail: Detail = FULL, title: bool = False) -> Sheet:
    """Draw the figure."""
    return draw_mode(MODE, width, detail, title)
