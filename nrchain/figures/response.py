"""Panel (b): the forces of slip on a chain that is displaced across itself by a wave.

One wavelength of a periodic chain, frames along it, to scale. A force in the plane of the wave is
an arrow in the upper axes; axes below show x and z.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nrchain.figures.arrows import FORCE, NEGLIGIBLE, draw_arrow, force_glyph, write_arrow_key
from nrchain.figures.sheet import is_above
from nrchain.figures.squirmer import CHIRAL
from nrchain.motion.wrenches import active_wrenches
from nrchain.scene.loading import load_scene
from nrchain.scene.poses import initial_poses
from nrchain.view.style import INK, LINE, PAPER, TEXT, style_axes

PARTICLES, HEIGHT = 12, 12.0
"""Spheres of a wave, and its amplitude in a."""

LONGEST, HEAD = 9.0, 4.5
"""Length of the longest arrow, in a, less than the spacing; and size of its head, in points.

On narrow axes every other sphere has an arrow, of twice the length.
"""


def forces(label: str, strength: float) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) and (N, 3): positions of a wave and forces γ_T Σ u of the slip of both neighbours."""
    scene = load_scene(
        {
            "chain": {"particles": PARTICLES, "ends": "periodic"},
            "start": {"shape": "sine", "amplitude": HEIGHT},
            "run": {"end": 1.0},
        }
    )
    positions, frames = initial_poses(scene)
    # one more period on each side stands for the others
    shift = np.array([scene.length, 0.0, 0.0])
    many = np.concatenate([positions - shift, positions, positions + shift])
    found, _ = active_wrenches(many, np.tile(frames, (3, 1, 1)), {label: strength})
    return positions, found[PARTICLES : 2 * PARTICLES]


def draw_response(panels: Sequence[Any], label: str, strength: float) -> None:
    """Draw the wave and its forces on two axes.

    Of a mode whose force lies in the plane of the wave, they show V and −V; of a chiral one, y and
    z against x.
    """
    upper, lower = panels
    narrow = not is_above(upper, lower)
    if label in CHIRAL:
        _draw_side(upper, label, strength, 1, narrow)
        _draw_side(lower, label, strength, 2, narrow)
    else:
        _draw_side(upper, label, strength, 1, narrow)
        _draw_side(lower, label, -strength, 1, narrow)
    if not narrow:
        upper.tick_params(labelbottom=False)
        upper.set_xlabel("")
    upper.figure.align_ylabels(panels)
    write_arrow_key(lower, [("force of the slip", force_glyph())])


def fit(panels: Sequence[Any]) -> None:
    """Give x and y one scale on axes whose places in the figure are known."""
    for axes in panels:
        wide, tall = axes.get_window_extent().size
        left, right = axes.get_xlim()
        half = 0.5 * (right - left) * tall / wide
        axes.set_ylim(-half, half)


def _draw_side(axes: Any, label: str, strength: float, across: int, narrow: bool) -> None:
    """Draw the wave and its forces on axes of x and of y (1) or z (2)."""
    positions, found = forces(label, strength)
    largest = np.linalg.norm(found, axis=1).max()
    style_axes(axes)
    flat = positions[:, [0, across]]
    axes.plot(*flat.T, **LINE | {"color": INK, "linewidth": 0.8})
    look = {"linestyle": "", "marker": "o", "markersize": 3.2, "markerfacecolor": PAPER}
    axes.plot(*flat.T, **LINE | look | {"markeredgecolor": INK, "markeredgewidth": 0.7})
    every = slice(1, None, 2) if narrow else slice(None)
    longest = LONGEST * (1 + narrow)
    for place, force in zip(flat[every], found[every][:, [0, across]] / largest, strict=True):
        if (part := float(np.linalg.norm(force))) > NEGLIGIBLE:
            draw_arrow(axes, place, longest * force, FORCE, size=HEAD * (0.5 + 0.5 * part))
    margin = 1.1 * longest
    axes.set_xlim(positions[0, 0] - margin, positions[-1, 0] + margin)
    axes.set(xlabel="x/a", ylabel=f"{'xyz'[across]}/a")
    for axis in (axes.xaxis, axes.yaxis):
        axis.label.set_style("italic")
        axis.get_major_locator().set_params(nbins=4 if narrow else 5)
    words = "V > 0" if strength > 0 else "V < 0"
    place = {"transform": axes.transAxes, "ha": "right", "va": "top"}
    axes.text(0.97, 0.94, words, color=INK, size=TEXT - 1, **place)
