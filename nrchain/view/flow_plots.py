"""Draw the flow of the fluid in a plane: streamlines, magnitude and the spheres that it cuts.

Lengths are in units of the sphere radius a, with one scale for both directions. The velocity is
that in the lab. Streamlines follow its part in the plane; grey is the magnitude of all of it, on a
logarithmic scale.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.analysis.flow import Part, flow, poses_of, unknown_flows
from nrchain.errors import SceneError
from nrchain.inputs.arguments import finite_array
from nrchain.inputs.rules import number
from nrchain.scene.scene import Scene
from nrchain.trajectory.trajectory import Snapshot, Trajectory
from nrchain.view.drawing import as_axes, check_drawable, letters, new_figure, save
from nrchain.view.one_chain import PLANES
from nrchain.view.panels import AXES
from nrchain.view.style import COLOURS, INK, LABEL, PAPER, SIZES, TEXT, WIDTHS, style_axes
from nrchain.view.style import write_title as write_name
from nrchain.view.units import label

ACROSS = 400
"""Points of the grid along its longer side."""

ROOM = 10.0
"""Least space about a chain, in radii."""

SLENDER = 0.35
"""Least ratio of the sides of the picture."""

DARKEST = 0.55
"""Of the colours of magnitude, so that lines are seen on them."""

SPANS = 1e-3, 0.995
"""The least magnitude that has a colour, over the largest; and the quantile of the largest."""

ACCURACY = 1e-4
"""Of the flow, relative to its largest value."""

Window = tuple[float, float, float, float]
"""Left, right, bottom and top of a picture, in radii."""


def draw_flow(
    source: Scene | Trajectory | Snapshot,
    axes: Any = None,
    *,
    plane: str = "xy",
    at: float | None = None,
    frame: int = -1,
    parts: Iterable[Part] | None = None,
    window: Sequence[float] | None = None,
    density: float = 1.0,
    bar: bool = True,
) -> Any:
    """Draw the flow of :func:`nrchain.flow` in a plane on axes, and return the axes.

    Spheres are drawn as the plane cuts them, to scale.

    Parameters
    ----------
    source, frame, parts
        As for :func:`nrchain.flow`.
    axes
        Of matplotlib; without, those of a new figure, one column wide.
    plane
        ``"xy"``, ``"xz"`` or ``"yz"``.
    at
        The third coordinate of the plane, in the unit of length of the scene; None: that of the
        sphere in the middle.
    window
        Left, right, bottom and top of the picture, in radii; None: the chain, with room about it.
    density
        Of streamlines; 1 is about 30 along the longer side.
    bar
        Draw the bar of the magnitudes.

    Raises :class:`~nrchain.errors.SceneError` for an option that is not allowed, and the errors of
    :func:`nrchain.flow`.

    >>> scene = nrchain.load_scene("buckling")
    >>> axes = nrchain.flow_plots.draw_flow(scene, plane="xz", parts=["slip"])
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('x/a', 'z/a')
    """
    if plane not in PLANES:
        raise SceneError("plane", plane, f"must be one of {', '.join(PLANES)}")
    density = number(above=0, most=10)("density", density)
    scene, positions, _ = poses_of(source, frame)
    shown = PLANES[plane]
    level = _level(scene, positions, shown, at)
    centres, radii = _sections(scene, positions, shown, level)
    limits = _window(scene, positions, shown, window)
    axes = as_axes(axes)
    style_axes(axes)
    horizontal, vertical = _grid(limits)
    a = scene.chain.radius
    points = np.full((len(vertical), len(horizontal), 3), level)
    points[..., shown[0]], points[..., shown[1]] = np.meshgrid(a * horizontal, a * vertical)
    found = flow(source, points, frame=frame, parts=parts, accuracy=ACCURACY)
    _draw_magnitude(axes, scene, limits, found.speed, bar)
    _draw_lines(axes, horizontal, vertical, found.velocity[..., shown], density)
    _draw_spheres(axes, centres, radii)
    axes.set(xlim=limits[:2], ylim=limits[2:], aspect="equal")
    for name, direction in zip("xy", shown, strict=True):
        getattr(axes, f"set_{name}label")(f"{AXES[direction]}/a", style="italic")
    axes.grid(False)
    return axes


def save_flow(
    trajectory: Trajectory,
    path: str | Path,
    *,
    plane: str = "xy",
    at: float | None = None,
    frame: int = -1,
    parts: Iterable[Part] | None = None,
    title: bool = True,
) -> Path:
    """Draw the flow of a snapshot in a plane, two columns wide, and return the path of the picture.

    The ending of ``path`` chooses PNG, PDF or SVG. An existing file is replaced. ``title`` writes
    that of the scene, the time and the place of the plane. Other options and errors are those of
    :func:`draw_flow`; :class:`~nrchain.errors.TrajectoryError` too for a file that cannot be
    written.
    """
    path = check_drawable(trajectory, path)
    if plane not in PLANES:
        raise SceneError("plane", plane, f"must be one of {', '.join(PLANES)}")
    scene, positions, _ = poses_of(trajectory, frame)
    left, right, bottom, top = _window(scene, positions, PLANES[plane], None)
    wide = WIDTHS["two"]
    tall = min(0.85 * wide * (top - bottom) / (right - left) + 0.8, 6.0)
    figure = new_figure(wide, tall, "constrained")
    axes = figure.add_subplot()
    draw_flow(trajectory, axes, plane=plane, at=at, frame=frame, parts=parts, density=1.5)
    if title:
        level = _level(scene, positions, PLANES[plane], at) / scene.chain.radius
        place = f"t = {trajectory.time[frame]:.4g}, {AXES[3 - sum(PLANES[plane])]} = {level:.3g} a"
        if missing := unknown_flows(scene):
            place += f", without {', '.join(missing)}"
        name = f"{scene.title}: " if scene.title else ""
        write_name(axes, letters(f"{name}flow at {place}"))
    save(figure, path)
    return path


def _level(scene: Scene, positions: np.ndarray, shown: tuple[int, int], at: float | None) -> float:
    """The third coordinate of the plane; by default that of the sphere in the middle of it."""
    if at is not None:
        return number()("at", at)
    along = np.sort(positions[:, 3 - sum(shown)])
    return float(along[len(along) // 2])


def _sections(
    scene: Scene, positions: np.ndarray, shown: tuple[int, int], level: float
) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 2) and radii (n,) of the circles in which the plane cuts spheres, in radii.

    A periodic chain shows its images on either side.
    """
    copies = [positions]
    if scene.period:
        shift = np.array([scene.period, 0.0, 0.0])
        copies += [positions - shift, positions + shift]
    centres = np.concatenate(copies) / scene.chain.radius
    squares = 1.0 - (centres[:, 3 - sum(shown)] - level / scene.chain.radius) ** 2
    cut = squares > 0.0
    return centres[cut][:, shown], np.sqrt(squares[cut])


