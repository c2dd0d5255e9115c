"""A picture of chains: panels, a title and a bar of the times, saved to a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.scene.derived import modes_text
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.drawing import letters, pick_evenly, save, settle
from nrchain.view.panels import Box, add_axes
from nrchain.view.style import INK, PALE, TEXT, TITLE, write_title
from nrchain.view.units import time_unit


@dataclass(frozen=True)
class Picture:
    """A figure with the chains in it, and the places of the rest, in inches.

    Attributes
    ----------
    figure
        The figure with its panels.
    corner
        Left and bottom of the title.
    bar
        Place of the colour bar.
    note
        A remark on the scales, or empty.
    crop
        The part of the figure to keep; None for all of it.
    """

    figure: Any
    corner: tuple[float, float]
    bar: Box
    note: str
    crop: Box | None = None

    def write_title(self, trajectory: Trajectory) -> None:
        """Write the title of the scene, and below it its slip, ends, size and how the run ended."""
        scene = trajectory.scene
        words = [
            modes_text(scene.slip),
            f"{scene.chain.ends} ends",
            f"N = {scene.chain.particles}",
        ]
        if len(trajectory.time) == 1 or trajectory.status == "stopped":
            stopped = "stopped at " * (trajectory.status == "stopped")
            words.append(f"{stopped}t = {trajectory.time[-1]:.4g}")
        if self.note:
            words.append(self.note)
        if len(trajectory.time) > 1 and (unit := time_unit(scene)):
            words.append(unit)
        title = letters(scene.title)
        (left, bottom), (width, height) = self.corner, self.figure.get_size_inches()
        for up, text, look in (
            (0.28, title, {"fontsize": TITLE, "fontweight": "bold", "color": INK}),
            (0.1, " · ".join(words), {"fontsize": TEXT, "color": PALE}),
        ):
            self.figure.text(left / width, (bottom + up) / height, text, **look)

    def draw_bar(self, colours: np.ndarray, times: np.ndarray) -> None:
        """Draw one colour field a time, if there are several times."""
        if len(times) == 1:
            return
        axes = add_axes(self.figure, self.bar)
        axes.grid(False)
        axes.imshow(
            colours[:, None, :],
            origin="lower",
            aspect="auto",
            interpolation="nearest",
            extent=(0, 1, -0.5, len(times) - 0.5),
        )
        labelled = pick_evenly(len(times), 9)
        axes.set_xticks([])
        axes.set_yticks(labelled, [f"{t:.4g}" for t in times[labelled]])
        axes.yaxis.tick_right()
        axes.tick_params(length=0, pad=3)
        write_title(axes, "t", pad=5, slant="italic")

    def save(self, path: Path) -> None:
        """Write the file; a title that runs out of the figure widens it."""
        from matplotlib.transforms import Bbox

        crop: Any = Bbox.from_bounds(*self.crop) if self.crop else None
        settle(self.figure)
        if any(text.get_window_extent().x1 > self.figure.bbox.x1 for text in self.figure.texts):
            crop = "tight"  # takes twice the time
        save(self.figure, path, crop)
