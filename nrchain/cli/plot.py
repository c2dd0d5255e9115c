"""``nrchain plot``: draw a run."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from nrchain.cli.arguments import OverwritePicture, Run, find_run, picture_option
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.summary import (
    EFFECTS_PICTURE,
    PICTURE,
    PICTURE_IN_SPACE,
    check_absent,
    picture_beside,
)
from nrchain.errors import SceneError


class View(StrEnum):
    """The views of a chain, as the command line names them."""

    planes = "planes"
    space = "3d"


@examples(
    "nrchain plot runs/buckling",
    "nrchain plot runs/buckling --view 3d --times 4 -o chain.pdf",
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
        int | None, typer.Option(min=1, help="Number of snapshots to draw.", show_default="6")
    ] = None,
    overwrite: OverwritePicture = False,
) -> None:
    """Draw the chain of a run at several times, or its effects. The run may still go on."""
    from nrchain.trajectory.trajectory import Trajectory
    from nrchain.view.plots import draw_chain

    if of_effects and (view or times):
        _refuse_beside_effects("--view" if view else "--times", view.value if view else times)
    trajectory = Trajectory.open(find_run(directory))
    if output is not None and not overwrite:
        check_absent(output)
    if of_effects:
        from nrchain.view.effect_plots import draw_effects

        path = draw_effects(trajectory, output or picture_beside(trajectory, EFFECTS_PICTURE))
    else:
        shown = view or View.planes
        name = PICTURE if shown is View.planes else PICTURE_IN_SPACE
        path = output or picture_beside(trajectory, name)
        draw_chain(trajectory, path, view=shown.value, times=times or 6)
    show(str(path), soft_wrap=True)


def _refuse_beside_effects(option: str, value: object) -> None:
    raise SceneError(option, value, "applies to pictures of the chain; remove it or --effects")
