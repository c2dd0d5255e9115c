"""A few values of a parameter for every run of the tests, and the others for the slow ones."""

from collections.abc import Container, Iterable
from typing import Any

import pytest


def few_of(values: Iterable[Any], few: Container[Any]) -> list[Any]:
    """The values; those that are not among ``few`` are marked slow.

    >>> [getattr(value, "values", value) for value in few_of([1, 2, 3], {2})]
    [(1,), 2, (3,)]
    """
    return [value if value in few else _slow(value) for value in values]


def _slow(value: Any) -> Any:
    parts = value if isinstance(value, tuple) else (value,)
    return pytest.param(*parts, marks=pytest.mark.slow)
