"""Figure 1 of the paper: two squirmers, their forces and torques, in two frames of reference.

The second panel shows the first after a rigid motion: a rotation and a translation. Its flow and
its forces are computed again from the moved poses, and they are those of the first, rotated. The
two forces do not balance each other, nor do the torques: the interaction is nonreciprocal.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.analysis.flow import flow
from nrchain.figures.arrows import (
    FORCE,
    TORQUE,
    axis_glyph,
    draw_arrow,
    draw_axis,
    draw_sphere,
    draw_turn,
    force_glyph,
    turn_glyph,
)
from nrchain.figures.keys import write_glyphs
from nrchain.figures.sheet import FULL, Detail, Sheet, Width, new_sheet
from nrchain.figures.squirmer import SIDE, draw_bar, draw_magnitude, draw_streamlines, show_plane
from nrchain.motion.wrenches import active_wrenches
from nrchain.scene.loading import load_scene
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.style import INK, style_axes, write_letter

SLIP = {"2s": 1.0}

PLACES = np.array([[-2.2, -0.6, 0.0], [2.2, 0.6, 0.0]])
ANGLES = np.radians([20.0, 100.0])
"""Where the squirmers are, in a, and the directions of their axes in the plane."""

TURN, SHIFT = np.radians(65.0), np.array([0.8, -0.6, 0.0])
"""The rigid motion: a rotation about z and a translation."""

LONGEST = 2.2
"""Length of the longest arrow, in a."""


def rotation(angle: float) -> np.ndarray:
    """(3, 3): about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def poses(moved: bool) -> tuple[np.ndarray, np.ndarray]:
    """(2, 3) and (2, 3, 3): the squirmers before or after the rigid motion."""
    frames = np.stack([rotation(angle).T for angle in ANGLES])
    if not moved:
        return PLACES, frames
    turn = rotation(TURN)
    return PLACES @ turn.T + SHIFT, frames @ turn.T


def forces(moved: bool) -> tuple[np.ndarray, np.ndarray]:
    """F and T (2, 3) of the squirmers before or after the rigid motion."""
    return active_wrenches(*poses(moved), SLIP)


def draw(width: Width = "two", detail: Detail = FULL, title: bool = False) -> Sheet:
    """Draw the figure."""
    words = "Two pushers (2s) in two frames of reference" if title else ""
    figure = new_sheet(width, 3.5 if width == "two" else 6.3, words)
    panels = figure.subplots(1, 2) if width == "two" else figure.subplots(2, 1)
    for letter, axes, moved in zip("ab", panels, (False, True), strict=True):
        _draw_panel(axes, moved, detail.points)
        write_letter(axes, letter)
    here, there = forces(False), forces(True)
    size = np.linalg.norm(here[0], axis=1).max() / (6.0 * np.pi)
    entries = [
        ("axis", axis_glyph(polar=False)),
        ("sense of the torque", turn_glyph()),
        (rf"force, the longest ${size:.2g}\,\gamma_T V$", force_glyph()),
    ]
    write_glyphs(figure, entries, 3 if width == "two" else 2, loc="outside lower center")
    turn = rotation(TURN).T
    misfit = max(
        float(np.abs(one @ turn - other).max() / np.abs(one).max())
        for one, other in zip(here, there, strict=True)
    )
    unbalanced = np.linalg.norm(here[0].sum(axis=0)) / np.linalg.norm(here[0], axis=1).max()
    remarks = (
        f"forces and torques follow the rigid motion to {misfit:.1e} of the largest",
        f"the two forces leave {unbalanced:.2f} of the larger one unbalanced",
    )
    return Sheet(figure, remarks)


def _draw_panel(axes: Any, moved: bool, points: int) -> None:
    """Draw the squirmers in one frame of reference."""
    positions, frames = poses(moved)
    scene = load_scene({"chain.particles": 2, "run.end": 1.0, "slip": SLIP})
    pose = Trajectory(np.zeros(1), positions[None], frames[None], scene)
    line = np.linspace(-SIDE, SIDE, points)
    x, y = np.meshgrid(line, line)
    found = flow(pose, np.stack([x, y, 0.0 * x], axis=-1), parts=["slip"])
    style_axes(axes)
    draw_bar(axes, draw_magnitude(axes, line, found.speed))
    draw_streamlines(axes, line, found.velocity[..., :2], density=1.0)
    force, torque = forces(moved)
    largest = np.linalg.norm(force, axis=1).max()
    for place, frame, push, turn in zip(positions, frames, force, torque, strict=True):
        draw_sphere(axes, place[:2], INK)
        draw_axis(axes, place[:2], frame[0, :2], polar=False)
        # from the surface: an arrow from the middle would hide the axis
        surface = place[:2] + push[:2] / np.linalg.norm(push)
        draw_arrow(axes, surface, LONGEST * push[:2] / largest, FORCE)
        draw_turn(axes, place[:2], np.sign(turn[2]), TORQUE)
    show_plane(axes)
