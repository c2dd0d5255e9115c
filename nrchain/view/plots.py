"""Draw a chain at several times: its three projections, or in perspective.

Lengths are in units of the sphere radius a. All directions and the spheres have the same scale,
unless the chain is so slender that its shape would be lost. Then the directions across it are
stretched, and the picture states the factor.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from nrchain.errors import SceneError
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.chain_views import draw_planes, draw_space
from nrchain.view.drawing import as_axes, check_drawable, check_snapshots
from nrchain.view.one_chain import INSIDE, PLANES, draw_flat, draw_in_space, frame_key
from nrchain.view.panels import equal_scales
from nrchain.view.shown import Spacing, choose

VIEWS = ("planes", "3d")

Spheres = Literal["auto", "scale", "dots"]
SPHERES: tuple[Spheres, ...] = ("auto", "scale", "dots")


def draw_chain(
    trajectory: Trajectory,
    axes: Any = None,
    *,
    plane: str = "xy",
    times: int = 6,
    spacing: Spacing = "linear",
    spheres: Spheres = "auto",
    frames: bool = False,
) -> Any:
    """Draw the chain at ``times`` snapshots on axes, one colour a time, and return the axes.

    Lengths are in units of a, with one scale for both directions. Later chains are darker.

    Parameters
    ----------
    axes
        Of matplotlib, with ``projection="3d"`` for the plane ``"3d"``; without, those of a new
        figure, one column wide.
    plane
        The projection: ``"xy"``, ``"xz"``, ``"yz"``, or ``"3d"`` for perspective.
    times, spacing
        How many snapshots, from first to last, at ``"linear"`` or ``"logarithmic"`` times.
    spheres
        ``"auto"``: to scale, as far as they are seen; ``"scale"``: to scale for any number of
        spheres; ``"dots"``: dots of one size.
    frames
        Draw e₁ (thick) and e₂ (thin, with a circle) of up to 12 spheres: spinning is seen.

    Raises :class:`~nrchain.errors.SceneError` for an option that is not allowed, and
    :class:`~nrchain.errors.TrajectoryError` for a trajectory without snapshots.

    >>> trajectory = nrchain.simulate(nrchain.load_scene("passive", **{"run.end": 1.0}))
    >>> axes = nrchain.plots.draw_chain(trajectory, plane="xz", times=3)
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('x/a', 'z/a')
    """
    _check_spheres(spheres)
    if plane not in (*PLANES, "3d"):
        raise SceneError("plane", plane, f"must be one of {', '.join(PLANES)}, 3d")
    check_snapshots(trajectory)
    shown = choose(trajectory, times, spacing)
    space = plane == "3d"
    axes = as_axes(axes, projection="3d" if space else None)
    equal_scales(axes, shown.chains, (0, 1, 2) if space else PLANES[plane])
    if space:
        draw_in_space(axes, shown, spheres, frames)
    else:
        draw_flat(axes, shown, PLANES[plane], spheres, frames)
    if frames:
        frame_key(axes, INSIDE)
    return axes


def save_chain(
    trajectory: Trajectory,
    path: str | Path,
    *,
    view: str = "planes",
    times: int = 6,
    spacing: Spacing = "linear",
    spheres: Spheres = "auto",
    frames: bool = False,
    title: bool = True,
) -> Path:
    """Draw the chain at ``times`` snapshots, first to last, and return the path of the picture.

    ``view`` is ``"planes"`` for the projections on xy, xz and yz, or ``"3d"`` for perspective. The
    ending of ``path`` chooses PNG, PDF or SVG. An existing file is replaced. ``title`` writes that
    of the scene, and how it was run. Other options are those of :func:`draw_chain`.

    Raises :class:`~nrchain.errors.SceneError` for an option that is not allowed, for another ending
    and for less than one time, and :class:`~nrchain.errors.TrajectoryError` for a trajectory
    without snapshots and for a file that cannot be written.
    """
    if view not in VIEWS:
        raise SceneError("view", view, f"must be one of {', '.join(VIEWS)}")
    _check_spheres(spheres)
    path = check_drawable(trajectory, path)
    shown = choose(trajectory, times, spacing)
    picture = (draw_planes if view == "planes" else draw_space)(shown, spheres, frames)
    if title:
        picture.write_title(trajectory)
    picture.draw_bar(shown.colours, shown.time)
    picture.save(path)
    return path


def _check_spheres(spheres: str) -> None:
    if spheres not in SPHERES:
        raise SceneError("spheres", spheres, f"must be one of {', '.join(SPHERES)}")
