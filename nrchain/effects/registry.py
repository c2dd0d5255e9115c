"""All effects: those of this package, one file each, and those that a user registers.

Every file of this package is imported when the list of effects is first needed. Reading a scene
without further sections imports none of them.
"""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
from collections.abc import Callable, Iterable
from functools import cache
from typing import Any, TypeVar

import nrchain.effects
from nrchain.effects.base import Effect, OneBodyEffect
from nrchain.errors import NOT_GIVEN, SceneError
from nrchain.inputs.names import did_you_mean
from nrchain.inputs.rules import Section, unknown
from nrchain.scene.effect_sections import with_registration_hint
from nrchain.scene.scene import Scene

Registered = TypeVar("Registered", bound=type[Effect])

FIRST = ("stretch", "shear", "twist", "bend", "slip", "finite_size", "reach", "friction", "steric")
"""The order of effects in lists; effects of other files follow by name."""

RESERVED = ("support", "total")
"""Rows of decompositions that are not effects."""

_EFFECTS: dict[str, type[Effect]] = {}
_FAMILIES: dict[str, Callable[[], Iterable[type[Effect]]]] = {}
_METHODS = {"wrench": "add_wrenches", "twist": "add_twists"}
_DERIVATIVE = ("linearise", "add_blocks", "add_product")


def register_effect(cls: Registered) -> Registered:
    """Make an effect available to scenes, runs and decompositions, and return it.

    Its ``Section`` becomes the table ``[name]`` of a scene. A trajectory file stores the names of
    its effects only: register an effect again before you open or resume a run that uses it. Raises
    :class:`~nrchain.errors.SceneError` if the name is taken or the class is incomplete.
    :func:`nrchain.check_effect` tests whether the class is correct.
    """
    if not (isinstance(cls, type) and issubclass(cls, Effect)):
        raise SceneError("effect", cls, "must be a class derived from nrchain.Effect")
    for attribute in ("name", "summary", "equation"):
        value = getattr(cls, attribute, NOT_GIVEN)
        if not isinstance(value, str):
            key = f"effect {cls.__name__}.{attribute}"
            raise SceneError(key, value, "must be one line of text")
    if cls.Section is not None:
        _check_section(cls)
        if "key" not in vars(cls):
            cls.key = cls.Section.path
    if _is_own(cls):
        _EFFECTS[cls.name] = cls
        return cls
    _check_methods(cls)
    _check_name(cls)
    _EFFECTS[cls.name] = cls
    return cls


def register_family(name: str, members: Callable[[], Iterable[type[Effect]]]) -> None:
    """Add effects that are generated from a table, one class for each entry."""
    _FAMILIES[name] = members


def unregister_effect(effect: type[Effect] | str) -> None:
    """Remove a registered effect, given as its class or its name.

    Scenes that name it are refused.

    >>> unregister_effect("field")
    Traceback (most recent call last):
    nrchain.errors.SceneError: effect = 'field': is part of nrchain and cannot be removed
    """
    name = effect if isinstance(effect, str) else effect.name
    known = _EFFECTS.get(name)
    if known is None or not (isinstance(effect, str) or known is effect):
        raise SceneError("effect", name, "is not registered")
    if _is_own(known):
        raise SceneError("effect", name, "is part of nrchain and cannot be removed")
    del _EFFECTS[name]


def _is_own(cls: type[Effect]) -> bool:
    """Whether it is defined in a file of this package."""
    return cls.__module__.startswith(f"{nrchain.effects.__name__}.")


def _check_name(cls: type[Effect]) -> None:
    if cls.name in RESERVED:
        allowed = "is a reserved row of decompositions; choose a new name"
        raise SceneError("effect name", cls.name, allowed)
    for known in effects():
        if known.name == cls.name and known is not cls:
            allowed = "is taken by another effect; choose a new name"
            if known.__qualname__ == cls.__qualname__:
                allowed = (
                    f"is taken by an earlier {cls.__qualname__}; to replace it, for example when a"
                    f" notebook cell runs again, call nrchain.unregister_effect({cls.name!r}) first"
                )
            raise SceneError("effect name", cls.name, allowed)


