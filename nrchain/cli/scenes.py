"""``nrchain scenes``: list the shipped scenes."""

from __future__ import annotations

from typing import Annotated

import typer

from nrchain.cli.arguments import Changes, Json
from nrchain.cli.completion import complete_scene
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.tables import plain_table
from nrchain.errors import SceneError


@examples(
    "nrchain scenes",
    "nrchain scenes buckling > my.toml",
)
@one_line_errors()
def scenes(
    name: Annotated[
        str | None,
        typer.Argument(
            help="A shipped scene or a TOML file, to print with a comment on every key.",
            show_default=False,
            autocompletion=complete_scene,
        ),
    ] = None,
    changes: Changes = None,
    as_json: Json = False,
) -> None:
    """List the shipped scenes, or print one of them as a file to change."""
    if name is None:
        if changes:
            raise SceneError("--set", changes[0], "changes a scene; name the scene as well")
        _list(as_json)
        return
    from nrchain.scene.commented import commented_toml
    from nrchain.scene.loading import load_scene
    from nrchain.scene.toml import parse_assignment

    scene = load_scene(name, **dict(map(parse_assignment, changes or [])))
    if as_json:
        show_json(scene.to_mapping())
    else:
        show(commented_toml(scene).rstrip("\n"), soft_wrap=True)


def _list(as_json: bool) -> None:
    """Print one line for each shipped scene."""
    from nrchain.scene.derived import modes_text
    from nrchain.scene.loading import load_scene
    from nrchain.scene.toml import scene_names

    found = []
    for name in scene_names():
        scene = load_scene(name)
        ends, count = scene.chain.ends, scene.chain.particles
        found.append((name, scene.title, modes_text(scene.slip), ends, count))
    if as_json:
        keys = ("name", "title", "slip", "ends", "particles")
        show_json({"scenes": [dict(zip(keys, row, strict=True)) for row in found]})
        return
    table = plain_table("scene", "what it shows", "slip", "ends")
    table.add_column("N", justify="right")
    for *texts, count in found:
        table.add_row(*texts, str(count))
    show(table)
