"""``nrchain cost``: error against computing time of a scene."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from nrchain.cli.arguments import Changes, Json, SceneName, load
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.result_records import cost_record
from nrchain.cli.tables import work_table
from nrchain.cli.terminal import console, paragraph

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
    as_json: Json = False,
) -> None:
    """Measure error against computing time of a scene, by short runs."""
    from nrchain.accuracy.cost import check_target, work_precision

    if target is not None:
        check_target(target)
    loaded, _ = load(scene, changes, lines=not as_json)
    with console(stderr=True).status("") as status:
        measured = work_precision(
            loaded, budget=budget, progress=lambda stage: status.update(f"measuring {stage}")
        )
    advice = None if target is None else measured.advise(target)
    if as_json:
        show_json(cost_record(measured, advice))
        return
    show(work_table(measured), whole=True)
    show(*map(paragraph, measured.notes()), soft_wrap=True)
    if advice is not None:
        _show_advice(advice, scene, changes or ())


def _show_advice(advice: Advice, scene: str, changes: Sequence[str]) -> None:
    """Print the setting for a target error, as a command that runs the scene with it."""
    own = "".join(f"--set {shlex.quote(change)} " for change in changes)
    show(
        f"\nsetting for a global error of {advice.target:g}: {advice.point.setting}",
        f"  nrchain run {scene} {own}{advice.arguments}",
        *(paragraph(line, "  ", "  ") for line in advice.lines()),
        soft_wrap=True,
    )
