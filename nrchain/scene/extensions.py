"""How effects add sections and checks to a scene, which itself imports no effect.

:mod:`nrchain` calls :func:`provide` with the registry of effects. The registry is imported when a
scene first names a section that is not its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, cast

if TYPE_CHECKING:
    from nrchain.inputs.rules import Section


class Extensions(Protocol):
    """What a scene asks of the registry of effects."""

    def section_kind(self, name: str) -> type[Section] | None:
        """The class of the section of that name, or None if no effect adds it."""

    def section_kinds(self) -> dict[str, type[Section]]:
        """The classes of all sections that effects add, by name."""

    def check_scene(self, scene: Section) -> None:
        """Raise :class:`~nrchain.errors.SceneError` if an effect cannot act in the scene."""


_source: list[Callable[[], object]] = []
_defaults: dict[type[Section], Section] = {}


def provide(source: Callable[[], object]) -> None:
    """Set the registry of effects. ``source`` returns it, and is called when it is first needed."""
    _source[:] = [source]


def extensions() -> Extensions:
    """The registry of effects."""
    return cast(Extensions, _source[0]())


def default_section(kind: type[Section]) -> Section:
    """The section with all keys at their default; one object for all scenes."""
    if kind not in _defaults:
        _defaults[kind] = kind()
    return _defaults[kind]
