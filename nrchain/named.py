"""What is looked up by its name: a name that is none is told, with those there are."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NoReturn, TypeVar

from nrchain.errors import UnknownNameError
from nrchain.scene_rules import did_you_mean

Value = TypeVar("Value")


def unknown_name(name: object, known: Iterable[str]) -> UnknownNameError:
    """The error for a name that is none of those ``known``, with the nearest."""
    known = list(known)
    there = f"there are {', '.join(known)}" if known else "there is none"
    return UnknownNameError(f"{name!r} is not known; {there}{did_you_mean(name, known)}")


class Named(dict[str, Value]):
    """Values by name; raises :class:`~nrchain.errors.UnknownNameError`, a ``KeyError``.

    >>> Named(stretch=1.0, shear=2.0)["sheer"]
    Traceback (most recent call last):
    nrchain.errors.UnknownNameError: 'sheer' is not known; there are stretch, shear; did you mean \
'shear'?
    """

    def __missing__(self, name: Any) -> NoReturn:
        raise unknown_name(name, self)
