"""``nrchain dispersion``: growth and frequency of the plane waves of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from nrchain.cli.arguments import (
    RUNS,
    Changes,
    Json,
    OverwritePicture,
    Quiet,
    SceneName,
    Style,
    load,
    picture_option,
)
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.result_records import dispersion_record
from nrchain.cli.summary import check_absent
from nrchain.cli.tables import frequency_table, growth_table
from nrchain.cli.terminal import note

PICTURE = "dispersion.png"


@examples(
    "nrchain dispersion wave",
    "nrchain dispersion buckling --set slip.2s=50 -o growth.pdf",
)
@one_line_errors()
def dispersion(
    scene: SceneName,
    changes: Changes = None,
    output: Annotated[Path | None, picture_option(f"{RUNS}/SCENE-{PICTURE}")] = None,
    overwrite: OverwritePicture = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Draw growth and frequency: the lattice, its rod, its beam limit, and the chain's modes."""
    from nrchain.errors import SceneError
    from nrchain.states.mode_waves import mode_waves
    from nrchain.theory.dispersion import dispersion as compute
    from nrchain.trajectory.file import file_errors
    from nrchain.view.dispersion_plots import save_dispersion
    from nrchain.view.drawing import check_picture

    style = Style.of(as_json=as_json, quiet=quiet)
    if output is not None:
        check_picture(output)
        if not overwrite:
            check_absent(output)
    loaded, _ = load(scene, changes, lines=style.is_text)
    found = compute(loaded)
    path = output or RUNS / f"{Path(scene).stem}-{PICTURE}"
    if output is None:
        with file_errors(path, "cannot be drawn"):
            RUNS.mkdir(exist_ok=True)
    try:
        modes, missing = mode_waves(found), ""
    except SceneError as error:
        # of a chain without a straight state, what keeps it from one
        straight = error.key == "at"
        modes, missing = None, f"the straight chain {error.allowed}" if straight else str(error)
    save_dispersion(found, path, modes)
    if style is Style.JSON:
        show_json(dispersion_record(found, path))
    elif style.is_text:
        show(growth_table(found), frequency_table(found), whole=True)
        if found.frame == "spinning":
            show("rates along axes that spin with the chain", soft_wrap=True)
    if found.why:
        note(f"{found.why}; the lattice is drawn alone")
    if modes is None:
        note(f"the modes of the chain are not drawn: {missing}")
    if style.is_text:
        show(str(path), soft_wrap=True)
