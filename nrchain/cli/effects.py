"""``nrchain effects``: list the effects."""

from __future__ import annotations

from nrchain.cli.arguments import Json
from nrchain.cli.examples import examples
from nrchain.cli.exits import one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.tables import plain_table


@examples(
    "nrchain effects",
    "nrchain effects | grep flow",
)
@one_line_errors()
def effects(as_json: Json = False) -> None:
    """List the effects: what each does, and the scene key that switches it on."""
    from nrchain.effects.registry import effects as known_effects

    if as_json:
        keys = ("name", "summary", "key")
        found = known_effects()
        show_json({"effects": [{key: getattr(one, key) for key in keys} for one in found]})
        return
    table = plain_table("effect", "what it does", "scene key")
    for effect in known_effects():
        table.add_row(effect.name, effect.summary, effect.key)
    show(table)
