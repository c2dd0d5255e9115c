"""Rules of a scene that need several of its sections.

Each function raises :class:`~nrchain.errors.SceneError` with the key, the value and what is
allowed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from nrchain.errors import NOT_GIVEN, SceneError
from nrchain.inputs.arrays import refuse_rows
from nrchain.inputs.rules import Section
from nrchain.scene.chain_sections import POSES, ChainSpec, StartSpec
from nrchain.scene.derived import length, slip_has_sum
from nrchain.scene.fluid_sections import FrictionSpec, SlipSpec

MANY_NEIGHBOURS = 10_000
"""Above this many neighbours, effects check whether they can sum them along an endless chain."""

NO_SUM = "a flow of order 1/r has no sum over an endless chain; give a number of neighbours"
"""Why such a flow cannot take all pairs of a periodic chain."""

LARGEST_OFFSET = 1e6
"""Largest amplitude of a start, in d. Beyond it, rounding blurs the rest length of a link."""


def check_named_effects(tolerance: float | None) -> None:
    """Refuse a tolerance without effects = "auto"."""
    if tolerance is not None:
        allowed = "is for effects = 'auto'; remove it, or set effects = 'auto'"
        raise SceneError("tolerance", tolerance, allowed)


def check_auto_effects(tolerance: float | None, sections: Iterable[Section]) -> None:
    """Refuse effects = "auto" without its tolerance, or beside keys that it sets."""
    if tolerance is None:
        allowed = (
            "must be given with effects = 'auto': the largest distance from the full model, in"
            " radii"
        )
        raise SceneError("tolerance", NOT_GIVEN, allowed)
    for section in sections:
        default = type(section)()
        for name in section.set_by_auto:
            if getattr(section, name) != getattr(default, name):
                allowed = "is set by effects = 'auto'; remove one of the two"
                raise SceneError(section.key(name), getattr(section, name), allowed)


def check_strengths(slip: SlipSpec, chain: ChainSpec) -> None:
    """Refuse a list of strengths that has not one for each sphere."""
    for label, mode in slip.modes.items():
        if isinstance(mode.strength, tuple) and len(mode.strength) != chain.particles:
            allowed = (
                f"must be one number, or one for each of the {chain.particles} spheres,"
                f" not {len(mode.strength)}"
            )
            raise SceneError(SlipSpec.key(label), mode.strength, allowed)


def check_start(start: StartSpec, chain: ChainSpec) -> None:
    """Refuse a wave that the spheres of the chain cannot show, and amplitudes lost to rounding."""
    for name in POSES:
        refuse_rows(start.key(name), getattr(start, name), chain.particles)
    if start.shape in ("straight", "given"):
        return
    if abs(start.amplitude) > LARGEST_OFFSET * chain.spacing:
        allowed = f"must be no more than {LARGEST_OFFSET:g} times chain.spacing = {chain.spacing!r}"
        raise SceneError("start.amplitude", start.amplitude, allowed)
    shortest = length(chain) / chain.spacing / (2 if chain.ends == "periodic" else 1)
    excess = start.wavenumber / shortest - 1.0
    if start.shape == "sine" and abs(excess) < 1e-9:
        allowed = f"must be below {shortest:g}: a sine of that wavenumber is zero at every sphere"
        raise SceneError("start.wavenumber", start.wavenumber, allowed)
    if start.shape != "random" and excess > 1e-9:
        allowed = (
            f"must be at most {shortest:g}, a wave two spheres long: spheres cannot show a shorter"
            " wave"
        )
        raise SceneError("start.wavenumber", start.wavenumber, allowed)


def check_periodic(start: StartSpec, slip: SlipSpec, friction: FrictionSpec) -> None:
    """Refuse what a periodic chain cannot repeat along x."""
    if not start.wavenumber.is_integer():
        allowed = "must be a whole number on a periodic chain, so that the wave fits its period"
        raise SceneError("start.wavenumber", start.wavenumber, allowed)
    for spec in (slip, friction):
        if spec.backend == "pystokes":
            allowed = (
                "sums no periodic images; set 'native', or choose free or clamped ends of the chain"
            )
            raise SceneError(spec.key("backend"), spec.backend, allowed)
    if slip.neighbours == "all" and not slip_has_sum(slip):
        raise SceneError("slip.neighbours", slip.neighbours, NO_SUM)


def check_range(name: str, values: Iterable[float], section: Section, *, zero: bool) -> None:
    """Refuse derived numbers that are not finite and positive (``zero``: or 0)."""
    if not all(math.isfinite(v) and (v > 0 or zero) for v in values):
        allowed = (
            f"with the other numbers of the scene this puts the {name} beyond the range of floating"
            " point; choose units in which they are closer to 1"
        )
        raise SceneError(section.path, section.to_mapping(), allowed)
