"""A scene as TOML in which comments explain every key: symbol, unit, allowed values, default."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import Any

from nrchain.errors import NOT_GIVEN, SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.inputs.about import About
from nrchain.inputs.rules import Rule, Section
from nrchain.scene.extensions import extensions
from nrchain.scene.fluid_sections import SlipSpec
from nrchain.scene.scene import Scene
from nrchain.scene.toml import key_literal, literal

WIDTH = 78
"""Columns of a comment."""

HEAD = (
    "Choose a unit of length L, of time T and of force F; all values share them. A key with # in"
    " front of it has its default: remove the # to change it. Where a key has no default, an"
    " example stands behind it."
)

NAMED_EXAMPLES = {"tolerance": 0.01, "ratio": 1e7, "accuracy": 1e-6, "max_seconds": 60.0}
"""Examples of keys that would be odd with one of :data:`EXAMPLES`."""

EXAMPLES = (1.0, 1000, [1.0, 0.0, 0.0], [[0.0, 0.0, 0.0]], [[[1, 0, 0], [0, 1, 0], [0, 0, 1]]])
"""Values, of which the first that a key takes is its example."""

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
        example = _example(name, Scene.rules()[name])
        lines += _key(name, about, table.get(name), _default(Scene, name), example)
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
        example = _example(name, section.rules()[name])
        yield from _key(name, about, given.get(name), _default(type(section), name), example)
    if isinstance(section, SlipSpec):
        for mode in slip_modes.modes():
            about = About("V", "L/T", STRENGTH, f"strength of the {mode.name}")
            yield from _key(mode.label, about, given.get(mode.label), None, 1.0)


def _default(kind: Any, name: str) -> Any:
    """The default of a key; NOT_GIVEN if it is required."""
    field = kind.__dataclass_fields__[name]
    required = field.default is field.default_factory
    return NOT_GIVEN if required else field.default


def _example(name: str, rule: Rule) -> Any:
    """A value that the rule of a key takes; empty text where it takes none of the examples."""
    for value in (NAMED_EXAMPLES.get(name), *EXAMPLES):
        try:
            if value is not None and rule(name, value) is not None:
                return value
        except SceneError:
            continue
    return ""


def _key(name: str, about: About, value: Any, default: Any, example: Any) -> Iterator[str]:
    """The comment on a key, and the key, behind a # if it has its default.

    What stands behind the # is valid TOML, and an ``example`` where there is no default.
    """
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
        shown = f"{literal(example)}  # example" if default is None else literal(default)
        yield f"# {key_literal(name)} = {shown}"
    else:
        yield f"{key_literal(name)} = {literal(value)}"


def _first_line(section: Section) -> str:
    return (type(section).__doc__ or "").strip().partition("\n")[0].replace("`", "")


def _comment(text: str) -> list[str]:
    return textwrap.wrap(
        text, WIDTH, initial_indent="# ", subsequent_indent="#   ", break_on_hyphens=False
    )
