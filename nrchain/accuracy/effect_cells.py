"""The cells of the table of effects, and the marks in them."""

from __future__ import annotations

import math

from nrchain.planning.effect_changes import Change, Refused
from nrchain.planning.estimate import RESOLUTION, Estimate
from nrchain.wording import span

COLUMNS = ("effect", "velocity", "growth", "displaced", "rotated", "cost")
"""The columns of the table."""


def row(one: Estimate, own: float, other: float) -> tuple[str, ...]:
    """The cells of an effect; ``own`` and ``other`` time the scene without and with the change."""
    drop = one.change.kind == "drop"
    growth = "" if one.growth is None else _signed(one.growth)
    share = (own - other) / own if drop and own else (other - own) / own if own else 0.0
    return (
        name(one.change),
        span(_size(one.velocity), _size(one.velocity_along), sign="–"),
        growth,
        *(_end(one, value) for value in (one.displacement, one.turn)),
        f"{100.0 * share:+.0f} %",
    )


def _end(one: Estimate, value: float) -> str:
    """A difference at the end, with * if it is that of another time; ? where it is not known."""
    if not is_known(one, value):
        return "?"
    size = _size(value) if value == 0.0 or value >= RESOLUTION else f"<{_size(RESOLUTION)}"
    return size + ("" if one.ends else "*")


def is_known(one: Estimate, value: float) -> bool:
    """Whether a probe took a step and gave a finite difference."""
    return one.until > 0.0 and math.isfinite(value)


def explain_marks(one: Estimate) -> str:
    """What the marks * and ? of a row mean."""
    if any(is_known(one, value) for value in (one.displacement, one.turn)):
        return f"* is at t = {one.until:.4g}, where the probe ended; the end is not known"
    if one.until == 0.0:
        return "? is not known: the budget allowed the probe no step"
    return f"? is not finite at t = {one.until:.4g}, where the probe ended"


def _signed(value: float) -> str:
    """A size with its sign, + too."""
    return ("+" if value > 0.0 else "") + _size(value)


def _size(value: float) -> str:
    """Two digits, in the shorter of the two notations; ? for what is not finite."""
    if not math.isfinite(value):
        return "?"
    digits, exponent = f"{value:.1e}".split("e")
    return min(f"{value:.2g}", f"{digits.removesuffix('.0')}e{int(exponent)}", key=len)


def name(change: Change | Refused) -> str:
    """The effect of a row, with + if the scene leaves it out."""
    return change.effect if change.kind == "drop" else f"+ {change.effect}"
