"""Draw a chain in three dimensions: a picture, a film or a window."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.analysis.measured_chain import require_trajectory
from nrchain.errors import SceneError, TrajectoryError
from nrchain.inputs.optional import optional
from nrchain.inputs.rules import is_whole, whole
from nrchain.scene.unwrapping import unwrapped_chain
from nrchain.trajectory.file import refuse_existing
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.film_files import FILMS, check_film, check_folder, film_file, is_film, write_png
from nrchain.view.film_times import chosen_snapshots, pick_frames
from nrchain.view.shown import Spacing
from nrchain.view.space.camera import View, direction
from nrchain.view.space.colouring import PLAIN, Colouring, colouring
from nrchain.view.space.opengl import require_display, require_opengl
from nrchain.view.space.stage import Look, Stage
from nrchain.view.space.tracers import Tracers, trace

ENDINGS = (".png", *FILMS)
SIZE, GIF_SIZE = (1280, 720), (800, 450)
LEAST_SIDE, MOST_SIDE = 64, 8192


def render(
    trajectory: Trajectory,
    path: str | Path | None,
    *,
    colour: str = PLAIN,
    colour_scale: Spacing = "linear",
    view: View = "slant",
    follow: bool = False,
    frames: bool = True,
    tube: bool = True,
    tracers: int = 0,
    size: tuple[int, int] | None = None,
    snapshot: int = -1,
    times: int | None = None,
    spacing: Spacing = "linear",
    fps: float = 25.0,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Path | None:
    """Draw a chain in three dimensions: a PNG of one snapshot, a film of many, or a window.

    Spheres, their spacing and the centreline are to scale. Without a ``colour`` the half of each
    sphere along e₁ is dark, so that its turning is seen.

    Parameters
    ----------
    trajectory
        The run; it may still go on.
    path
        A file that ends in .png, .mp4 or .gif; None opens a window with a slider over the
        snapshots, and returns when it is closed.
    colour
        ``"plain"``; ``"speed"`` |v| or ``"spin"`` |ω| of every sphere; ``"stretch"``, ``"shear"``,
        ``"bend"`` or ``"twist"`` of every link; or ``"effect:NAME"``, what one effect contributes
        to the motion of every sphere (:func:`nrchain.contributions`). Colours mean the same in all
        frames.
    colour_scale
        ``"linear"``, from 0 or symmetric about it, or ``"logarithmic"``, over four decades.
    view
        From where: ``"slant"``, ``"x"``, ``"y"``, ``"z"``, or azimuth and elevation in degrees.
        The camera is as near as it can be to see the whole chain in all frames.
    follow
        Whether the camera moves with the middle of the chain.
    frames, tube
        Whether to draw e₁ (dark) and e₂ (orange) of every sphere, and the centreline.
    tracers
        How many tracers the flow of the fluid (:func:`nrchain.flow`) carries past the chain, with
        the paths behind them. Where the fluid moves too far from frame to frame, they are slower
        than the chain, and the film says how much. A PNG shows paths in the flow of its time.
    size
        Width and height in pixels: 1280 × 720, and 800 × 450 for a GIF.
    snapshot
        The index of the snapshot of a PNG.
    times, spacing
        How many snapshots a film shows, from first to last, at ``"linear"`` or ``"logarithmic"``
        times: by default all, and at most 250. Each is one frame, and nothing is interpolated.
    fps
        Frames per second of a film.
    overwrite
        Whether an existing file may be replaced.
    progress
        Called with the number of frames drawn and that of all frames.

    Returns
    -------
    Path
        The file, which appears when it is whole; None for a window.

    Raises
    ------
    SceneError
        For an argument that is not allowed, and wrapped positions whose image is not clear.
    TrajectoryError
        For a trajectory without snapshots, and for a file that exists or cannot be written.
    MissingLibraryError
        Where PyVista, OpenGL, a display or, for MP4, ffmpeg is missing; it says what to install.

    >>> scene = nrchain.load_scene("buckling", **{"chain.particles": 6, "run.end": 20.0})
    >>> nrchain.render(nrchain.simulate(scene), "chain.png", colour="bend")  # doctest: +SKIP
    PosixPath('chain.png')
    """
    target = None if path is None else _check_target(Path(path), fps, overwrite)
    film = target is None or is_film(target)
    if not len(require_trajectory(trajectory)):
        raise TrajectoryError("the trajectory has no finished snapshot to draw")
    look = Look(_check_size(size, target), direction(view), follow, frames, tube)
    if film:
        shown = pick_frames(trajectory.time, times, spacing)
    else:
        shown = np.array([_check_snapshot(snapshot, len(trajectory.time))])
    chosen = chosen_snapshots(trajectory, shown)
    whole(least=0)("tracers", tracers)
    coloured = colouring(chosen, colour, colour_scale)
    if coloured is not None and coloured.of == "links" and not tube:
        raise SceneError("colour", colour, "colours the centreline: draw it, with tube")
    (require_display if target is None else require_opengl)()
    pyvista = optional("pyvista", "view", "drawing in three dimensions")
    carried = trace(chosen, tracers) if tracers else None
    with _stage(pyvista, chosen, look, coloured, carried, target is not None) as stage:
        if target is None:
            stage.open_window()
        elif not film:
            stage.show(0)
            write_png(target, stage.image())
        else:
            with film_file(target, fps) as add:
                for index in range(len(shown)):
                    stage.show(index)
                    add(stage.image())
                    if progress:
                        progress(index + 1, len(shown))
    return target


@contextmanager
def _stage(
    pyvista: Any,
    trajectory: Trajectory,
    look: Look,
    coloured: Colouring | None,
    carried: Tracers | None,
    off_screen: bool,
) -> Iterator[Stage]:
    """The stage with the chain; closed at the end."""
    scene = trajectory.scene
    positions = unwrapped_chain(scene, trajectory.positions) / scene.chain.radius
    # VTK writes to standard error which displays it tried before the one that works
    with pyvista.vtk_verbosity("off"):
        stage = Stage(pyvista, trajectory, positions, look, coloured, carried, off_screen)
        try:
            yield stage
        finally:
            stage.plotter.close()


def _check_target(path: Path, fps: float, overwrite: bool) -> Path:
    if path.suffix.lower() not in ENDINGS:
        raise SceneError("picture", str(path), f"must end in one of {', '.join(ENDINGS)}")
    refuse_existing(path, overwrite)
    if is_film(path):
        check_film(path, fps)
    else:
        check_folder(path)
    return path


def _check_size(size: tuple[int, int] | None, path: Path | None) -> tuple[int, int]:
    if size is None:
        return GIF_SIZE if path is not None and path.suffix.lower() == ".gif" else SIZE
    sides = tuple(size) if isinstance(size, tuple | list) else ()
    if len(sides) != 2 or not all(is_whole(s) and LEAST_SIDE <= s <= MOST_SIDE for s in sides):
        allowed = f"must be width and height in pixels, from {LEAST_SIDE} to {MOST_SIDE} each"
        raise SceneError("size", size, allowed)
    return sides[0], sides[1]


def _check_snapshot(index: int, count: int) -> int:
    if not is_whole(index) or not -count <= index < count:
        allowed = (
            f"must be a whole number from {-count} to {count - 1}: there are {count} snapshots"
        )
        raise SceneError("snapshot", index, allowed)
    return index % count
