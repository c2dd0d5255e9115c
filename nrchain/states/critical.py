"""Re Λ₁(p) = 0: the value of a key at which a state loses or gains its stability.

The growth of the leading mode, the largest real part of all modes of the shape, is continuous in p.
Its zero within a bracket is found by Brent's method. At the zero the frequency tells buckling, Λ =
0, from flutter, Λ = ± iω. Motions of the chain as a whole are no modes, so that a free chain has
thresholds too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.rules import is_number
from nrchain.notebook import record_html
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.states.parameters import find_parameter
from nrchain.states.spectrum import Spectrum, spectrum
from nrchain.wording import brief

MODES = 4
"""Leading modes that are computed at each value; each further one costs a factorisation."""

RELATIVE = 1e-10
"""Relative accuracy of the value."""


@dataclass(frozen=True)
class CriticalStrength:
    """The value of a key at which the leading growth rate is zero.

    Attributes
    ----------
    key, value
        The key of the scene and its value.
    error
        Estimate of the error of the value: that of the rate over its slope, and of the search.
    slope
        d Re Λ/dp there.
    frequency
        |Im Λ| there: 0 where a chain buckles or coils, and that of the oscillation where it
        flutters.
    spectrum
        The spectrum there.
    evaluations
        Number of spectra that were computed.

    >>> from nrchain import critical_strength, load_scene
    >>> scene = load_scene("buckling", **{"chain.particles": 8})
    >>> bool(critical_strength(scene, "slip.2s", (0.0, 2000.0)).value > 0.0)
    True
    """

    key: str
    value: float
    error: float
    slope: float
    frequency: float
    spectrum: Spectrum
    evaluations: int

    __repr__ = brief
    _repr_html_ = record_html


def critical_strength(
    scene: Scene, key: str, between: Sequence[float], at: Any = None
) -> CriticalStrength:
    """p with Re Λ₁(p) = 0: where the straight chain, or another state, turns unstable.

    Parameters
    ----------
    key
        A dotted key with one number for a value, such as ``slip.2s``, or one number of a list,
        such as ``slip.2s[3]``.
    between
        Two values of the key. The state is stable at one and unstable at the other.
    at
        Poses near the state at every value, as for :func:`nrchain.spectrum`.

    Raises :class:`~nrchain.errors.SceneError` if the leading growth has one sign at both ends.

    >>> from nrchain import load_scene
    >>> found = critical_strength(load_scene("buckling"), "slip.2s", (20.0, 80.0))
    >>> round(found.value, 1), found.frequency
    (42.2, 0.0)
    """
    from scipy.optimize import brentq

    require_scene(scene)
    low, high = _bracket(between)
    spectra: dict[float, Spectrum] = {}
    change = find_parameter(scene, key).changed

    def growth(value: float) -> float:
        spectra[value] = spectrum(change(float(value)), at, modes=MODES)
        return spectra[value].leading.growth

    ends = growth(low), growth(high)
    if (ends[0] > 0.0) == (ends[1] > 0.0):
        grows = "grows" if ends[0] > 0.0 else "decays"
        allowed = (
            f"must hold a change of stability: the leading mode {grows} at both ends, with Re Λ ="
            f" {ends[0]:.4g} and {ends[1]:.4g}"
        )
        raise SceneError("between", (low, high), allowed)
    tolerance = RELATIVE * max(abs(low), abs(high))
    value = float(brentq(growth, low, high, xtol=tolerance, rtol=4.0 * RELATIVE))
    growth(value)
    found = spectra[value]
    slope = found.sensitivities(keys=[key])[key].real
    return CriticalStrength(
        key=key,
        value=value,
        error=(found.leading.error + abs(found.leading.growth)) / abs(slope) + tolerance,
        slope=slope,
        frequency=abs(found.leading.frequency),
        spectrum=found,
        evaluations=len(spectra) + 1,
    )


def _bracket(between: Any) -> tuple[float, float]:
    """The two values, in order."""
    try:
        low, high = sorted(between)
    except (TypeError, ValueError):
        low = high = math.nan
    if not (is_number(low) and is_number(high) and low < high):
        raise SceneError("between", between, "must be two different finite numbers")
    return float(np.float64(low)), float(np.float64(high))
