"""``nrchain run``: simulate a scene."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from nrchain.cli.arguments import (
    RUNS,
    Changes,
    Json,
    Quiet,
    SceneName,
    Style,
    Verbose,
    find_start,
    load,
    report_risks,
)
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show_if_possible
from nrchain.cli.garbage import no_collection
from nrchain.cli.progress import progress_bar, report_warnings
from nrchain.cli.summary import finish
from nrchain.cli.terminal import labelled


@examples(
    "nrchain run buckling",
    "nrchain run mine.toml --set slip.2s=50 --set run.end=500 -o runs/soft",
    "nrchain run mine.toml --from runs/soft:50 -o runs/on",
)
@one_line_errors()
def run(
    scene: SceneName,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="Directory to write to, or a file that ends in .h5.",
            show_default="runs/SCENE",
        ),
    ] = None,
    changes: Changes = None,
    start: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="PATH[:FRAME]",
            help="Start from the last snapshot of a run, or of a file that ends in "
            ".gsd, .xyz, .pvd, .vtp, .npz or .nc; or from the snapshot of that number.",
            show_default=False,
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an existing result.")
    ] = False,
    verify: Annotated[
        bool, typer.Option("--verify", help="Estimate the error at each snapshot (run.verify).")
    ] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Simulate a scene, and write its trajectory and a picture."""
    style = Style.of(as_json=as_json, quiet=quiet, verbose=verbose)
    with no_collection():
        from nrchain.effects.registry import acting
        from nrchain.motion.integrators import find_integrator
        from nrchain.planning.integrator import integrator_of
        from nrchain.planning.regime import warnings
        from nrchain.run.folders import new_folder
        from nrchain.run.output import output_file
        from nrchain.run.simulation import simulate

    place = output or RUNS / Path(scene).stem
    folder, file = output_file(place, overwrite)
    source = None if start is None else find_start(start)
    named = [*(changes or ()), *["run.verify=true"] * verify]
    loaded, choice = load(scene, named, source, lines=style is Style.FULL)
    with no_collection():
        # an integrator imports its library when it is looked up
        find_integrator(integrator_of(loaded))
    risks = warnings(loaded)
    report_risks(loaded, risks)
    names = ", ".join(effect.name for effect in acting(loaded)) or "none"
    if style.is_text:
        show_if_possible(labelled("effects", names), soft_wrap=True)
    with (
        new_folder(folder) if folder else nullcontext(),
        progress_bar(place, hidden=quiet) as progress,
        report_warnings(known=risks),
    ):
        trajectory = simulate(
            loaded,
            output=file,
            overwrite=overwrite,
            progress=progress,
            choice=choice,
            start=source,
        )
    finish(trajectory, style)
