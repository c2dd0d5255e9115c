"""``nrchain plot``: draw a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nrchain.cli.arguments import (
    Json,
    OverwritePicture,
    Quiet,
    Run,
    Style,
    find_run,
    picture_option,
    show_picture,
)
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors
from nrchain.cli.film_options import FPS, FramesPerSecond, Spacing, frames_bar, refuse_options
from nrchain.cli.summary import (
    EFFECTS_PICTURE,
    FLOW_PICTURE,
    PICTURE,
    PICTURE_IN_SPACE,
    check_absent,
    picture_beside,
)
from nrchain.cli.terminal import note
from nrchain.errors import SceneError

if TYPE_CHECKING:
    from nrchain.trajectory.trajectory import Trajectory


class View(StrEnum):
    """The views of a chain, as the command line names them."""

    planes = "planes"
    space = "3d"


class Plane(StrEnum):
    """The planes in which the flow is drawn."""

    xy = "xy"
    xz = "xz"
    yz = "yz"


class Part(StrEnum):
    """The parts of the flow."""

    slip = "slip"
    forces = "forces"
    torques = "torques"
    background = "background"


class Spheres(StrEnum):
    """The sizes of drawn spheres."""

    auto = "auto"
    scale = "scale"
    dots = "dots"


@examples(
    "nrchain plot runs/buckling",
    "nrchain plot runs/buckling --view 3d --times 4 -o chain.pdf",
    "nrchain plot runs/buckling --flow --plane xz --time 500",
    "nrchain plot runs/buckling -o film.mp4 --times 50",
)
@one_line_errors()
def plot(
    directory: Run,
    output: Annotated[
        Path | None,
        picture_option(
            f"DIRECTORY/{PICTURE}, {PICTURE_IN_SPACE}, {EFFECTS_PICTURE} or {FLOW_PICTURE}"
        ),
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
    of_flow: Annotated[
        bool, typer.Option("--flow", help="Draw the flow of the fluid in a plane, at one time.")
    ] = False,
    plane: Annotated[Plane | None, typer.Option(help="Of the flow.", show_default="xy")] = None,
    at: Annotated[
        float | None,
        typer.Option(
            help="Third coordinate of the plane, in the unit of length of the scene.",
            show_default="through the sphere in the middle",
        ),
    ] = None,
    frame: Annotated[
        int | None,
        typer.Option(help="Snapshot of the flow, by number; -1 is the last.", show_default="-1"),
    ] = None,
    time: Annotated[
        float | None,
        typer.Option(help="Time of the flow, in the unit of the scene: the nearest snapshot."),
    ] = None,
    part: Annotated[
        list[Part] | None,
        typer.Option(help="Part of the flow. Can be repeated.", show_default="all"),
    ] = None,
    title: Annotated[bool, typer.Option("--title/--no-title", help="Write a title.")] = True,
    fps: FramesPerSecond = None,
    width: Annotated[
        int | None, typer.Option(help="Width of a film, in pixels.", show_default="1000")
    ] = None,
    overwrite: OverwritePicture = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Draw the chain of a run at several times, its effects, the flow of the fluid, or a film.

    The run may still go on. A file that ends in .mp4 or .gif is a film.
    """
    from nrchain.trajectory.trajectory import Trajectory
    from nrchain.view.drawing import FORMATS
    from nrchain.view.film_files import FILMS, is_film
    from nrchain.view.plots import save_chain

    style = Style.of(as_json=as_json, quiet=quiet)
    asked: dict[str, Any] = {
        "view": view and view.value,
        "times": times,
        "spacing": spacing and spacing.value,
        "spheres": spheres and spheres.value,
        "frames": frames or None,
    }
    asked = {name: value for name, value in asked.items() if value is not None}
    flow_asked: dict[str, Any] = {
        "plane": plane and plane.value,
        "at": at,
        "frame": frame,
        "time": time,
        "part": [each.value for each in part] if part else None,
    }
    flow_asked = {name: value for name, value in flow_asked.items() if value is not None}
    _refuse_unrelated(asked, flow_asked, of_effects, of_flow)
    film = output is not None and is_film(output)
    if film:
        of_pictures = {"effects": of_effects or None, "flow": of_flow or None, "spheres": spheres}
        refuse_options(of_pictures, "pictures: PNG, PDF or SVG")
    else:
        refuse_options({"fps": fps, "width": width}, "films: -o must end in .mp4 or .gif")
        if output is not None and output.suffix.lower() not in FORMATS:
            endings = f"must end in {', '.join(FORMATS)}, or for a film in {', '.join(FILMS)}"
            raise SceneError("-o", str(output), endings)
    trajectory = Trajectory.open(find_run(directory))
    if trajectory.provenance:
        note(trajectory.provenance.line)
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
    elif of_flow:
        path = output or picture_beside(trajectory, FLOW_PICTURE)
        _save_flow(trajectory, path, title, **flow_asked)
    else:
        name = PICTURE_IN_SPACE if view is View.space else PICTURE
        path = output or picture_beside(trajectory, name)
        save_chain(trajectory, path, title=title, **asked)
    show_picture(path, style)


def _save_flow(
    trajectory: Trajectory,
    path: Path,
    title: bool,
    *,
    frame: int = -1,
    time: float | None = None,
    part: Sequence[Any] | None = None,
    **options: Any,
) -> None:
    """Draw the flow at a snapshot, or at the one that is nearest to a time."""
    from nrchain.view.drawing import check_drawable
    from nrchain.view.flow_plots import save_flow

    check_drawable(trajectory, path)
    if time is not None:
        first, last = trajectory.time[0], trajectory.time[-1]
        if not first <= time <= last:
            raise SceneError("--time", time, f"must be from {first:g} to {last:g}, as the run has")
        frame = int(abs(trajectory.time - time).argmin())
    save_flow(trajectory, path, frame=frame, parts=part, title=title, **options)


def _refuse_unrelated(
    asked: Mapping[str, object], flow_asked: Mapping[str, object], of_effects: bool, of_flow: bool
) -> None:
    """Refuse options that belong to another picture than the one asked for."""
    if of_effects and of_flow:
        raise SceneError("--flow", True, "draws another picture than --effects; remove one")
    if of_effects or of_flow:
        picture = "--effects" if of_effects else "--flow"
        for name, value in asked.items():
            allowed = f"applies to pictures of the chain; remove it or {picture}"
            raise SceneError(f"--{name}", value, allowed)
    if not of_flow:
        for name, value in flow_asked.items():
            raise SceneError(f"--{name}", value, "applies to the flow: add --flow, or remove it")
    if {"frame", "time"} <= flow_asked.keys():
        raise SceneError("--time", flow_asked["time"], "and --frame both choose a snapshot")
