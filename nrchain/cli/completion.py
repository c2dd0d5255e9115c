"""What a shell completes: names of scenes, and keys of scenes with the values that have a name."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nrchain.inputs.rules import Section


def complete_scene(incomplete: str) -> list[str]:
    """Shipped scenes, TOML files and folders that begin with the text."""
    from nrchain.scene.toml import scene_names

    parent = Path(incomplete + "x").parent
    near = sorted(parent.iterdir()) if parent.is_dir() else []
    found = [f"{path}/" for path in near if path.is_dir() and not path.name.startswith(".")]
    found += [str(path) for path in near if path.suffix == ".toml"]
    return [name for name in (*scene_names(), *found) if name.startswith(incomplete)]


def complete_key(incomplete: str) -> list[str]:
    """``key=`` for each key of a scene, or ``key=value`` for the values with a name."""
    key, sign, _ = incomplete.partition("=")
    values = _keys()
    if sign:
        found = [f"{key}={value}" for value in values.get(key, ())]
    else:
        found = [f"{name}=" for name in values]
    return [text for text in found if text.startswith(incomplete)]


def complete_number(incomplete: str) -> list[str]:
    """``key=`` for each key of a scene whose values have no names."""
    return [
        f"{key}=" for key, values in _keys().items() if not values and key.startswith(incomplete)
    ]


def _keys() -> dict[str, list[str]]:
    """The dotted keys of a scene, each with its values that have a name."""
    import nrchain.effects.registry  # noqa: F401  registers the sections of effects
    from nrchain.scene.extensions import extensions
    from nrchain.scene.mistakes import OWN
    from nrchain.scene.scene import Scene

    kinds: list[type[Section]] = [Scene, *(OWN | extensions().section_kinds()).values()]
    found = {}
    for kind in kinds:
        for name in kind.about if kind is Scene else kind.names():
            found[kind.key(name)] = list(_named_values(kind, name))
    return found


def _named_values(kind: type[Section], name: str) -> Iterator[str]:
    """The values of a key that are words: those of its description that its rule takes."""
    from nrchain.errors import SceneError

    allowed = kind.about[name].allowed if name in kind.about else ""
    for word in re.findall(r'"([^"]+)"|\b(true|false)\b', allowed):
        text = "".join(word)
        value = {"true": True, "false": False}.get(text, text)
        with suppress(SceneError):
            kind.rules()[name](kind.key(name), value)
            yield text
