"""``nrchain export``: write a run as a file of another program."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nrchain.cli.arguments import Json, OverwritePicture, Quiet, Run, Style, find_run
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json


@examples(
    "nrchain export runs/buckling -o buckling.gsd",
    "nrchain export runs/buckling -o buckling.pvd --every 10",
)
@one_line_errors()
def export(
    directory: Run,
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            help="File to write, which ends in .gsd (OVITO, HOOMD), .xyz (OVITO, ASE), .pvd "
            "(ParaView), .npz (NumPy) or .nc (xarray).",
            show_default=False,
        ),
    ],
    every: Annotated[
        int, typer.Option(min=1, help="Write every snapshot, or the first of so many.")
    ] = 1,
    overwrite: OverwritePicture = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Write the snapshots of a run for other programs. The run may still go on."""
    from nrchain.exchange.export import export as write
    from nrchain.exchange.export import refuse_taken
    from nrchain.exchange.formats import writer_of
    from nrchain.trajectory.trajectory import Trajectory

    style = Style.of(as_json=as_json, quiet=quiet)
    writer_of(output)
    refuse_taken(output, overwrite)
    trajectory = Trajectory.open(find_run(directory))
    written = trajectory[::every]
    path = write(written, output, overwrite=overwrite)
    if style is Style.JSON:
        show_json({"file": path, "snapshots": len(written)})
    elif style.is_text:
        show(str(path), soft_wrap=True)