def _window(
    scene: Scene, positions: np.ndarray, shown: tuple[int, int], given: Sequence[float] | None
) -> Window:
    """The part of the plane that is drawn, in radii."""
    if given is not None:
        left, right, bottom, top = finite_array("window", given, (4,)).tolist()
        if not (left < right and bottom < top):
            raise SceneError("window", tuple(given), "must be left < right and bottom < top")
        return left, right, bottom, top
    chain = positions[:, shown] / scene.chain.radius
    least, most = chain.min(axis=0), chain.max(axis=0)
    sides = most - least + 2.0 * np.maximum(ROOM, 0.08 * (most - least).max())
    sides = np.maximum(sides, SLENDER * sides.max())
    middle = (least + most) / 2
    (left, bottom), (right, top) = middle - sides / 2, middle + sides / 2
    return float(left), float(right), float(bottom), float(top)


def _grid(limits: Window) -> tuple[np.ndarray, np.ndarray]:
    """Evenly spaced coordinates of a grid with about square cells."""
    left, right, bottom, top = limits
    cell = max(right - left, top - bottom) / ACROSS
    columns, rows = (max(round(side / cell), 8) + 1 for side in (right - left, top - bottom))
    return np.linspace(left, right, columns), np.linspace(bottom, top, rows)


def _draw_magnitude(axes: Any, scene: Scene, limits: Window, speed: np.ndarray, bar: bool) -> None:
    """Fill the plane with |u| in grey, on a logarithmic scale."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap, LogNorm
    from scipy.ndimage import distance_transform_edt

    nowhere = np.isnan(speed)
    known = speed[~nowhere]
    largest = float(np.quantile(known, SPANS[1])) if known.size else 0.0
    if largest <= 0.0:
        return
    # spheres cover the points inside them, which take the nearest value up to their edge
    row, column = distance_transform_edt(nowhere, return_distances=False, return_indices=True)
    shades = ListedColormap(colormaps[SIZES](np.linspace(0.0, DARKEST, 256)))
    least = max(SPANS[0] * largest, float(known.min()))
    least = min(least, 0.5 * largest)
    image = axes.imshow(
        np.maximum(speed[row, column], least),
        origin="lower",
        extent=limits,
        cmap=shades,
        norm=LogNorm(least, largest, clip=True),
        interpolation="bilinear",
        zorder=0,
    )
    if bar:
        place = axes.inset_axes((1.02, 0.0, 0.025, 1.0))
        scale = axes.figure.colorbar(image, cax=place)
        scale.ax.tick_params(labelsize=TEXT, width=0.6, length=2.5, color=INK, labelcolor=INK)
        scale.ax.minorticks_off()
        scale.set_label(label("|u|", scene, "speed"), size=LABEL, color=INK)
        scale.outline.set_linewidth(0.6)


def _draw_lines(
    axes: Any, horizontal: np.ndarray, vertical: np.ndarray, velocity: np.ndarray, density: float
) -> None:
    """Draw the streamlines of (rows, columns, 2) velocities; none where nothing moves."""
    along, across = (np.ma.masked_invalid(velocity[..., k]) for k in range(2))
    if not (np.ma.max(np.abs(along)) > 0.0 or np.ma.max(np.abs(across)) > 0.0):
        return
    sides = np.array([np.ptp(horizontal), np.ptp(vertical)])
    axes.streamplot(
        horizontal,
        vertical,
        along,
        across,
        density=tuple(density * sides / sides.max()),
        color=COLOURS[0],
        linewidth=0.6,
        arrowsize=0.6,
        zorder=1,
    )


def _draw_spheres(axes: Any, centres: np.ndarray, radii: np.ndarray) -> None:
    """Draw the circles in which the plane cuts spheres."""
    from matplotlib.collections import EllipseCollection

    sizes = 2.0 * radii
    circles = EllipseCollection(
        sizes, sizes, 0 * sizes, units="xy", offsets=centres, offset_transform=axes.transData
    )
    circles.set(facecolor=PAPER, edgecolor=INK, linewidth=0.6, zorder=3)
    axes.add_collection(circles, autolim=False)
