"""Look up values by name: unknown names raise errors with the known and the nearest name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any, NoReturn, TypeVar

from nrchain.errors import UnknownNameError

Value = TypeVar("Value")

NEAR, SURE = 0.5, 0.7
"""Similarity of a spelling to a name at which the name is suggested, and at which it is meant."""


def unknown_name(name: object, known: Iterable[str]) -> UnknownNameError:
    """The error for an unknown name, with the known names and the nearest."""
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


def did_you_mean(given: object, names: Iterable[str]) -> str:
    """A suggestion of the name whose last part is nearest; empty if none is near."""
    near = nearest(given, names, NEAR)
    return f"; did you mean {near!r}?" if near else ""


def nearest(given: object, names: Iterable[str], alike: float) -> str | None:
    """The name whose last part is nearest to the given text, or None; case is ignored.

    >>> nearest("2S", ["2s", "3a"], SURE), nearest("4t", ["3t", "4a"], SURE)
    ('2s', None)
    """
    tails = {name.rpartition(".")[2].lower(): name for name in names}
    near = difflib.get_close_matches(str(given).lower(), tails, n=1, cutoff=alike)
    return tails[near[0]] if near else None
