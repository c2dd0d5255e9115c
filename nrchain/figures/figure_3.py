"""Figure 3 of the paper: which stress and which source each strain causes, mode by mode.

The upper row shows the strains of a rod. Below, each mode of slip has a row: the stress (F, M) and
the source (f, m) that its chain has per strain, from the measured moduli of the chain
(:func:`nrchain.moduli`), less those of the passive chain. Lengths are in units of d, which makes
all of them forces; each row is over its largest entry. Directions 2 and 3 are equivalent.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.figures.arrows import FORCE, TORQUE
from nrchain.figures.keys import Glyph, write_glyphs
from nrchain.figures.sheet import FULL, Detail, Sheet, Width, new_sheet
from nrchain.scene.loading import load_scene
from nrchain.theory.rod.coarse_graining import moduli
from nrchain.theory.rod.constants import Constants
from nrchain.view.style import COLOURS, DASHES, INK, LABEL, LINE, PALE, PAPER, TEXT

MODES = {"2s": "apolar, achiral", "3a": "apolar, chiral", "3t": "polar, achiral"}
MODES |= {"4a": "polar, chiral"}

STRAINS = {"stretch  $\\epsilon_1$": 0, "twist  $\\tau_1$": 3, "shear  $\\epsilon_2$": 1}
STRAINS |= {"bend  $\\tau_3$": 5}
"""The columns, and the indices of their strains."""

NAMES = [f"{letter}{n}" for letter in "FM" for n in "₁₂₃"]
NAMES += [f"{letter}{n}" for letter in "fm" for n in "₁₂₃"]

LEAST = 1e-6
"""Fraction of the largest entry of a mode below which an entry is zero."""

SECOND: dict[str, Any] = {"color": COLOURS[2], "linewidth": 1.3, "linestyle": DASHES[2]}
"""The look of e₂."""

SPHERES = np.arange(-2, 3)
"""Of the drawn rods, along x, in d."""


def responses(label: str) -> tuple[np.ndarray, float]:
    """(12, 6): (F, M, f, m) per strain over the largest of them, and that one over γ_T V.

    Forces are in units of γ_T V, lengths in d.
    """
    scene = load_scene({"chain.particles": 20, "run.end": 1.0, "slip": {label: 1.0}})
    active: Constants = moduli(scene).active
    d = scene.chain.spacing
    angular = np.repeat([0.0, 1.0], 3)  # M, m and τ: one more length, one less
    powers = -angular[:, None] - angular[None, :]
    table = np.concatenate([active.C * d**powers, active.H * d ** (powers + 1.0)])
    table /= scene.drag.translation
    largest = float(np.abs(table).max())
    return table / largest, largest


def entries(table: np.ndarray, strain: int) -> list[tuple[str, float, int]]:
    """Names, values and row numbers of the responses (12, 6) to a strain that do not vanish."""
    column = table[:, strain]
    return [(NAMES[n], value, n) for n, value in enumerate(column) if abs(value) > LEAST]


def draw(width: Width = "two", detail: Detail = FULL, title: bool = False) -> Sheet:
    """Draw the figure; it has one detail."""
    words = "Constitutive relations of active chains" if title else ""
    two = width == "two"
    figure = new_sheet(width, 4.1 if two else 4.6, words)
    ratios = [0.9] + [1.0] * len(MODES)
    cells = figure.subplots(1 + len(MODES), len(STRAINS), height_ratios=ratios)
    for axes in cells.flat:
        _blank(axes)
    for axes, (name, strain) in zip(cells[0], STRAINS.items(), strict=True):
        draw_strain(axes, strain)
        axes.set_title(name, fontsize=LABEL if two else LABEL - 1, color=INK, pad=2)
    remarks = []
    for row, (label, kind) in zip(cells[1:], MODES.items(), strict=True):
        table, largest = responses(label)
        for axes, strain in zip(row, STRAINS.values(), strict=True):
            _draw_entries(axes, entries(table, strain), TEXT if two else TEXT - 2)
        unit = rf"$[{largest:.3g}\,\gamma_T V]$"
        head = f"{label}\n" + kind.replace(" ", "\n") if two else label
        look = {"rotation": 0.0, "ha": "center", "va": "center", "labelpad": 24.0} if two else {}
        row[0].set_ylabel(f"{head}\n{unit}", fontsize=TEXT if two else TEXT - 1, color=INK, **look)
        remarks.append(f"{label}: entries are in units of {largest:.3g} γ_T V")
    _write_key(figure, two)
    return Sheet(figure, tuple(remarks))


def _blank(axes: Any) -> None:
    """A cell: a pale frame without ticks."""
    axes.set(xticks=[], yticks=[], facecolor=PAPER, xlim=(-3.0, 3.0), ylim=(-1.0, 1.0))
    for spine in axes.spines.values():
        spine.set(visible=True, color=PALE, linewidth=0.4)


def draw_strain(axes: Any, strain: int) -> None:
    """Draw a rod under a strain, spheres with e₁ and e₂, on axes that hold −3 … 3."""
    s = SPHERES.astype(float)
    x, y = 0.85 * s, 0.0 * s
    tilt, roll = 0.0 * s, 0.0 * s
    if strain == 0:
        x = 1.15 * s
    elif strain == 3:
        roll = 0.7 * s
    elif strain == 1:
        tilt = tilt - 0.7
    else:
        tilt = 0.35 * s
        y = 0.14 * s**2 - 0.3
    axes.plot(x, y, **LINE | {"color": INK, "linewidth": 0.8})
    look = {"linestyle": "", "marker": "o", "markersize": 4.0, "markerfacecolor": PAPER}
    axes.plot(x, y, **LINE | look | {"markeredgecolor": INK, "markeredgewidth": 0.8})
    ends = {
        0: (0.5 * np.cos(tilt), 0.5 * np.sin(tilt)),
        1: (-0.6 * np.sin(tilt) * np.cos(roll), 0.6 * np.cos(tilt) * np.cos(roll)),
    }
    for vector, (right, up) in ends.items():
        points = np.stack([x, x + right, x * np.nan, y, y + up, y * np.nan]).reshape(2, 3, -1)
        style = FORCE if vector == 0 else SECOND
        axes.plot(*points.transpose(0, 2, 1).reshape(2, -1), **LINE | style)


def _draw_entries(axes: Any, found: list[tuple[str, float, int]], size: float) -> None:
    """Write responses in a cell, a line each: an arrow of its kind, its name and its value."""
    if not found:
        axes.text(0.0, 0.0, "–", ha="center", va="center", color=PALE, size=size)
    heights = np.linspace(0.35 * (len(found) - 1), -0.35 * (len(found) - 1), len(found))
    for (name, value, number), height in zip(found, heights, strict=True):
        _draw_kind(axes, -2.1, height, number)
        words = f"{name}  {value:+.2g}".replace("-", "−")
        axes.text(-1.3, height, words, ha="left", va="center", color=INK, size=size)


def _draw_kind(axes: Any, x: float, y: float, number: int) -> None:
    """Draw the arrow of a response: straight or round, with two heads for a stress."""
    from matplotlib.patches import FancyArrowPatch

    stress, angular = number < 6, number % 6 > 2
    look = TORQUE if not stress else FORCE
    bow = "arc3,rad=-0.6" if angular else "arc3"
    arrow = FancyArrowPatch(
        (x - 0.5, y - 0.08 * angular),
        (x + 0.5, y - 0.08 * angular),
        arrowstyle="<|-|>" if stress else "-|>",
        connectionstyle=bow,
        mutation_scale=6,
        shrinkA=0,
        shrinkB=0,
    )
    arrow.set(color=look["color"], linewidth=1.1, zorder=3)
    axes.add_patch(arrow)


def _write_key(figure: Any, two: bool) -> None:
    from matplotlib.lines import Line2D

    def kind(number: int) -> Glyph:
        return Glyph(lambda axes: _draw_kind(axes, 0.0, -0.1 * (number % 6 > 2), number), 16.0)

    entries = [
        ("$e_1$", Line2D([], [], **LINE | FORCE)),
        ("$e_2$", Line2D([], [], **LINE | SECOND)),
        ("stress F", kind(0)),
        ("stress M", kind(3)),
        ("source f", kind(6)),
        ("source m", kind(9)),
    ]
    write_glyphs(figure, entries, 6 if two else 3, loc="outside lower center")
