"""What the figures of all studies look like."""

from __future__ import annotations

from typing import Any

from nrchain.view import style

MARKERS = "osv^D*P"
SHADES = ("#08306b", "#2171b5", "#d94801", "#7f2704", "#238b45", "#6a51a3", "#525252")
"""Pairs of a dark and a lighter tone; with their markers they differ in greyscale too."""

STYLE: dict[Any, Any] = {
    "font.size": style.TEXT,
    "axes.labelsize": style.LABEL,
    "axes.linewidth": 0.6,
    "axes.edgecolor": style.PALE,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": style.GRID,
    "grid.linewidth": 0.5,
    "xtick.color": style.PALE,
    "ytick.color": style.PALE,
    "xtick.labelcolor": style.INK,
    "ytick.labelcolor": style.INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "mathtext.fontset": "cm",
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.2,
    "lines.markersize": 4.5,
    "figure.constrained_layout.use": True,
}
"""Matplotlib settings of all figures; colours and sizes are those of the package."""
