"""Draw a chain at several times: its three projections, or in perspective.

Lengths are in units of the sphere radius a. All directions and the spheres have the same scale,
unless the chain is so slender that its shape would be lost. Then the directions across it are
stretched, and the picture states the factor.
"""

from __future__ import annotations

from pathlib import Path

from nrchain.errors import SceneError
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.chain_views import draw_planes, draw_space
from nrchain.view.drawing import check_drawable, pick_evenly
from nrchain.view.style import time_colours

VIEWS = ("planes", "3d")


def draw_chain(
    trajectory: Trajectory, path: str | Path, *, view: str = "planes", times: int = 6
) -> Path:
    """Draw the chain at ``times`` snapshots, first to last, and return the path of the picture.

    ``view`` is ``"planes"`` for the projections on xy, xz and yz, or ``"3d"`` for perspective. The
    ending of ``path`` chooses PNG, PDF or SVG. An existing file is replaced.

    Raises :class:`~nrchain.errors.SceneError` for another view, for another ending and for less
    than one time, and :class:`~nrchain.errors.TrajectoryError` for a trajectory without snapshots
    and for a file that cannot be written.
    """
    if view not in VIEWS:
        raise SceneError("view", view, f"must be one of {', '.join(VIEWS)}")
    if times < 1:
        raise SceneError("times", times, "must be at least 1")
    path = check_drawable(trajectory, path)
    chosen = pick_evenly(len(trajectory.time), times)
    chains = trajectory.positions[chosen] / trajectory.scene.chain.radius
    colours = time_colours(len(chosen))
    picture = (draw_planes if view == "planes" else draw_space)(chains, colours)
    picture.write_title(trajectory)
    picture.draw_bar(colours, trajectory.time[chosen])
    picture.save(path)
    return path
