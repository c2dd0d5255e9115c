"""Panel (b): the forces of slip on a chain that is displaced across itself by a wave.

One wavelength of a periodic chain, frames along it, to scale. A force in the plane of the wave is
an arrow in the upper axes; axes below show x and z.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nrchain.figures.arrows import FORCE, NEGLIGIBLE, draw_arrow, write_arrow_key
from nrchain.figures.squirmer import CHIRAL
from nrchain.motion.wrenches import active_wrenches
from nrchain.scene.loading import load_scene
from nrchain.scene.poses import initial_poses
from nrchain.view.style import INK, LINE, PAPER, TEXT, style_axes

PARTICLES, HEIGHT = 12, 12.0
"""Spheres of a wave, and its amplitude in a."""

LONGEST, HEAD = 16.0, 5.0
"""Length of the longest arrow, in a, and size of its head, in points."""


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
    if label in CHIRAL:
        _draw_side(upper, label, strength, 1)
        _draw_side(lower, label, strength, 2)
    else:
        _draw_side(upper, label, strength, 1)
        _draw_side(lower, label, -strength, 1)
    upper.tick_params(labelbottom=False)
    upper.set_xlabel("")
    upper.figure.align_ylabels(panels)
    write_arrow_key(lower, [("force of the slip", FORCE)])


def _draw_side(axes: Any, label: str, strength: float, across: int) -> None:
    """Draw the wave and its forces on axes of x and of y (1) or z (2)."""
    positions, found = forces(label, strength)
    largest = np.linalg.norm(found, axis=1).max()
    style_axes(axes)
    flat = positions[:, [0, across]]
    axes.plot(*flat.T, **LINE | {"color": INK, "linewidth": 0.8})
    look = {"linestyle": "", "marker": "o", "markersize": 3.2, "markerfacecolor": PAPER}
    axes.plot(*flat.T, **LINE | look | {"markeredgecolor": INK, "markeredgewidth": 0.7})
    for place, force in zip(flat, found[:, [0, across]] / largest, strict=True):
        if np.linalg.norm(force) > NEGLIGIBLE:
            draw_arrow(axes, place, LONGEST * force, FORCE, size=HEAD)
    margin = 1.2 * LONGEST
    least = np.array([positions[0, 0] - margin, -HEIGHT - margin])
    most = np.array([positions[-1, 0] + margin, HEIGHT + margin])
    axes.update_datalim([least, most])
    axes.margins(0.0)
    axes.set(xlabel="x/a", ylabel=f"{'xyz'[across]}/a")
    axes.set_aspect("equal", adjustable="datalim")
    for axis in (axes.xaxis, axes.yaxis):
        axis.label.set_style("italic")
        axis.get_major_locator().set_params(nbins=5)
    words = "V > 0" if strength > 0 else "V < 0"
    place = {"transform": axes.transAxes, "ha": "right", "va": "top"}
    axes.text(0.97, 0.94, words, color=INK, size=TEXT - 1, **place)
