"""Panel (a): the flow around a squirmer, and the forces and torques on spheres about it.

Lengths are in units of a, velocities in units of V. A sphere that follows the flow feels the force
γ_T u and the torque γ_R ∇ × u/2. The flow of a polar or apolar mode without hand lies in the plane
of its axis; that of a chiral one goes around the axis, and an inset shows the plane across it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt

from nrchain.analysis.flow import Flow, flow
from nrchain.figures.arrows import (
    FORCE,
    NEGLIGIBLE,
    TORQUE,
    axis_glyph,
    draw_arrow,
    draw_axis,
    draw_normal,
    draw_sphere,
    draw_turn,
    force_glyph,
    normal_force_glyph,
    torque_glyph,
    turn_glyph,
    write_arrow_key,
)
from nrchain.hydrodynamics.pystokes import flow_at
from nrchain.scene.loading import load_scene
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.style import DASHES, INK, LINE, PAPER, SIZES, TEXT, style_axes

SIDE = 6.0
"""Half of the side of the plane that is shown, in a."""

TRACERS, RING = 8, 4.2
"""How many tracers, and how far they are from the squirmer, in a."""

SHEET = 2.5
"""x of the plane across the axis of a chiral squirmer, in a."""

FAR = 1e6
"""Distance of a second, passive sphere: scenes have two at least."""

LONGEST = 2.2
"""Length of the longest arrow, in a."""

DECADES = 4
"""Of the magnitude, from the largest down: the range of grey."""

CHIRAL = ("3a", "4a")
POLAR = ("3t", "4a")

TORQUE_OVER_FORCE = 4.0 / 3.0
"""γ_R/γ_T a²."""


def flow_of(label: str, points: np.ndarray) -> Flow:
    """u/V and its vorticity about a sphere of radius 1 at the origin, e₁ along x."""
    scene = load_scene({"chain.particles": 2, "run.end": 1.0, "slip": {label: [1.0, 0.0]}})
    positions = np.array([[[0.0, 0.0, 0.0], [FAR, 0.0, 0.0]]])
    frames = np.broadcast_to(np.eye(3), (1, 2, 3, 3))
    pose = Trajectory(np.zeros(1), positions, frames, scene)
    return flow(pose, points, parts=["slip"])


def tracers(label: str) -> np.ndarray:
    """(m, 3): points on a ring in the plane of the axis, none of them on it.

    About a chiral squirmer the half with y > 0: the other half mirrors it.
    """
    angle = 2.0 * np.pi * (np.arange(TRACERS) + 0.5) / TRACERS
    shown = angle[: TRACERS // 2] if label in CHIRAL else angle
    return RING * np.stack([np.cos(shown), np.sin(shown), 0.0 * shown], axis=1)


def misfit_of_pystokes(label: str) -> float:
    """The largest difference of PyStokes' flow at the tracers, over the largest velocity."""
    points = tracers(label)
    here = flow_of(label, points).velocity
    origin, axis = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]])
    there = flow_at(label, points, origin, axis, np.ones(1), 1.0, 1.0)
    return float(np.abs(here - there).max() / np.abs(here).max())


