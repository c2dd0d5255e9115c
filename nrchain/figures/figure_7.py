"""Figure 7 of the paper: the polar, chiral chain, 4a."""

from __future__ import annotations

from nrchain.figures.mode import Mode, draw_mode
from nrchain.figures.sheet import FULL, Detail, Sheet, Width
from nrchain.figures.waves import Waves

MODE = Mode(
    title="The polar, chiral chain (4a)",
    waves=Waves("4a", (10000.0, 5000.0, -5000.0, -10000.0), "helix-right", "velocity"),
    scenes=("spiral-left", "spiral-right"),
    frames=True,
)


def draw(width: Width = "two", detail: Detail = FULL, title: bool = False) -> Sheet:
    """Draw the figure."""
    return draw_mode(MODE, width, detail, title)
