"""Draw a film of a chain by matplotlib: its three projections, or perspective.

Lengths are in units of the sphere radius a. All directions and the spheres have the same scale,
which fits the chain at all times. Directions across a slender chain are stretched, and the film
states the factor.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from nrchain.analysis.measured_chain import require_trajectory
from nrchain.errors import SceneError, TrajectoryError
from nrchain.inputs.rules import is_whole
from nrchain.scene.derived import modes_text
from nrchain.scene.unwrapping import unwrapped_chain
from nrchain.trajectory.file import refuse_existing
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.drawing import letters, require_matplotlib
from nrchain.view.film_files import FILMS, check_film, film_file
from nrchain.view.film_panels import FilmPanels, planes_panels, space_panels
from nrchain.view.film_times import chosen_snapshots, pick_frames
from nrchain.view.plots import VIEWS
from nrchain.view.shown import FRAME_LENGTH, Spacing
from nrchain.view.units import time_name

WIDTH, LEAST_WIDTH, MOST_WIDTH = 1000, 320, 8192


def film(
    trajectory: Trajectory,
    path: str | Path,
    *,
    view: str = "planes",
    times: int | None = None,
    spacing: Spacing = "linear",
    fps: float = 25.0,
    frames: bool = True,
    width: int = WIDTH,
    title: bool = True,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Draw the chain at one snapshot after the other, as MP4 or GIF; return the path of the film.

    The chain at the first snapshot is pale.

    Parameters
    ----------
    trajectory
        The run; it may still go on.
    path
        A file that ends in .mp4 or .gif. MP4 needs ffmpeg, on the path or by imageio-ffmpeg.
    view
        ``"planes"``, the projections on xy, xz and yz, or ``"3d"`` for perspective.
    times, spacing
        How many snapshots, from first to last, at ``"linear"`` or ``"logarithmic"`` times: by
        default all, and at most 250. Each is one frame, and nothing is interpolated.
    fps
        Frames per second.
    frames
        Draw e₂ of every sphere, so that spinning is seen; in projections that are to scale.
    width
        Width of the film in pixels; its height follows from the panels.
    title
        Write the title of the scene and how it was run.
    overwrite
        Whether an existing file may be replaced.
    progress
        Called with the number of frames drawn and that of all frames.

    Raises
    ------
    SceneError
        For an argument that is not allowed, and wrapped positions whose image is not clear.
    TrajectoryError
        For a trajectory without snapshots, and for a file that exists or cannot be written.
    MissingLibraryError
        For an MP4 where no ffmpeg is found; it says what to install.

    >>> import tempfile
    >>> scene = nrchain.load_scene("buckling", **{"chain.particles": 6, "run.end": 20.0})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     nrchain.film(nrchain.simulate(scene), f"{folder}/film.gif", times=3).name
    'film.gif'
    """
    if view not in VIEWS:
        raise SceneError("view", view, f"must be one of {', '.join(VIEWS)}")
    if not is_whole(width) or not LEAST_WIDTH <= width <= MOST_WIDTH:
        allowed = f"must be a whole number of pixels from {LEAST_WIDTH} to {MOST_WIDTH}"
        raise SceneError("width", width, allowed)
    path = Path(path)
    if path.suffix.lower() not in FILMS:
        raise SceneError("film", str(path), f"must end in one of {', '.join(FILMS)}")
    refuse_existing(path, overwrite)
    check_film(path, fps)
    if not len(require_trajectory(trajectory)):
        raise TrajectoryError("the trajectory has no finished snapshot to draw")
    shown = chosen_snapshots(trajectory, pick_frames(trajectory.time, times, spacing))
    require_matplotlib()
    panels = _panels(shown, view, frames, title)
    with film_file(path, fps) as add:
        drawn = panels.images(shown.time, shown.frames, width)
        for number, image in enumerate(drawn, 1):
            add(image)
            if progress:
                progress(number, len(shown.time))
    return path


def _panels(trajectory: Trajectory, view: str, frames: bool, title: bool) -> FilmPanels:
    """The panels of a film, with their title."""
    scene, chain = trajectory.scene, trajectory.scene.chain
    chains = unwrapped_chain(scene, trajectory.positions) / chain.radius
    side = FRAME_LENGTH * chain.spacing / chain.radius * frames
    panels = (planes_panels if view == "planes" else space_panels)(chains, side)
    words = [modes_text(scene.slip), f"{chain.ends} ends", f"N = {chain.particles}"]
    if panels.note:
        words.append(panels.note)
    if title:
        panels.write_title(letters(scene.title), "   ·   ".join(words))
    panels.write_key()
    panels.unit = time_name(scene)
    return panels
