"""``nrchain plan``: what to expect of a scene before it is run."""

from __future__ import annotations

from typing import Annotated

import typer

from nrchain.cli.arguments import Changes, Json, SceneName, load, report_risks
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.result_records import plan_record
from nrchain.cli.tables import contributions_table, predictions_table
from nrchain.cli.terminal import paragraph


@examples(
    "nrchain plan buckling",
    "nrchain plan mine.toml --set slip.2s=200 --set chain.particles=40",
)
@one_line_errors()
def plan(
    scene: SceneName,
    changes: Changes = None,
    budget: Annotated[
        float,
        typer.Option(
            min=0.0, help="Work of the probe runs, in nominal seconds: counted, not timed."
        ),
    ] = 3.0,
    as_json: Json = False,
) -> None:
    """Predict what a scene does, and what each effect contributes and costs."""
    from nrchain.accuracy.plan_effects import plan_effects
    from nrchain.planning.description import without_effect
    from nrchain.planning.estimate import estimate_effects
    from nrchain.planning.plan import plan as predict

    loaded, _ = load(scene, changes, lines=not as_json)
    predicted = predict(loaded)
    if not as_json:
        show(predictions_table(predicted))
    effects = plan_effects(loaded, estimate_effects(loaded, budget=budget))
    if as_json:
        show_json(plan_record(predicted, effects, without_effect(loaded)))
    else:
        show(contributions_table(effects), whole=True)
        show(*map(paragraph, [*effects.remarks(), *effects.notes()]), soft_wrap=True)
    report_risks(loaded, predicted.warnings)
