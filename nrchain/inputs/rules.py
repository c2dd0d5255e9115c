"""A rule for each key: the allowed values, in words, and the conversion to a plain value.

A rule takes ``(key, value)`` and returns the value as a plain Python object, or raises
:class:`~nrchain.errors.SceneError`. A :class:`Section` is a frozen dataclass whose annotations
carry the rules,

    spacing: Annotated[float, number(above=0)] = 10.0

Type, rule and default of a key are on one line. Conditions on several keys are in
``Section.check``.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import sys
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, Self, get_args, get_origin, get_type_hints

from nrchain.errors import NOT_GIVEN, SceneError, shorten
from nrchain.inputs.about import About
from nrchain.inputs.names import did_you_mean
from nrchain.notebook import table_html

Rule = Callable[[str, Any], Any]


def rule(
    allowed: str,
    accepts: Callable[[Any], bool],
    convert: Callable[[Any], Any] = lambda v: v,
    near: Callable[[Any], Any] = lambda v: v,
) -> Rule:
    """A rule that accepts values by ``accepts``, and refuses others with "must be ``allowed``".

    ``near`` turns a refused value into the one probably meant, which the message suggests.
    """

    def read(key: str, value: Any) -> Any:
        plain = _plain(value)
        if not accepts(plain):
            meant = near(plain)
            hint = f"; did you mean {_spelt(meant)}?" if accepts(meant) else ""
            raise SceneError(key, value, f"must be {allowed}{hint}")
        return convert(plain)

    return read


def number(
    *, above: float = -math.inf, least: float = -math.inf, most: float = math.inf, reason: str = ""
) -> Rule:
    """A finite number with above < x and least ≤ x ≤ most, kept as a float; ``reason`` says why."""
    bounds = (("above", above), ("at least", least), ("at most", most))
    words = " and ".join(f"{word} {bound:g}" for word, bound in bounds if math.isfinite(bound))
    return rule(
        "a finite number" + (words and ", " + words) + (reason and ": " + reason),
        lambda v: is_number(v) and above < v and least <= v <= most,
        float,
    )


def whole(*, least: int) -> Rule:
    """A whole number n with least ≤ n < 2⁶³; neither 2.0 nor True is one."""
    words = f"a whole number of at least {least}"
    read_whole = rule(
        words,
        lambda v: is_whole(v) and least <= v,
        near=lambda v: int(v) if isinstance(v, float) and v.is_integer() else v,
    )

    def read(key: str, value: Any) -> Any:
        plain = read_whole(key, value)
        if plain >= 2**63:
            raise SceneError(key, value, f"must be {words} and below 2^63")
        return plain

    return read


def choice(literal: Any) -> Rule:
    """One of the names of a ``Literal``."""
    names = get_args(literal)

    def read(key: str, value: Any) -> Any:
        if not isinstance(value, str) or value not in names:
            hint = did_you_mean(value, names)
            raise SceneError(key, value, f"must be one of {', '.join(names)}{hint}")
        return str(value)

    return read


def optional(inner: Rule) -> Rule:
    """None, or what ``inner`` allows."""
    return lambda key, value: None if value is None else inner(key, value)


def one_or_each(inner: Rule) -> Rule:
    """One value, or a list kept as a tuple; a message names a refused item by its index."""

    def read(key: str, value: Any) -> Any:
        plain = _plain(value)
        if isinstance(plain, (list, tuple)):
            return tuple(inner(f"{key}[{i}]", item) for i, item in enumerate(plain))
        try:
            return inner(key, plain)
        except SceneError as error:
            raise SceneError(
                key, value, f"{error.allowed}, or a list with one for each sphere"
            ) from None

    return read


def direction() -> Rule:
    """A vector of three finite numbers with a length that is not zero."""
    return rule(
        "three finite numbers, not all zero, of a length between 1e-100 and 1e100",
        lambda v: (
            isinstance(v, (list, tuple))
            and len(v) == 3
            and all(is_number(x) for x in v)
            and 1e-100 <= math.hypot(*v) <= 1e100
        ),
        lambda v: tuple(float(x) for x in v),
    )


def vector(*, of: int = 3, inner: Rule | None = None) -> Rule:
    """A list of three finite numbers, or of ``of`` values by ``inner``, kept as a tuple."""
    read_item = number() if inner is None else inner

    def read(key: str, value: Any) -> Any:
        plain = _plain(value)
        if not isinstance(plain, (list, tuple)) or len(plain) != of:
            what = "finite numbers" if inner is None else "rows of three finite numbers"
            raise SceneError(key, value, f"must be a list of {of} {what}")
        return tuple(read_item(f"{key}[{i}]", item) for i, item in enumerate(plain))

    return read


def flag() -> Rule:
    """True or False."""
    written = {"true": True, "false": False}
    return rule(
        "true or false",
        lambda v: isinstance(v, bool),
        near=lambda v: written.get(v.lower()) if isinstance(v, str) else v,
    )


def line() -> Rule:
    """One line of text, for plot titles and file attributes."""
    return rule("one line of printable text", lambda v: isinstance(v, str) and v.isprintable())


def section(kind: type[Section]) -> Rule:
    """A section of this class, or a raw table of its keys; None is an empty table."""

    def read(key: str, value: Any) -> Any:
        if isinstance(value, kind):
            return value
        if value is None or value is NOT_GIVEN:
            return kind.from_mapping({})
        if isinstance(value, Mapping):
            return kind.from_mapping(value)
        raise _not_a_table(kind, key, value)

    return read


def _not_a_table(kind: type[Section], key: str, value: Any) -> SceneError:
    """The error for a value in place of a section: the known keys, and the one that fits."""
    text = f"must be a table of {', '.join(kind.names())}"
    fitting = [name for name in kind.rules() if _holds(kind, name, value)]
    if isinstance(value, str) and len(fitting) == 1:
        text += f"; did you mean {key}.{fitting[0]} = {value!r}?"
    return SceneError(key, value, text)


def _holds(kind: type[Section], name: str, value: Any) -> bool:
    try:
        kind.rules()[name](name, value)
    except SceneError:
        return False
    return True


@cache
def _rules(kind: Any) -> dict[str, Rule]:
    """The rules in the annotations of a class, cached because reading them is slow."""
    hints = get_type_hints(kind, include_extras=True).items()
    return {name: h.__metadata__[0] for name, h in hints if get_origin(h) is Annotated}


class Section:
    """A frozen dataclass that reads and checks each key by the rule in its annotation.

    Construction raises :class:`~nrchain.errors.SceneError` for a refused key. All values are kept
    as plain, hashable Python objects, also those given as NumPy numbers and arrays.

    >>> from nrchain import load_scene
    >>> isinstance(load_scene("buckling").chain, Section)
    True
    """

    __slots__ = ()
    path: ClassVar[str] = ""
    """The name of the section in a scene: the first part of its dotted keys."""
    set_by_auto: ClassVar[tuple[str, ...]] = ()
    """The keys that ``effects = "auto"`` sets."""
    about: ClassVar[Mapping[str, About]] = {}
    """What each key is for."""

    def __post_init__(self) -> None:
        for name, read in self.rules().items():
            object.__setattr__(self, name, read(self.key(name), getattr(self, name)))
        self.check()

    def check(self) -> None:
        """Raise SceneError for values that do not fit together."""

    def _repr_html_(self) -> str:
        rows = [(name, shorten(value)) for name, value in self.to_mapping().items()]
        return table_html(self.path or type(self).__name__, rows, ("key", "value"))

    @classmethod
    @functools.cache
    def rules(cls) -> dict[str, Rule]:
        """The rule of every field, in the order of the fields."""
        kind: Any = cls
        return dict(_rules(kind))

    @classmethod
    def key(cls, name: str) -> str:
        """The dotted key of a field."""
        return f"{cls.path}.{name}" if cls.path else name

    @classmethod
    def spellings(cls) -> tuple[str, ...]:
        """The keys that messages suggest for a mistyped one."""
        return tuple(cls.rules())

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """The keys of the section, as messages list them."""
        return cls.spellings()

    @classmethod
    def from_mapping(cls, table: Mapping[str, Any]) -> Self:
        """The section of a raw table; a key with the value None counts as not given."""
        known = cls.rules()
        if not isinstance(table, Mapping):
            raise SceneError(cls.path or cls.__name__.lower(), table, "must be a table")
        for name, value in table.items():
            if name not in known:
                raise unknown(cls.key(name), value, known, cls.spellings())
        given = {name: value for name, value in table.items() if value is not None}
        return cls(**dict.fromkeys(_required(cls), NOT_GIVEN) | given)

    def to_mapping(self) -> dict[str, Any]:
        """The raw table of the section, without keys that are None."""
        values = {name: getattr(self, name) for name in self.rules()}
        return {
            name: value.to_mapping() if isinstance(value, Section) else value
            for name, value in values.items()
            if value is not None
        }


def unknown(
    key: str, value: object, known: Iterable[str], meant: Iterable[str] | None = None
) -> SceneError:
    """The error for an unknown key, with the known keys and the nearest of those ``meant``."""
    # tables from Python may have keys that are not strings
    hint = did_you_mean(str(key).rpartition(".")[2], known if meant is None else meant)
    return SceneError(str(key), value, f"is not a known key; there are {', '.join(known)}{hint}")


def _spelt(value: Any) -> str:
    """A value as a scene file and a command line spell it."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


def is_whole(value: object) -> bool:
    """Whether a value is an int that is not a bool."""
    return isinstance(value, int) and not isinstance(value, bool)


def is_number(value: Any) -> bool:
    """Whether a value is an int or float that a finite float can hold."""
    return (isinstance(value, float) or is_whole(value)) and abs(value) <= sys.float_info.max


def _plain(value: Any) -> Any:
    """Numpy numbers and arrays as Python numbers and lists, everything else as it is."""
    return value.tolist() if hasattr(value, "tolist") else value


def _required(kind: Any) -> list[str]:
    """The fields of a dataclass that have no default."""
    missing = dataclasses.MISSING
    fields = dataclasses.fields(kind)
    return [f.name for f in fields if f.default is missing and f.default_factory is missing]
