"""``nrchain scenes``: list the shipped scenes."""

from __future__ import annotations

from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.tables import plain_table


@examples(
    "nrchain scenes",
    "nrchain scenes | head -5",
)
@one_line_errors()
def scenes() -> None:
    """List the shipped scenes."""
    from nrchain.scene.derived import modes_text
    from nrchain.scene.loading import load_scene
    from nrchain.scene.toml import scene_names

    table = plain_table("scene", "what it shows", "slip", "ends")
    table.add_column("N", justify="right")
    for name in scene_names():
        scene = load_scene(name)
        chain = scene.chain
        table.add_row(name, scene.title, modes_text(scene.slip), chain.ends, str(chain.particles))
    show(table)
