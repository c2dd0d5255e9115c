"""The sections that effects add to a scene, such as ``[steric]`` and ``[flow]``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nrchain.errors import SceneError
from nrchain.inputs.rules import Section, section, unknown
from nrchain.scene.extensions import extensions
from nrchain.scene.fixed_table import FixedTable


class EffectSections(FixedTable[Section]):
    """The sections of effects by name. A section with default values only is left out."""

    __slots__ = ()

    def __init__(self, sections: Mapping[str, Section] | None = None) -> None:
        given = sections or {}
        super().__init__({name: s for name, s in given.items() if s != type(s)()})


def read_effect_sections(key: str, value: Any) -> EffectSections:
    """The rule of ``further``: a table of sections, each by the name of a registered effect."""
    if not isinstance(value, Mapping):
        raise SceneError(key, value, "must be a table of sections")
    sections = {}
    for name, given in value.items():
        kind = extensions().section_kind(name)
        if kind is None:
            raise unknown(name, given, extensions().section_kinds())
        sections[name] = section(kind)(name, given)
    return EffectSections(sections)


def with_registration_hint(error: SceneError, what: str, register: str) -> SceneError:
    """The error for an unknown name, with the advice to register a mode or effect of your own."""
    end = "" if error.allowed.endswith("?") else "."
    allowed = (
        f"{error.allowed}{end} Every process must register {what} of your own, with {register},"
        " before it opens a scene or trajectory that names it"
    )
    return SceneError(error.key, error.value, allowed)