def show_plane(axes: Any) -> None:
    """Show the plane to :data:`SIDE` on each side, at equal scales."""
    axes.set(xlim=(-SIDE, SIDE), ylim=(-SIDE, SIDE), xlabel="x/a", ylabel="y/a")
    axes.set_aspect("equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.label.set_style("italic")
        axis.set_ticks([-5, 0, 5])
    axes.grid(False)


def draw_squirmer(axes: Any, label: str, points: int, columns: int = 3) -> Any:
    """Draw the flow about a squirmer of a mode, with ``points`` points along a side.

    The key has ``columns`` columns. Returns the image of log₁₀ |u|/V, for a colour bar.
    """
    line = np.linspace(-SIDE, SIDE, points)
    x, y = np.meshgrid(line, line)
    found = flow_of(label, np.stack([x, y, 0.0 * x], axis=-1))
    style_axes(axes)
    image = draw_magnitude(axes, line, found.speed)
    if label in CHIRAL:
        _draw_sheet(axes, label, max(points // 3, 9))
    else:
        draw_streamlines(axes, line, found.velocity[..., :2])
    _draw_tracers(axes, label)
    draw_sphere(axes, np.zeros(2), INK)
    draw_axis(axes, np.zeros(2), np.array([1.0, 0.0]), polar=label in POLAR)
    show_plane(axes)
    kinds = [("axis", axis_glyph(polar=label in POLAR))]
    kinds.append(("force", normal_force_glyph() if label in CHIRAL else force_glyph()))
    if label != "3t":
        kinds.append(("torque", torque_glyph() if label in CHIRAL else turn_glyph()))
    write_arrow_key(axes, kinds, columns=columns)
    return image


def draw_magnitude(axes: Any, line: np.ndarray, speed: np.ndarray) -> Any:
    """Shade log₁₀ of a magnitude (n, n), dark where it is large."""
    with np.errstate(divide="ignore"):
        shade = np.log10(speed)
    top = math.ceil(np.nanmax(shade))
    # smooth between points, so that lines on which nothing moves are not dotted; one more point
    # within spheres carries the shade up to their edge
    shade = np.maximum(shade, top - DECADES)
    away, nearest = distance_transform_edt(np.isnan(shade), return_indices=True)
    shade = np.where(away < 2.0, shade[tuple(nearest)], np.nan)
    image = axes.pcolormesh(
        line, line, shade, cmap=SIZES, vmin=top - DECADES, vmax=top + 2, shading="gouraud"
    )
    image.set(rasterized=True, zorder=0)
    return image


def draw_bar(axes: Any, image: Any) -> None:
    """Draw the bar of the magnitude beside axes."""
    bar = axes.figure.colorbar(image, ax=axes, shrink=0.75, aspect=18, pad=0.02)
    style_axes(bar.ax)
    bar.ax.grid(False)
    sides = {"bottom": False, "left": False, "right": True}
    bar.ax.tick_params(**sides, **{f"label{side}": shown for side, shown in sides.items()})
    bar.outline.set_linewidth(0.5)
    low = image.norm.vmin
    ticks = np.arange(low, low + DECADES + 1)
    bar.ax.set_yticks(ticks, [f"$10^{{{tick:.0f}}}$" for tick in ticks])
    bar.ax.set_ylim(low, low + DECADES + 0.5)
    bar.ax.set_title("$|u|/V$", fontsize=TEXT, color=INK, pad=4, loc="left")


def draw_streamlines(
    axes: Any, line: np.ndarray, velocity: np.ndarray, density: float = 0.8
) -> None:
    """Draw streamlines of a field (n, n, 2)."""
    axes.streamplot(
        line,
        line,
        *np.ma.masked_invalid(np.moveaxis(velocity, -1, 0)),
        density=density,
        linewidth=0.5,
        color=INK,
        arrowsize=0.5,
        arrowstyle="-|>",
        zorder=2,
    )


def _draw_sheet(axes: Any, label: str, points: int) -> None:
    """Draw streamlines in the plane across the axis into an inset."""
    inset = axes.inset_axes((0.6, 0.0, 0.4, 0.4))
    style_axes(inset)
    line = np.linspace(-4.0, 4.0, points)
    y, z = np.meshgrid(line, line)
    found = flow_of(label, np.stack([0.0 * y + SHEET, y, z], axis=-1))
    draw_streamlines(inset, line, found.velocity[..., 1:], density=0.35)
    inset.set(xlim=(-4, 4), ylim=(-4, 4), xticks=[], yticks=[])
    inset.set_aspect("equal")
    inset.grid(False)
    words = f"x = {SHEET:g} a"
    plain = {"facecolor": PAPER, "edgecolor": "none", "pad": 1.0}
    place = {"transform": inset.transAxes, "ha": "center", "va": "top", "bbox": plain}
    inset.text(0.5, 0.98, words, size=TEXT - 2, color=INK, zorder=5, **place)
    look = {"color": INK, "linewidth": 0.6, "linestyle": DASHES[1], "zorder": 2}
    # down to the inset, which would hide the rest
    axes.plot([SHEET, SHEET], [-0.2 * SIDE, 4.0], **LINE | look)


def _draw_tracers(axes: Any, label: str) -> None:
    """Draw tracers, and the force and the torque on each."""
    points = tracers(label)
    found = flow_of(label, points)
    torques = TORQUE_OVER_FORCE * found.vorticity / 2.0
    for place in points:
        draw_sphere(axes, place[:2])
    draw_vectors(axes, points, found.velocity, FORCE, round_arrows=False)
    draw_vectors(axes, points, torques, TORQUE, round_arrows=True)


def draw_vectors(
    axes: Any, points: np.ndarray, vectors: np.ndarray, look: dict[str, Any], *, round_arrows: bool
) -> None:
    """Draw vectors (m, 3) at points of the plane: arrows in it, and signs across it.

    Of torques, those across the plane are round arrows, and those in it have two heads.
    """
    largest = np.linalg.norm(vectors, axis=1).max()
    if largest == 0.0:
        return
    for place, vector in zip(points, vectors / largest, strict=True):
        flat, normal = vector[:2], vector[2]
        if np.linalg.norm(flat) > NEGLIGIBLE:
            draw_arrow(axes, place[:2], LONGEST * flat, look, 1 + round_arrows)
        if abs(normal) > NEGLIGIBLE and round_arrows:
            draw_turn(axes, place[:2], np.sign(normal), look)
        elif abs(normal) > NEGLIGIBLE:
            size = 2.5 + 4.0 * abs(normal)
            draw_normal(axes, place[:2], np.sign(normal), size, look["color"])
