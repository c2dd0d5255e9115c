"""The figures of the paper, small and grey: alike for other releases of fonts.

``python tests/support/grey_figures.py`` draws the stored ones anew, to be looked at before they are
kept.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import image
from scipy.ndimage import gaussian_filter

from nrchain.figures.catalogue import NUMBERS, draw_figure
from nrchain.figures.sheet import Detail

COARSE = Detail(
    points=31,
    lengths=(16, 28),
    strengths=2,
    changes={"chain.particles": 8, "run.end": 8.0, "run.snapshots": 9},
)
"""Figures of few points and short runs."""

DOTS_PER_INCH = 36
"""A letter of 8 points is 4 dots high: its form hardly counts."""

SMOOTHING = 3.0
"""Dots over which greys are averaged: most of a letter."""

TILES = (3, 4)
"""Rows and columns of parts that are compared: a panel that changes is not lost in the whole."""

TOLERANCE = 0.03
"""Largest root mean square difference of a part, greys being between 0 and 1.

All letters in another font differ by 0.016, unhinted ones by 0.019, a picture that is moved by a
dot by 0.018; one of three panels that is left out differs by 0.04.
"""

FOLDER = Path(__file__).parents[1] / "figures" / "pictures"


def grey(figure) -> np.ndarray:
    """(h, w): the figure as it is drawn at few dots, from 0, black, to 1, white."""
    figure.set_dpi(DOTS_PER_INCH)
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[..., :3].mean(axis=2) / 255.0


def difference(first: np.ndarray, second: np.ndarray) -> float:
    """The largest root mean square difference of parts of two greys; infinite for other sizes."""
    if np.abs(np.subtract(first.shape, second.shape)).max() > 1:
        return np.inf
    height, width = np.minimum(first.shape, second.shape)
    squares = gaussian_filter(first[:height, :width] - second[:height, :width], SMOOTHING) ** 2
    rows, columns = TILES
    parts = [
        part for row in np.array_split(squares, rows) for part in np.array_split(row, columns, 1)
    ]
    return float(np.sqrt(max(part.mean() for part in parts)))


def stored(name: str) -> np.ndarray:
    """(h, w): the grey of a stored picture."""
    return image.imread(FOLDER / f"{name}.png")[..., :3].mean(axis=2)


def store(name: str, values: np.ndarray) -> None:
    """Write a picture of 16 greys, of a few kB."""
    from PIL import Image

    greys = (np.round(values * 15.0) * 17.0).astype(np.uint8)
    Image.fromarray(greys).quantize(16).save(FOLDER / f"{name}.png", optimize=True)


if __name__ == "__main__":
    for number in NUMBERS:
        store(f"figure-{number}", grey(draw_figure(number, detail=COARSE).figure))
