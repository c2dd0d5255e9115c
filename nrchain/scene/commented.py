"""A scene as TOML in which comments explain every key: symbol, unit, allowed values, default."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import Any

from nrchain.errors import NOT_GIVEN
from nrchain.hydrodynamics import slip_modes
from nrchain.inputs.about import About
from nrchain.inputs.rules import Section
from nrchain.scene.extensions import extensions
from nrchain.scene.fluid_sections import SlipSpec
from nrchain.scene.scene import Scene
from nrchain.scene.toml import key_literal, literal

WIDTH = 78
"""Columns of a comment."""

HEAD = (
    "Choose a unit of length L, of time T and of force F; all values share them. A key with # in"
    " front of it has its default: remove the # to change it."
)

STRENGTH = "a number, a list with one for each sphere, or a table of strength and axis"


def commented_toml(scene: Scene) -> str:
    """The TOML text of a scene with a comment on every key, also on those with their default.

    :meth:`Scene.from_toml` makes an equal scene of it.

    >>> from nrchain import Scene, load_scene
    >>> scene = load_scene("buckling")
    >>> Scene.from_toml(commented_toml(scene)) == scene
    True
    """
    table = scene.to_mapping()
    lines = [*_comment(HEAD), ""]
    for name, about in scene.about.items():
        lines += _key(name, about, table.get(name), _default(Scene, name))
    for name, section in _sections(scene).items():
        lines += ["", *_comment(f"{name.capitalize()}: {_first_line(section)}"), f"[{name}]"]
        lines += _section(section, table.get(name, {}))
    return "\n".join(lines) + "\n"


def _sections(scene: Scene) -> dict[str, Section]:
    """The sections of a scene by name, those of effects before the start and the run."""
    further = {name: getattr(scene, name) for name in extensions().section_kinds()}
    first = {name: getattr(scene, name) for name in ("chain", "elasticity", "slip", "friction")}
    return {**first, **further, "start": scene.start, "run": scene.run}


def _section(section: Section, given: dict[str, Any]) -> Iterator[str]:
    """The keys of a section, with the modes of slip last."""
    for name in section.spellings():
        about = section.about.get(name, About("", "", "", ""))
        yield from _key(name, about, given.get(name), _default(type(section), name))
    if isinstance(section, SlipSpec):
        for mode in slip_modes.modes():
            about = About("V", "L/T", STRENGTH, f"strength of the {mode.name}")
            yield from _key(mode.label, about, given.get(mode.label), None)


def _default(kind: Any, name: str) -> Any:
    """The default of a key; NOT_GIVEN if it is required."""
    field = kind.__dataclass_fields__[name]
    required = field.default is field.default_factory
    return NOT_GIVEN if required else field.default


def _key(name: str, about: About, value: Any, default: Any) -> Iterator[str]:
    """The comment on a key, and the key, behind a # if it has its default."""
    symbol = ", in ".join(filter(None, (about.symbol, about.unit)))
    if about.unit and not about.symbol:
        symbol = f"in {about.unit}"
    meaning = ": ".join(filter(None, (symbol, about.meaning)))
    allowed = f"Allowed: {about.allowed}" if about.allowed else ""
    fallback = ""
    if default is NOT_GIVEN:
        fallback = "Required"
    elif default is None:
        fallback = "Not set by default"
    elif value != default:
        fallback = f"Default: {literal(default)}"
    yield from _comment(". ".join(filter(None, (meaning, allowed, fallback))) + ".")
    if value is None or value == default:
        yield f"# {key_literal(name)} = {'' if default is None else literal(default)}".rstrip()
    else:
        yield f"{key_literal(name)} = {literal(value)}"


def _first_line(section: Section) -> str:
    return (type(section).__doc__ or "").strip().partition("\n")[0].replace("`", "")


def _comment(text: str) -> list[str]:
    return textwrap.wrap(
        text, WIDTH, initial_indent="# ", subsequent_indent="#   ", break_on_hyphens=False
    )
