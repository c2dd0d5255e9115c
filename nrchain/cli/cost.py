"""``nrchain cost``: error against computing time of a scene."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from nrchain.cli.arguments import Changes, SceneName, load
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.tables import work_table
from nrchain.cli.terminal import console

if TYPE_CHECKING:
    from nrchain.accuracy.cost import Advice


@examples(
    "nrchain cost buckling --target 1e-4",
    "nrchain cost mine.toml --set run.end=50 --budget 10",
)
@one_line_errors()
def cost(
    scene: SceneName,
    changes: Changes = None,
    target: Annotated[
        float | None,
        typer.Option(
            help="Global error to reach, in radii and radians. Prints the cheapest setting for it."
        ),
    ] = None,
    budget: Annotated[
        float,
        typer.Option(
            help="Work of all short runs together, in nominal seconds: counted, not timed."
        ),
    ] = 30.0,
) -> None:
    """Measure error against computing time of a scene, by short runs."""
    from nrchain.accuracy.cost import check_target, work_precision

    if target is not None:
        check_target(target)
    loaded, _ = load(scene, changes)
    with console(stderr=True).status("") as status:
        measured = work_precision(
            loaded, budget=budget, progress=lambda stage: status.update(f"measuring {stage}")
        )
    show(work_table(measured), whole=True)
    show(*measured.notes(), soft_wrap=True)
    if target is not None:
        _show_advice(measured.advise(target), scene, changes or ())


def _show_advice(advice: Advice, scene: str, changes: Sequence[str]) -> None:
    """Print the setting for a target error, as a command that runs the scene with it."""
    own = "".join(f"--set {shlex.quote(change)} " for change in changes)
    show(
        f"\nsetting for a global error of {advice.target:g}: {advice.point.setting}",
        f"  nrchain run {scene} {own}{advice.arguments}",
        *(f"  {line}" for line in advice.lines()),
        soft_wrap=True,
    )
