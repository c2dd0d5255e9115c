"""Numbers in words, as tables and messages show them."""

from __future__ import annotations


def span(*shown: str, sign: str = " to ") -> str:
    """``least sign most`` of numbers as they are shown, each once: one number where all look alike.

    >>> span("1.4", "1.9"), span("1.4", "1.4")
    ('1.4 to 1.9', '1.4')
    """
    return sign.join(dict.fromkeys(shown))
