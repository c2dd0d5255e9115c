"""The effects there are: those of this package, one file each, and those that are registered.

A file of this package that registers a class is found by its being there. Nothing is imported
before it is asked for, so that reading a scene which names no further section stays light.
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
from nrchain.errors import SceneError
from nrchain.inputs.names import did_you_mean
from nrchain.inputs.rules import Section
from nrchain.scene.scene import Scene

Registered = TypeVar("Registered", bound=type[Effect])

FIRST = ("stretch", "shear", "twist", "bend", "slip", "finite_size", "reach", "friction", "steric")
"""The order in which effects are listed; those of other files come after, by name."""

RESERVED = ("support", "total")
"""Names that decompositions have for what is no effect."""

_EFFECTS: dict[str, type[Effect]] = {}
_FAMILIES: dict[str, Callable[[], Iterable[type[Effect]]]] = {}
_METHODS = {"wrench": "add_wrenches", "twist": "add_twists"}
_DERIVATIVE = ("linearise", "add_blocks", "add_product")


def register_effect(cls: Registered) -> Registered:
    """Make an effect known to scenes, runs, decompositions and tests, and return it.

    Its ``Section`` becomes the table ``[name]`` of a scene. A trajectory file names its effects,
    it does not hold them: register an effect again before opening or resuming a run of it. Raises
    :class:`~nrchain.errors.SceneError` for a name that is taken and a class that lacks something;
    :func:`nrchain.check_effect` says whether what it has is right.
    """
    if not (isinstance(cls, type) and issubclass(cls, Effect)):
        raise SceneError("effect", cls, "must be a class derived from nrchain.Effect")
    for attribute in ("name", "summary", "equation"):
        if not isinstance(getattr(cls, attribute, None), str):
            raise SceneError(f"effect {cls.__name__}.{attribute}", None, "must be one line of text")
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
    """Make known the effects that a table gives rise to, one class an entry."""
    _FAMILIES[name] = members


def unregister_effect(effect: type[Effect] | str) -> None:
    """Forget an effect that was registered, given as its class or its name.

    Scenes that name it are refused from then on.
    """
    name = effect if isinstance(effect, str) else effect.name
    known = _EFFECTS.get(name)
    if known is None or not (isinstance(effect, str) or known is effect):
        raise SceneError("effect", name, "is not registered")
    if _is_own(known):
        raise SceneError("effect", name, "is one of the package, and stays")
    del _EFFECTS[name]


def _is_own(cls: type[Effect]) -> bool:
    """Whether a file of this package has it."""
    return cls.__module__.startswith(f"{nrchain.effects.__name__}.")


def _check_name(cls: type[Effect]) -> None:
    if cls.name in RESERVED:
        allowed = "is what decompositions call something else; choose a new one"
        raise SceneError("effect name", cls.name, allowed)
    for known in effects():
        if known.name == cls.name and known is not cls:
            allowed = "is taken by another effect; choose a new one"
            if known.__qualname__ == cls.__qualname__:
                allowed = (
                    f"is that of an earlier {cls.__qualname__}; to replace it, as when a cell of a"
                    f" notebook runs again, call nrchain.unregister_effect({cls.name!r}) first"
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
        allowed = "must name the section, and be no key and no attribute that every scene has"
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
        raise SceneError(
            f"effect {cls.name}.Section", None, "must be the section that calls for it"
        )
    needed = [_METHODS.get(cls.gives, ""), *_DERIVATIVE]
    if not needed[0]:
        allowed = f"must be one of {', '.join(_METHODS)}"
        raise SceneError(f"effect {cls.name}.gives", cls.gives, allowed)
    if issubclass(cls, OneBodyEffect) and cls.linearise is OneBodyEffect.linearise:
        needed.append("derivative")
    for name in needed:
        if getattr(cls, name) in (getattr(Effect, name, None), OneBodyEffect.derivative):
            raise SceneError(f"effect {cls.name}.{name}", None, "must be given by the class")


@cache
def _files() -> tuple[str, ...]:
    return tuple(m.name for m in pkgutil.iter_modules(nrchain.effects.__path__) if not m.ispkg)


def effects() -> tuple[type[Effect], ...]:
    """Every effect known, built-in ones first."""
    for name in _files():
        importlib.import_module(f"nrchain.effects.{name}")

    def place(cls: type[Effect]) -> tuple[int, str]:
        package, _, file = cls.__module__.rpartition(".")
        if package != nrchain.effects.__name__:
            return len(FIRST) + 1, ""
        return (FIRST.index(file), "") if file in FIRST else (len(FIRST), file)

    found = [*_EFFECTS.values(), *(cls for family in _FAMILIES.values() for cls in family())]
    return tuple(sorted(found, key=place))


def find_effect(name: str) -> type[Effect]:
    """The effect of a name; unknown names raise with those there are."""
    for cls in effects():
        if cls.name == name:
            return cls
    names = [cls.name for cls in effects()]
    raise SceneError(
        "effect", name, f"is not known; there are {', '.join(names)}{did_you_mean(name, names)}"
    )


def acting(scene: Scene) -> tuple[type[Effect], ...]:
    """The effects that a scene calls for and that contribute."""
    return tuple(cls for cls in effects() if cls.acts(scene))


def section_kind(name: str) -> type[Section] | None:
    """The section that an effect adds to scenes under this name, if one does."""
    if name in _files():
        importlib.import_module(f"nrchain.effects.{name}")
    for cls in _EFFECTS.values():
        if cls.Section is not None and cls.Section.path == name:
            return cls.Section
    return None


def check_scene(scene: Scene) -> None:
    """Refuse, with a SceneError, what makes no sense to an effect that acts."""
    for effect in acting(scene):
        effect.check(scene)


def section_kinds() -> dict[str, type[Section]]:
    """All sections that effects add to scenes, by name."""
    return {cls.Section.path: cls.Section for cls in effects() if cls.Section is not None}
