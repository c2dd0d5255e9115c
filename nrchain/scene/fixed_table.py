"""Immutable tables of a scene, compared and hashed by value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from nrchain.inputs.names import unknown_name

Entry = TypeVar("Entry")


class FixedTable(Mapping[str, Entry]):
    """Entries by name: immutable, compared and hashed by value."""

    __slots__ = ("_entries",)

    def __init__(self, entries: Mapping[str, Entry] | None = None) -> None:
        self._entries = dict(entries or {})

    def __getitem__(self, name: str) -> Entry:
        if name not in self._entries:
            raise unknown_name(name, self._entries)
        return self._entries[name]

    def __contains__(self, name: object) -> bool:
        # without the error of a missing name, which looks for similar ones
        return name in self._entries

    def get(self, name: str, default: Any = None) -> Any:
        """The entry of this name, or ``default``."""
        return self._entries.get(name, default)

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __hash__(self) -> int:
        return hash(frozenset(self._entries.items()))

    def __repr__(self) -> str:
        return repr(self._entries)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._entries,)
