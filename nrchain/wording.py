"""Numbers and records as tables and messages show them."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

MOST_CHARACTERS = 60
"""Largest number of characters that :func:`brief` spends on one value."""


def span(*shown: str, sign: str = " to ") -> str:
    """A range, such as ``1.4 to 1.9``; a single number where both ends look the same.

    >>> span("1.4", "1.9"), span("1.4", "1.4")
    ('1.4 to 1.9', '1.4')
    """
    return sign.join(dict.fromkeys(shown))


def digits(number: float) -> str:
    """A number with two or three digits, and an exponent only where that is shorter.

    >>> digits(0.03712), digits(496.2), digits(1.5e7)
    ('0.037', '496', '1.5e+07')
    """
    return f"{number:.0f}" if 100.0 <= number < 1e6 else f"{number:.2g}"


def brief(record: Any) -> str:
    """The ``repr`` of a dataclass in one line: arrays by their shape, long lists by their length.

    >>> from dataclasses import dataclass
    >>> @dataclass
    ... class Measured:
    ...     time: np.ndarray
    ...     rate: float
    ...     __repr__ = brief
    >>> Measured(np.zeros(5), 1 / 3)
    Measured(time=array (5,), rate=0.333333)
    """
    shown = (f"{f.name}={brief_value(getattr(record, f.name))}" for f in fields(record) if f.repr)
    return f"{type(record).__name__}({', '.join(shown)})"


def brief_value(value: Any) -> str:
    """A value in at most :data:`MOST_CHARACTERS`: six digits of numbers, the shape of arrays."""
    if isinstance(value, float | complex):
        return f"{value:.6g}"
    if hasattr(value, "dtype"):
        # an array, recognised without importing NumPy
        return f"array {value.shape}"
    text = repr(value)
    if len(text) <= MOST_CHARACTERS:
        return text
    if isinstance(value, list | tuple | dict):
        return f"{type(value).__name__} of {len(value)}"
    return f"{text[: MOST_CHARACTERS - 1]}…"
