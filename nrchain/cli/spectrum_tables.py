"""What ``nrchain spectrum`` prints: the state, its modes, and what they are sensitive to."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from nrchain.cli.tables import plain_table
from nrchain.wording import digits

if TYPE_CHECKING:
    from nrchain.states.spectrum import Spectrum

MOST_SPHERES = 12
"""Sensitivities to the strengths of single spheres are shown if there are no more than these."""


def summary(found: Spectrum) -> list[str]:
    """The state, its neutral motions, its stability and its transient growth, a line each."""
    return [_state(found), _neutral(found), _stability(found), _transient(found)]


def _state(found: Spectrum) -> str:
    state, motion = found.state, found.state.motion
    shape = "the straight chain" if found.is_straight else "the chain"
    moves = []
    for word, vector in (("moves at V", motion.velocity), ("rotates at Ω", motion.rotation)):
        if np.abs(vector).max() > 1e3 * state.residual:
            moves.append(f"{word} = ({', '.join(f'{x:.6g}' for x in vector)})")
    if abs(motion.turn) > 1e3 * state.residual:
        moves.append(f"turns its spheres about e₁ at {motion.turn:.6g}")
    doing = " and ".join(moves) or "is at rest"
    return (
        f"state: {shape} {doing}; velocities are balanced to {state.residual:.1e},"
        f" positions to {state.error:.1e}"
    )


def _neutral(found: Spectrum) -> str:
    neutral = found.neutral
    if not len(neutral.rates):
        return "neutral motions: none"
    names = ", ".join(neutral.names)
    spins = np.abs(neutral.rates.imag).max()
    at = f"; rates 0 and ±{spins:.4g}i" if spins > 1e3 * neutral.error else ""
    return f"neutral motions: {len(neutral.rates)} ({names}){at}"


def _stability(found: Spectrum) -> str:
    growing = sum(
        mode.multiplicity * (1 + (mode.frequency != 0.0))
        for mode in found.modes
        if mode.growth > mode.error
    )
    if growing:
        last, more = found.modes[-1], ""
        if last.growth > last.error and found.is_whole:
            growing = int(np.sum(found.rates.real > last.error))
        elif last.growth > last.error:
            more = " or more"
        return f"unstable: {growing}{more} of {len(found.rates)} modes grow"
    if found.is_stable:
        return f"stable: the slowest mode decays within {digits(-1.0 / found.leading.growth)}"
    return "neither stable nor unstable: the leading growth is zero to its error"


def _transient(found: Spectrum) -> str:
    text = f"numerical abscissa: {found.abscissa:.4g}"
    growth = found.transient_growth()
    if growth is None:
        return f"{text}; transient growth is not computed for so many spheres"
    if math.isinf(growth.growth):
        return text
    if growth.growth == 1.0:
        return f"{text}; small changes decay from the start"
    return f"{text}; small changes grow up to {growth.growth:.4g} times, at t = {growth.time:.4g}"


def modes_table(found: Spectrum) -> Table:
    """Growth, frequency, error and condition of the leading modes."""
    table = plain_table()
    for title in ("growth", "frequency", "modes", "error", "residual", "condition"):
        table.add_column(title, justify="right")
    for mode in found.modes:
        pair = mode.frequency != 0.0
        table.add_row(
            f"{mode.growth:.6g}",
            f"±{abs(mode.frequency):.6g}" if pair else "0",
            str(mode.multiplicity * (2 if pair else 1)),
            f"{mode.error:.1e}",
            f"{mode.residual:.1e}",
            f"{mode.condition:.3g}",
        )
    return table


def sensitivities_table(found: Spectrum) -> Table:
    """The change of the leading rate by one percent more of each number of the scene."""
    from nrchain.states.parameters import parameters

    numbers = [one for one in parameters(found.scene) if _is_shown(found, one.key)]
    slopes = found.sensitivities(keys=[one.key for one in numbers])
    table = plain_table("key", "value", "growth\nby +1 %", "frequency\nby +1 %")
    for one in numbers:
        change = 0.01 * one.value * slopes[one.key]
        table.add_row(one.key, f"{one.value:g}", f"{change.real:+.3g}", f"{change.imag:+.3g}")
    return table


def _is_shown(found: Spectrum, key: str) -> bool:
    return "[" not in key or found.scene.chain.particles <= MOST_SPHERES
