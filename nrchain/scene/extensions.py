"""What effects add to a scene: sections of their own, and checks. Scenes know of no effect.

The effects are given to scenes, not asked for by them: :mod:`nrchain` calls :func:`provide` with
the registry of effects, which is imported when a scene first names a section that is not its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, cast

if TYPE_CHECKING:
    from nrchain.inputs.rules import Section


class Extensions(Protocol):
    """What the registry of effects answers to a scene."""

    def section_kind(self, name: str) -> type[Section] | None:
        """The section of that name, if an effect adds it."""

    def section_kinds(self) -> dict[str, type[Section]]:
        """All sections that effects add, by name."""

    def check_scene(self, scene: Section) -> None:
        """Raise :class:`~nrchain.errors.SceneError` for what makes no sense to an effect."""


_source: list[Callable[[], object]] = []
_defaults: dict[type[Section], Section] = {}


def provide(source: Callable[[], object]) -> None:
    """Give scenes their extensions; ``source`` returns them, and is called when they are needed."""
    _source[:] = [source]


def extensions() -> Extensions:
    """The extensions of all scenes."""
    return cast(Extensions, _source[0]())


def default_section(kind: type[Section]) -> Section:
    """The section of a scene that names none of its keys, made once."""
    if kind not in _defaults:
        _defaults[kind] = kind()
    return _defaults[kind]
