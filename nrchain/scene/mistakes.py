"""All mistakes of a scene at once, each as the error that refuses it.

Keys are read one by one, then the conditions on the keys of a section, then those on several
sections. What depends on a mistake is not checked, so that no mistake is named that is none.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any, cast

from nrchain.errors import NOT_GIVEN, SceneError
from nrchain.inputs.rules import Section
from nrchain.scene.chain_sections import ChainSpec, ElasticitySpec, RunSpec, StartSpec
from nrchain.scene.checks import check_start, check_strengths
from nrchain.scene.extensions import extensions
from nrchain.scene.fluid_sections import FrictionSpec, SlipSpec
from nrchain.scene.scene import Scene

OWN: dict[str, type[Section]] = {
    kind.path: kind
    for kind in (ChainSpec, ElasticitySpec, SlipSpec, FrictionSpec, StartSpec, RunSpec)
}
"""The sections that every scene has."""

REQUIRED: dict[str, dict[str, Any]] = {"chain": {"particles": 20}, "run": {"end": 1.0}}
"""Stand-ins for required keys with a mistake, while the conditions on sections are checked."""

MOST = 100
"""Most mistakes between sections: each look finds one."""


def mistakes_in(table: Mapping[str, Any]) -> list[SceneError]:
    """Every mistake in a raw table of a scene; empty where :class:`Scene` takes it.

    >>> wrong = {"chain": {"particles": 1, "spacin": 10.0}, "run": {"end": 5.0, "rtol": 1.0}}
    >>> [error.key for error in mistakes_in(wrong)]
    ['chain.particles', 'chain.spacin', 'run.rtol']
    """
    kinds = OWN | extensions().section_kinds()
    found: list[SceneError] = []
    sound: dict[str, Any] = {}
    for name, value in table.items():
        kind = kinds.get(name)
        errors = list(_section_mistakes(kind, value) if kind else _top_mistakes(name, value))
        found += errors
        if not errors:
            sound[name] = value
        elif kind is SlipSpec and isinstance(value, Mapping):
            # a mode that cannot be read says nothing of the others
            readable = {k: v for k, v in value.items() if not [*_key_mistake(kind, k, v)]}
            if readable != value:
                sound[name] = readable
    for name in REQUIRED.keys() - table.keys():
        found += _missing(kinds[name], {})
    known = {name: sound.get(name, needed) for name, needed in REQUIRED.items()}
    between = list(_mistakes_between(sound | known))
    if "chain" not in sound:
        # what the scene is refused for with its own chain is not known
        between = [error for error in between if error.key == "tolerance"]
        between += _mistakes_with_chain(table.get("chain"), sound)
    return [*found, *between]


def _mistakes_with_chain(chain: Any, sound: Mapping[str, Any]) -> Iterator[SceneError]:
    """The mistakes of slip and start with those keys of a chain that have none."""
    if not isinstance(chain, Mapping):
        return
    readable: Any = _Readable(ChainSpec, chain)
    conditions: tuple[Callable[[], None], ...] = (
        lambda: check_strengths(SlipSpec.from_mapping(sound.get("slip", {})), readable),
        lambda: check_start(StartSpec.from_mapping(sound.get("start", {})), readable),
    )
    for condition in conditions:
        try:
            condition()
        except SceneError as error:
            yield error
        except _UnreadableError:
            continue


def _missing(kind: type[Section], value: Mapping[str, Any]) -> Iterator[SceneError]:
    """The required keys that a section lacks."""
    for name in REQUIRED.get(kind.path, {}):
        if value.get(name) is None:
            try:
                kind.rules()[name](kind.key(name), NOT_GIVEN)
            except SceneError as error:
                yield error


def _top_mistakes(name: str, value: Any) -> Iterator[SceneError]:
    """The mistake of a key beside the sections; one of an unknown key names the nearest."""
    try:
        if name in Scene.about:
            Scene.rules()[name](name, value)
        else:
            Scene.from_mapping(REQUIRED | {name: value})
    except SceneError as error:
        yield error


def _section_mistakes(kind: type[Section], value: Any) -> Iterator[SceneError]:
    """The mistakes within a section: those of its keys, or else of its keys together."""
    if not isinstance(value, Mapping):
        try:
            Scene.from_mapping(REQUIRED | {kind.path: value})
        except SceneError as error:
            yield error
        return
    wrong = [error for name, given in value.items() for error in _key_mistake(kind, name, given)]
    wrong += _missing(kind, value)
    yield from wrong
    if not wrong:
        try:
            kind.from_mapping(value)
        except SceneError as error:
            yield error
    else:
        yield from _mistake_of_readable_keys(kind, value)


class _UnreadableError(Exception):
    """A condition asks for a key that has a mistake."""


class _Readable:
    """A section with a mistake, as far as its conditions can read it."""

    def __init__(self, kind: type[Section], value: Mapping[str, Any]) -> None:
        self._kind = kind
        self._values: dict[str, Any] = {}
        for field in dataclasses.fields(cast(Any, kind)):
            given = value.get(field.name)
            rule = kind.rules()[field.name]
            with suppress(SceneError):
                if given is not None:
                    self._values[field.name] = rule(kind.key(field.name), given)
                elif field.default is not dataclasses.MISSING:
                    self._values[field.name] = field.default

    def __getattr__(self, name: str) -> Any:
        if name in self._values:
            return self._values[name]
        if name in self._kind.rules():
            raise _UnreadableError(name)
        found = inspect.getattr_static(self._kind, name)
        # methods and properties read this object, not a section
        bind: Any = getattr(found, "__get__", None)
        return bind(self, self._kind) if bind else found


def _mistake_of_readable_keys(
    kind: type[Section], value: Mapping[str, Any]
) -> Iterator[SceneError]:
    """The mistake of keys together, where a condition on them needs none that has a mistake."""
    check: Any = kind.check
    try:
        check(_Readable(kind, value))
    except SceneError as error:
        yield error
    except _UnreadableError:
        return


def _key_mistake(kind: type[Section], name: str, given: Any) -> Iterator[SceneError]:
    """The mistake of one key of a section, by its rule; one of an unknown key names the nearest."""
    if given is None and name in kind.rules():
        return
    try:
        if name in kind.spellings():
            kind.rules()[name](kind.key(name), given)
        else:
            kind.from_mapping(REQUIRED.get(kind.path, {}) | {name: given})
    except SceneError as error:
        yield error


def _mistakes_between(table: dict[str, Any]) -> Iterator[SceneError]:
    """The mistakes of sections that are right one by one: each look leaves out the last one."""
    for _ in range(MOST):
        try:
            Scene.from_mapping(table)
        except SceneError as error:
            yield error
            smaller = _without(table, error.key)
            if smaller == table:
                return
            table = smaller
        else:
            return


def _without(table: dict[str, Any], dotted: str) -> dict[str, Any]:
    """The table without a key, or without its section where that does not have the key."""
    name, _, rest = dotted.partition(".")
    key = re.split(r"[.\[]", rest)[0]
    section = table.get(name)
    if isinstance(section, Mapping) and key in section and key not in REQUIRED.get(name, {}):
        return table | {name: {k: value for k, value in section.items() if k != key}}
    # a tolerance that is missing is asked for by effects = "auto"
    dropped = "effects" if dotted == "tolerance" and name not in table else name
    return {k: value for k, value in table.items() if k != dropped or k in REQUIRED}
