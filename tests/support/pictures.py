"""Pictures against small stored ones: what is where, not which letters or pixels.

A picture is made grey and averaged over blocks to :data:`ACROSS` columns. After a wanted change,
``store(path, name)`` keeps the new one.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

STORED = Path(__file__).parents[1] / "pictures"

ACROSS = 64
"""Columns of a stored picture."""

MEAN, WORST = 0.01, 0.12
"""Largest mean and single difference of brightness, from 0 (black) to 1 (white)."""


def small(path: Path) -> np.ndarray:
    """The picture in grey, (rows, :data:`ACROSS`), from 0 to 1."""
    from PIL import Image

    with Image.open(path) as picture:
        rows = round(ACROSS * picture.height / picture.width)
        shrunk = picture.convert("L").resize((ACROSS, rows), Image.Resampling.BOX)
        return np.asarray(shrunk, float) / 255.0


def store(path: Path, name: str) -> None:
    """Keep the picture as the one to compare with."""
    from PIL import Image

    STORED.mkdir(exist_ok=True)
    Image.fromarray(np.round(255 * small(path)).astype(np.uint8)).save(STORED / f"{name}.png")


def assert_looks_like(path: Path, name: str) -> None:
    """The picture has the shape of the stored one and is as dark everywhere."""
    found, expected = small(path), small(STORED / f"{name}.png")
    assert found.shape == expected.shape
    off = np.abs(found - expected)
    assert off.mean() <= MEAN, f"{name}: brightness is off by {off.mean():.3f} on average"
    assert off.max() <= WORST, f"{name}: brightness is off by {off.max():.3f} at most"
