"""Scenes as text: TOML in and out, the shipped scenes, and changes by dotted key.

All functions work on raw tables: nested dictionaries laid out as the TOML is. Whether a table can
be simulated is for :class:`~nrchain.scene.scene.Scene` to check.
"""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from nrchain.errors import NOT_GIVEN, SceneError
from nrchain.inputs.arrays import GivenArray
from nrchain.inputs.names import did_you_mean
from nrchain.inputs.rules import Section

_HDF5 = b"\x89HDF\r\n\x1a\n"
"""The first bytes of a trajectory file."""

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def scene_names() -> tuple[str, ...]:
    """The names of the shipped scenes, sorted.

    >>> "buckling" in scene_names()
    True
    """
    return tuple(sorted(path.stem for path in _shipped().glob("*.toml")))


def scene_path(name: str) -> Path:
    """The file of a shipped scene. An unknown name raises a SceneError with the nearest one."""
    if name not in scene_names():
        raise SceneError("scene", name, f"is not a shipped scene: {_names_text(name)}")
    return _shipped() / f"{name}.toml"


def read_source(source: str | os.PathLike[str]) -> dict[str, Any]:
    """The raw table of a shipped scene, by its name, or of a TOML file, by its path."""
    path = _shipped() / f"{source}.toml" if source in scene_names() else Path(source)
    try:
        content = path.read_bytes()
    except (FileNotFoundError, IsADirectoryError):
        allowed = f"is neither a file nor a shipped scene: {_names_text(path.stem)}"
        raise SceneError("scene", str(source), allowed) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError("scene", str(source), f"cannot be read: {reason}") from None
    if content.startswith(_HDF5):
        allowed = (
            "is a trajectory; Trajectory.open(...).scene is its scene, nrchain resume continues"
        )
        raise SceneError("scene", str(source), f"{allowed} it, and nrchain plot draws it")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        allowed = f"must be UTF-8 text; byte {error.start} is not"
        raise SceneError("scene", str(source), allowed) from None
    return read_toml(text, origin=str(source))


def read_toml(text: str, *, origin: str = "TOML text") -> dict[str, Any]:
    """The raw table of TOML text; ``origin`` names the text in errors."""
    if not isinstance(text, str):
        raise SceneError("scene", text, "must be TOML text")
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError("scene", origin, f"must be valid TOML: {error}") from None


def write_toml(table: Mapping[str, Any]) -> str:
    """The TOML text of a raw table one section deep; floats keep all their digits."""
    keys = {name: value for name, value in table.items() if not isinstance(value, Mapping)}
    sections = {name: value for name, value in table.items() if isinstance(value, Mapping)}
    blocks = [_assignments(keys)] if keys else []
    blocks += [
        f"[{key_literal(name)}]\n" + _assignments(body) for name, body in sections.items() if body
    ]
    return "\n".join(blocks)


def change(table: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of a raw table with changes made in their order; dotted keys become nested ones.

    A section given as a table changes only the keys it names. Any other key, and a section given as
    an object, is replaced. None stays in the table and means that the key is not given.
    """
    changed: dict[str, Any] = {}
    for key, value in (*table.items(), *changes.items()):
        _assign(changed, (), key, value)
    return changed


def flat_keys(table: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a raw table by dotted key.

    >>> flat_keys({"chain": {"particles": 3}, "title": "mine"})
    {'chain.particles': 3, 'title': 'mine'}
    """
    flat: dict[str, Any] = {}
    for name, value in table.items():
        inner = value if isinstance(value, Mapping) else {}
        flat |= {f"{name}.{key}": item for key, item in inner.items()} or {name: value}
    return flat


def parse_assignment(text: str) -> tuple[str, Any]:
    """``(key, value)`` of ``key=value``, as in ``slip.2s=50``.

    The value is read as TOML (``50``, ``[1, 2]``, ``{strength = 1, axis = [0, 1, 0]}``), or else
    taken as a string (``clamped``). Nothing after the ``=`` is None, which removes the key from the
    scene.

    Raises :class:`~nrchain.errors.SceneError` for text without ``=`` or without a key.
    """
    key, sign, value = (part.strip() for part in text.partition("="))
    if not all(name.strip() for name in key.split(".")):
        raise SceneError("key", text, "must be key=value, such as slip.2s=50")
    if not sign:
        allowed = "must be key=value, such as slip.2s=50; key= removes the key"
        raise SceneError(key, NOT_GIVEN, allowed)
    if not value:
        return key, None
    try:
        table = tomllib.loads(f"value = {value}")
    except (ValueError, RecursionError):
        return key, value
    return key, table["value"] if len(table) == 1 else value


def _assign(table: dict[str, Any], parents: tuple[str, ...], key: str, value: Any) -> None:
    """Set ``table[key]`` to the value. The key may be dotted and the value a section."""
    if not isinstance(key, str):
        raise SceneError(".".join((*parents, str(key))), value, "is not a key; keys are strings")
    name, _, rest = key.partition(".")
    path = (*parents, name)
    if rest:
        table[name] = _as_table(path, table.get(name), key, value)
        _assign(table[name], path, rest, value)
    elif isinstance(value, Mapping) and not parents:
        table[name] = _as_table(path, table.get(name), key, value)
        for inner, item in value.items():
            _assign(table[name], path, inner, item)
    else:
        table[name] = dict(value) if isinstance(value, Mapping) else value


def _as_table(path: tuple[str, ...], present: Any, key: str, value: Any) -> dict[str, Any]:
    """The table at a path, in which ``key`` can be set to the value."""
    if present is None:
        return {}
    if isinstance(present, dict):
        return present
    if isinstance(present, Section):
        return present.to_mapping()
    if path[0] == "slip" and len(path) == 2:
        return {"strength": present}
    if path == ("friction",):
        return {"kind": present}
    whole_key = ".".join((*path[:-1], key))
    raise SceneError(whole_key, value, f"is not a known key; {'.'.join(path)} is not a table")


def _assignments(table: Mapping[str, Any]) -> str:
    return "".join(f"{key_literal(name)} = {literal(value)}\n" for name, value in table.items())


def key_literal(name: str) -> str:
    """A key as TOML writes it, in quotes only where it must be."""
    return name if _BARE_KEY.fullmatch(name) else literal(name)


def literal(value: Any) -> str:
    """A TOML value; JSON writes strings, booleans and finite numbers as TOML does."""
    if isinstance(value, Mapping):
        inner = ", ".join(f"{key_literal(name)} = {literal(item)}" for name, item in value.items())
        return "{" + inner + "}"
    if isinstance(value, tuple):
        return "[" + ", ".join(map(literal, value)) + "]"
    if isinstance(value, GivenArray):
        value = value.tolist()
    return json.dumps(value, ensure_ascii=False)


def _shipped() -> Path:
    return Path(str(resources.files("nrchain.scene").joinpath("scenes")))


def _names_text(name: str) -> str:
    names = scene_names()
    return ", ".join(names) + did_you_mean(name, names)
