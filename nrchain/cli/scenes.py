"""``nrchain scenes``: list the shipped scenes."""

from __future__ import annotations

from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.tables import plain_table


@one_line_errors()
def scenes() -> None:
    """List the shipped scenes."""
    from nrchain.scene.scene import load_scene, scene_names, slip_text

    table = plain_table("scene", "what it shows", "slip", "ends")
    table.add_column("N", justify="right")
    for name in scene_names():
        scene = load_scene(name)
        chain = scene.chain
        table.add_row(name, scene.title, slip_text(scene), chain.ends, str(chain.particles))
    show(table)
