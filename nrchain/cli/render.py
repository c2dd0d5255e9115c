"""``nrchain render``: draw a run in three dimensions, as a picture, a film or a window."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrchain.cli.arguments import Json, OverwritePicture, Quiet, Run, Style, find_run, show_picture
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors
from nrchain.cli.film_options import FPS, FramesPerSecond, Spacing, frames_bar, refuse_options
from nrchain.cli.summary import check_absent, picture_beside
from nrchain.errors import SceneError

PICTURE = "space.png"
"""The name of the picture, beside the file of the run."""


@examples(
    "nrchain render runs/buckling --colour bend",
    "nrchain render runs/buckling -o film.mp4 --times 100 --follow",
    'nrchain render runs/buckling --colour "effect:slip 2s" --view 0,90',
)
@one_line_errors()
def render(
    directory: Run,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="File to write: PNG, MP4 or GIF.",
            show_default=f"DIRECTORY/{PICTURE}",
        ),
    ] = None,
    window: Annotated[
        bool, typer.Option("--show", help="Open a window instead of writing a file.")
    ] = False,
    colour: Annotated[
        str,
        typer.Option(
            help="plain; speed or spin of spheres; stretch, shear, bend or twist of links;"
            " or effect:NAME, what one effect contributes to the motion."
        ),
    ] = "plain",
    colour_scale: Annotated[
        Spacing, typer.Option(help="Colours in even steps, or in even ratios over four decades.")
    ] = Spacing.linear,
    view: Annotated[
        str,
        typer.Option(help="From where: slant, x, y, z, or AZIMUTH,ELEVATION in degrees."),
    ] = "slant",
    follow: Annotated[
        bool, typer.Option("--follow", help="Move the camera with the middle of the chain.")
    ] = False,
    frames: Annotated[
        bool, typer.Option("--frames/--no-frames", help="Draw e₁ and e₂ of every sphere.")
    ] = True,
    tube: Annotated[bool, typer.Option("--tube/--no-tube", help="Draw the centreline.")] = True,
    tracers: Annotated[
        int, typer.Option(min=0, help="Number of tracers that the fluid carries along.")
    ] = 0,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="WIDTHxHEIGHT", help="In pixels.", show_default="1280x720, GIF 800x450"
        ),
    ] = None,
    snapshot: Annotated[
        int | None,
        typer.Option(help="Index of the snapshot of a PNG.", show_default="-1, the last"),
    ] = None,
    times: Annotated[
        int | None,
        typer.Option(min=1, help="Number of snapshots of a film.", show_default="all, at most 250"),
    ] = None,
    spacing: Annotated[
        Spacing | None,
        typer.Option(help="Times in even steps or in even ratios.", show_default="linear"),
    ] = None,
    fps: FramesPerSecond = None,
    overwrite: OverwritePicture = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Draw a run in three dimensions, spheres to scale. Needs the extra view; see docs/films.md."""
    from nrchain.trajectory.trajectory import Trajectory
    from nrchain.view.film_files import is_film
    from nrchain.view.space.render import render as draw

    style = Style.of(as_json=as_json, quiet=quiet)
    if window and output is not None:
        raise SceneError("--show", "and -o", "a window and a file are two commands; remove one")
    film = window or (output is not None and is_film(output))
    of_films = {"times": times, "spacing": spacing, "fps": fps}
    if film:
        refuse_options({"snapshot": snapshot}, "a PNG")
    else:
        refuse_options(of_films, "films: -o must end in .mp4 or .gif")
    trajectory = Trajectory.open(find_run(directory))
    target = None if window else output or picture_beside(trajectory, PICTURE)
    if output is not None and not overwrite:
        check_absent(output)
    with frames_bar() as update:
        path = draw(
            trajectory,
            target,
            colour=colour,
            colour_scale=colour_scale.value,
            view=view,
            follow=follow,
            frames=frames,
            tube=tube,
            tracers=tracers,
            size=_size(size),
            snapshot=-1 if snapshot is None else snapshot,
            times=times,
            spacing=(spacing or Spacing.linear).value,
            fps=FPS if fps is None else fps,
            overwrite=overwrite or output is None,
            progress=update,
        )
    show_picture(path, style)


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    width, cross, height = text.partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise SceneError("--size", text, "must be WIDTHxHEIGHT in pixels, such as 1280x720")
    return int(width), int(height)
