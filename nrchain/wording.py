"""Numbers in words, as tables and messages show them."""

from __future__ import annotations


def span(*shown: str, sign: str = " to ") -> str:
    """``least sign most`` of numbers as they are shown, each once: one number where all look alike.

    >>> span("1.4", "1.9"), span("1.4", "1.4")
    ('1.4 to 1.9', '1.4')
    """
    return sign.join(dict.fromkeys(shown))


def digits(number: float) -> str:
    """A number of two or three digits, with an exponent only where that is shorter.

    >>> digits(0.03712), digits(496.2), digits(1.5e7)
    ('0.037', '496', '1.5e+07')
    """
    return f"{number:.0f}" if 100.0 <= number < 1e6 else f"{number:.2g}"