def _check_section(cls: type[Effect]) -> None:
    kind: Any = cls.Section
    key = f"effect {cls.name}.Section"
    if not (isinstance(kind, type) and issubclass(kind, Section)):
        raise SceneError(key, kind, "must be a class derived from nrchain.Section")
    if not dataclasses.is_dataclass(kind):
        raise SceneError(key, kind.__name__, "must be a frozen dataclass with a rule for each key")
    if not kind.path.isidentifier() or hasattr(Scene, kind.path) or kind.path in Scene.rules():
        allowed = "must be the name of the section, and not a key or attribute of every scene"
        raise SceneError(f"{key}.path", kind.path, allowed)
    for known in _EFFECTS.values():
        if known.Section and known.Section.path == kind.path and known.name != cls.name:
            raise SceneError(f"{key}.path", kind.path, f"is the section of effect {known.name!r}")
    try:
        kind()
    except TypeError as error:
        raise SceneError(key, kind.__name__, f"must have a default for each key: {error}") from None


def _check_methods(cls: type[Effect]) -> None:
    if cls.Section is None:
        key = f"effect {cls.name}.Section"
        raise SceneError(key, NOT_GIVEN, "must be the section of the effect")
    needed = [_METHODS.get(cls.gives, ""), *_DERIVATIVE]
    if not needed[0]:
        allowed = f"must be one of {', '.join(_METHODS)}"
        raise SceneError(f"effect {cls.name}.gives", cls.gives, allowed)
    if issubclass(cls, OneBodyEffect) and cls.linearise is OneBodyEffect.linearise:
        needed.append("derivative")
    for name in needed:
        if getattr(cls, name) in (getattr(Effect, name, None), OneBodyEffect.derivative):
            key = f"effect {cls.name}.{name}"
            raise SceneError(key, NOT_GIVEN, "must be defined by the class")


@cache
def _files() -> tuple[str, ...]:
    return tuple(m.name for m in pkgutil.iter_modules(nrchain.effects.__path__) if not m.ispkg)


@cache
def _import_all() -> None:
    for name in _files():
        importlib.import_module(f"nrchain.effects.{name}")


def effects() -> tuple[type[Effect], ...]:
    """All effects, those of the package first."""
    _import_all()

    def place(cls: type[Effect]) -> tuple[int, str]:
        package, _, file = cls.__module__.rpartition(".")
        if package != nrchain.effects.__name__:
            return len(FIRST) + 1, ""
        return (FIRST.index(file), "") if file in FIRST else (len(FIRST), file)

    found = [*_EFFECTS.values(), *(cls for family in _FAMILIES.values() for cls in family())]
    return tuple(sorted(found, key=place))


def find_effect(name: str) -> type[Effect]:
    """The effect of a name. Raises SceneError with the known names for an unknown one."""
    for cls in effects():
        if cls.name == name:
            return cls
    names = [cls.name for cls in effects()]
    raise SceneError(
        "effect", name, f"is not known; there are {', '.join(names)}{did_you_mean(name, names)}"
    )


def acting(scene: Scene) -> tuple[type[Effect], ...]:
    """The effects that contribute in a scene.

    Raises SceneError for a section that no effect has any more, or not in this process.
    """
    for name, section in scene.further.items():
        if section_kind(name) is None:
            error = unknown(name, section.to_mapping(), section_kinds())
            raise with_registration_hint(error, "an effect", "nrchain.register_effect")
    return tuple(cls for cls in effects() if cls.acts(scene))


def section_kind(name: str) -> type[Section] | None:
    """The section of this name that an effect adds to scenes, or None."""
    if name in _files():
        importlib.import_module(f"nrchain.effects.{name}")
    for cls in _EFFECTS.values():
        if cls.Section is not None and cls.Section.path == name:
            return cls.Section
    return None


def check_scene(scene: Scene) -> None:
    """Raise SceneError if the check of an acting effect fails."""
    for effect in acting(scene):
        effect.check(scene)


def section_kinds() -> dict[str, type[Section]]:
    """All sections that effects add to scenes, by name."""
    return {cls.Section.path: cls.Section for cls in effects() if cls.Section is not None}
