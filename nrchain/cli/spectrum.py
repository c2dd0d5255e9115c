"""``nrchain spectrum``: growth, frequency and sensitivity of the modes of a finite chain."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrchain.cli.arguments import Changes, Json, SceneName, find_run, load
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.result_records import spectrum_record
from nrchain.cli.terminal import paragraph


@examples(
    "nrchain spectrum buckling --modes 4",
    "nrchain spectrum stable --at runs/stable",
)
@one_line_errors()
def spectrum(
    scene: SceneName,
    changes: Changes = None,
    at: Annotated[
        Path | None,
        typer.Option(
            help="Directory or file of a run whose last snapshot is near the state."
            " By default, the straight chain."
        ),
    ] = None,
    modes: Annotated[int, typer.Option(min=1, help="Number of leading eigenvalues.")] = 10,
    as_json: Json = False,
) -> None:
    """Show how small changes of a state of a chain grow, oscillate and decay."""
    from nrchain.cli.spectrum_tables import modes_table, sensitivities_table, summary
    from nrchain.states.spectrum import spectrum as compute
    from nrchain.trajectory.trajectory import Trajectory

    loaded, _ = load(scene, changes, lines=not as_json)
    poses = None if at is None else Trajectory.open(find_run(at))
    found = compute(loaded, poses, modes=modes)
    if as_json:
        show_json(spectrum_record(found))
        return
    show(*map(paragraph, summary(found)), soft_wrap=True)
    show(modes_table(found))
    show(sensitivities_table(found))
