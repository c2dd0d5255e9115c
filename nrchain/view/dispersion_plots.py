"""Draw growth and frequency of waves: the lattice, its rod, the beam limit, and modes of a chain.

Each kind of branch has a column: bending, stretch and twist, shear. Growth is Re Λ and frequency
ω = −Im Λ. Modes of the finite chain are points at the wavenumber of their main wave. The scale is
linear around zero and logarithmic beyond, since rates span orders of magnitude.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.states.mode_waves import ModeWaves
from nrchain.theory.dispersion import Dispersion
from nrchain.theory.lattice import Branch
from nrchain.view.drawing import as_axes, check_picture, letters, new_figure, save
from nrchain.view.style import (
    COLOURS,
    INK,
    LINE,
    PAPER,
    TEXT,
    TITLE,
    WIDTHS,
    style_axes,
    write_key,
    write_title,
)
from nrchain.view.units import label

COLUMNS = {
    "bending": (Branch.BEND_PLUS, Branch.BEND_MINUS),
    "stretch and twist": (Branch.STRETCH, Branch.TWIST),
    "shear": (Branch.SHEAR_PLUS, Branch.SHEAR_MINUS),
}

LOOKS: dict[str, dict[str, Any]] = {
    "lattice": {"linewidth": 2.6, "zorder": 1},
    "rod": {"linewidth": 1.0, "linestyle": "-", "color": INK, "zorder": 2},
    "beam": {"linewidth": 1.0, "linestyle": (0, (3, 2)), "color": INK, "zorder": 3},
}
"""The lines of each theory: the lattice in the colour of its branch, the others dark upon it."""

NAMES = {"lattice": "lattice", "rod": "rod", "beam": "beam limit"}

MODES = "modes of the chain"

POINTS: dict[str, Any] = {
    "marker": "o",
    "markersize": 4.5,
    "markerfacecolor": "none",
    "markeredgewidth": 0.9,
    "linestyle": "",
    "zorder": 4,
}

BRANCHES = (COLOURS[3], COLOURS[1])
"""Colours of the two branches of a panel: dark lines are seen on both."""

THINNER = 0.5
"""Width of the second branch over that of the first: both are seen where they coincide."""

PHASES = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)
"""Ticks of qd."""

DECADES = 4
"""Most ticks of either sign."""

LEAST = 1e-5
"""Fraction of the largest rate of a panel below which its scale is linear, at the least."""

ROUNDING = 1e-12
"""Fraction of the largest rate of a panel below which a rate is drawn as 0."""


PARTS = ("growth", "frequency")
"""What of the rates a panel shows."""


def draw_dispersion(
    found: Dispersion,
    axes: Any = None,
    modes: ModeWaves | None = None,
    *,
    kind: str = "bending",
    part: str = "growth",
    key: bool = True,
) -> Any:
    """Draw Re Λ or −Im Λ of two branches of a scene on axes, and return the axes.

    Parameters
    ----------
    axes
        Of matplotlib; without, those of a new figure, one column wide.
    modes
        Drawn as points: see :func:`nrchain.mode_waves`.
    kind
        ``"bending"``, ``"stretch and twist"`` or ``"shear"``.
    part
        ``"growth"`` or ``"frequency"``.
    key
        Write the key of lines and points into the axes.

    Raises :class:`~nrchain.errors.SceneError` for another kind or part.
    """
    if kind not in COLUMNS:
        raise SceneError("kind", kind, f"must be one of {', '.join(COLUMNS)}")
    if part not in PARTS:
        raise SceneError("part", part, f"must be one of {', '.join(PARTS)}")
    axes = as_axes(axes)
    lines = _draw_kind(axes, found, modes, kind, part)
    if key:
        axes.legend(lines.values(), lines.keys(), frameon=False, fontsize=TEXT, labelcolor=INK)
    return axes


def save_dispersion(
    found: Dispersion, path: str | Path, modes: ModeWaves | None = None, *, title: bool = True
) -> Path:
    """Draw all branches of a scene, and return the path, whose ending chooses PNG, PDF or SVG.

    ``modes`` are drawn as points: see :func:`nrchain.mode_waves`. ``title`` writes that of the
    scene.

    An existing file is replaced. Raises :class:`~nrchain.errors.SceneError` for another ending, and
    :class:`~nrchain.errors.TrajectoryError` for a file that cannot be written.
    """
    path = check_picture(path)
    figure = new_figure(WIDTHS["two"], 4.4, "constrained")
    panels = figure.subplots(2, len(COLUMNS), sharex=True)
    lines: dict[str, Any] = {}
    for column, kind in enumerate(COLUMNS):
        for row, part in enumerate(PARTS):
            lines = _draw_kind(panels[row, column], found, modes, kind, part) | lines
            if column > 0:
                panels[row, column].set(ylabel="")
        write_title(panels[0, column], kind)
        panels[0, column].set(xlabel="")
    write_key(figure, lines, columns=4)
    figure.set(facecolor=PAPER, edgecolor=PAPER)
    if title:
        words = letters(found.scene.title)
        figure.suptitle(words, fontsize=TITLE, fontweight="bold", color=INK)
    save(figure, path)
    return path


def _draw_kind(
    axes: Any, found: Dispersion, modes: ModeWaves | None, kind: str, part: str
) -> dict[str, Any]:
    """Draw a part of the rates of a kind of waves; return one line of each theory."""
    style_axes(axes)
    branches, of = COLUMNS[kind], np.real if part == "growth" else _frequency
    lines = _draw_panel(axes, found, branches, of)
    if modes is not None:
        lines |= _draw_modes(axes, found, modes, branches, of)
    symbol = r"{\rm Re}\,\Lambda" if part == "growth" else r"\omega = -{\rm Im}\,\Lambda"
    axes.set(xlabel="$qd$", ylabel=f"{part}  {label(symbol, found.scene, 'rate')}")
    return lines


def _frequency(rates: np.ndarray) -> np.ndarray:
    """ω of Λ."""
    return -np.imag(rates)


def rates_of(found: Dispersion, theory: str, branch: Branch) -> np.ndarray | None:
    """Λ (n,) of a branch by a theory: "lattice", "rod" or "beam"; None where it has none."""
    if theory == "lattice":
        return found.lattice[:, branch]
    waves = found.rod if theory == "rod" else found.beam
    return waves.column(branch) if waves is not None and branch in waves.branches else None


def _draw_panel(
    axes: Any, found: Dispersion, branches: tuple[Branch, ...], part: Any
) -> dict[str, Any]:
    """Draw one part of the rates of some branches; return one line of each theory."""
    phases = found.wavenumbers * found.scene.chain.spacing
    lines: dict[str, Any] = {}
    for theory, look in LOOKS.items():
        for n, branch in enumerate(branches):
            rates = rates_of(found, theory, branch)
            if rates is None:
                continue
            values = _above_rounding(part(rates), rates)
            width = look["linewidth"] * (1.0 if n == 0 else THINNER)
            own = LINE | {"color": BRANCHES[n]} | look | {"linewidth": width}
            (line,) = axes.plot(phases, values, **own)
            lines.setdefault(NAMES[theory], line)
    for n, branch in enumerate(branches):
        place = (0.03, 0.12 - 0.1 * n)
        axes.text(*place, branch.spoken, transform=axes.transAxes, color=BRANCHES[n], size=TEXT)
    lattice = found.lattice[:, branches]
    _scale(axes, phases, _above_rounding(part(lattice), lattice))
    return lines


def _draw_modes(
    axes: Any, found: Dispersion, modes: ModeWaves, branches: tuple[Branch, ...], part: Any
) -> dict[str, Any]:
    """Draw one part of the rates of modes on some branches; return one line of points."""
    least = found.wavenumbers.min()
    lines: dict[str, Any] = {}
    for n, branch in enumerate(branches):
        own = modes.branches == branch
        phases = np.clip(modes.wavenumbers[own].real, least, None) * found.scene.chain.spacing
        values = _above_rounding(part(modes.rates[own]), found.lattice[:, branches])
        (line,) = axes.plot(phases, values, **POINTS | {"color": BRANCHES[n]}, label=MODES)
        lines.setdefault(MODES, line)
    return lines


def _above_rounding(values: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """A part of rates, 0 within their rounding."""
    return np.where(np.abs(values) > ROUNDING * np.abs(rates).max(), values, 0.0)


def _scale(axes: Any, phases: np.ndarray, lattice: np.ndarray) -> None:
    """Scales and ticks that show all rates of the lattice; those of the rod may leave them."""
    from matplotlib.ticker import FixedLocator, FuncFormatter

    axes.set_xscale("log")
    axes.set_xlim(phases.min(), phases.max())
    axes.xaxis.set_major_locator(FixedLocator(PHASES))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_locator(FixedLocator([]))
    sizes = np.abs(lattice)
    largest = float(sizes.max(initial=0.0))
    if largest == 0.0:
        return
    linear = max(float(sizes[sizes > 0.0].min()), LEAST * largest)
    axes.set_yscale("symlog", linthresh=linear, linscale=0.4)
    low, high = min(float(lattice.min()), 0.0), max(float(lattice.max()), 0.0)
    axes.set_ylim(min(2.0 * low, -linear), max(2.0 * high, linear))
    powers = np.arange(np.ceil(np.log10(linear)), np.floor(np.log10(2.0 * largest)) + 1)
    ticks = 10.0 ** powers[:: -max(1, -(-len(powers) // DECADES))]
    axes.yaxis.set_major_locator(FixedLocator([*-ticks, 0.0, *ticks]))
    axes.yaxis.set_minor_locator(FixedLocator([]))
