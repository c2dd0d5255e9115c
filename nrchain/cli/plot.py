"""``nrchain plot``: draw a run."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from nrchain.cli.arguments import OverwritePicture, Run, find_run, picture_option
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.film_options import FPS, FramesPerSecond, Spacing, frames_bar, refuse_options
from nrchain.cli.summary import (
    EFFECTS_PICTURE,
    PICTURE,
    PICTURE_IN_SPACE,
    check_absent,
    picture_beside,
)
from nrchain.cli.terminal import note
from nrchain.errors import SceneError


class View(StrEnum):
    """The views of a chain, as the command line names them."""

    planes = "planes"
    space = "3d"


class Spheres(StrEnum):
    """The sizes of drawn spheres."""

    auto = "auto"
    scale = "scale"
    dots = "dots"


@examples(
    "nrchain plot runs/buckling",
    "nrchain plot runs/buckling --view 3d --times 4 -o chain.pdf",
    "nrchain plot runs/buckling -o film.mp4 --times 50",
)
@one_line_errors()
def plot(
    directory: Run,
    output: Annotated[
        Path | None,
        picture_option(f"DIRECTORY/{PICTURE}, {PICTURE_IN_SPACE} or {EFFECTS_PICTURE}"),
    ] = None,
    of_effects: Annotated[
        bool, typer.Option("--effects", help="Draw the contribution of each effect to the motion.")
    ] = False,
    view: Annotated[
        View | None,
        typer.Option(help="Three projections (planes) or perspective (3d).", show_default="planes"),
    ] = None,
    times: Annotated[
        int | None,
        typer.Option(
            min=1, help="Number of snapshots to draw.", show_default="6, all up to 250 in a film"
        ),
    ] = None,
    spacing: Annotated[
        Spacing | None,
        typer.Option(help="Times in even steps or in even ratios.", show_default="linear"),
    ] = None,
    spheres: Annotated[
        Spheres | None,
        typer.Option(
            help="Spheres to scale, as dots, or to scale where they are seen (auto).",
            show_default="auto",
        ),
    ] = None,
    frames: Annotated[
        bool, typer.Option("--frames", help="Draw e₁ and e₂ of up to 12 spheres.")
    ] = False,
    title: Annotated[bool, typer.Option("--title/--no-title", help="Write a title.")] = True,
    fps: FramesPerSecond = None,
    width: Annotated[
        int | None, typer.Option(help="Width of a film, in pixels.", show_default="1000")
    ] = None,
    overwrite: OverwritePicture = False,
) -> None:
    """Draw the chain of a run at several times, its effects, or a film. The run may still go on.

    A file that ends in .mp4 or .gif is a film.
    """
    from nrchain.trajectory.trajectory import Trajectory
    from nrchain.view.film_files import is_film
    from nrchain.view.plots import save_chain

    asked: dict[str, Any] = {
        "view": view and view.value,
        "times": times,
        "spacing": spacing and spacing.value,
        "spheres": spheres and spheres.value,
        "frames": frames or None,
    }
    asked = {name: value for name, value in asked.items() if value is not None}
    if of_effects:
        _refuse_beside_effects(asked)
    film = output is not None and is_film(output)
    if film:
        refuse_options(
            {"effects": of_effects or None, "spheres": spheres}, "pictures: PNG, PDF or SVG"
        )
    else:
        refuse_options({"fps": fps, "width": width}, "films: -o must end in .mp4 or .gif")
    trajectory = Trajectory.open(find_run(directory))
    if trajectory.provenance:
        note(f"the run started {trajectory.provenance.line}")
    if output is not None and not overwrite:
        check_absent(output)
    if film:
        from nrchain.view.films import WIDTH
        from nrchain.view.films import film as draw_film

        assert output is not None
        with frames_bar() as update:
            path = draw_film(
                trajectory,
                output,
                **asked,
                fps=FPS if fps is None else fps,
                width=WIDTH if width is None else width,
                title=title,
                overwrite=overwrite,
                progress=update,
            )
    elif of_effects:
        from nrchain.view.effect_plots import save_effects

        path = output or picture_beside(trajectory, EFFECTS_PICTURE)
        save_effects(trajectory, path, title=title)
    else:
        name = PICTURE_IN_SPACE if view is View.space else PICTURE
        path = output or picture_beside(trajectory, name)
        save_chain(trajectory, path, title=title, **asked)
    show(str(path), soft_wrap=True)


def _refuse_beside_effects(asked: Mapping[str, object]) -> None:
    for name, value in asked.items():
        allowed = "applies to pictures of the chain; remove it or --effects"
        raise SceneError(f"--{name}", value, allowed)
