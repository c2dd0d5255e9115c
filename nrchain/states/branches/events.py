"""Re Λ_k(s) = 0: where the stability of a curve changes, and where it turns back.

The k-th largest real part of the exponents is a continuous function of the arclength s, although
exponents collide and cross. Where the number of growing exponents differs between two places, each
k between the two numbers has a root, which bisection and secants find. Roots that coincide are one
event of that multiplicity. The place itself follows by linear interpolation between the two
solutions next to it: at a branch point the equations are singular.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Generic

import numpy as np

from nrchain.comoving.dense import EPSILON
from nrchain.states.branches.curve import Curve, S
from nrchain.states.branches.follow import Follower, Place

FOLD, PITCHFORK, TRANSCRITICAL, HOPF = "fold", "pitchfork", "transcritical", "Hopf"

BRANCHING = "branch point"
"""A pitchfork or transcritical point: rounding hides the null vectors that tell which."""

BESIDE = 1e-3
"""A root nearer to a fold than this part of a step is that of the fold."""

CLOSE = 1e-7
"""A root is bracketed to this part of a step."""

SAME = 1e-5
"""Roots nearer to each other than this part of a step are one event."""


@dataclass(frozen=True, eq=False)
class Event(Generic[S]):
    """Where the stability of a curve changes.

    Attributes
    ----------
    kind
        "fold", "pitchfork" or "transcritical" where a real exponent crosses zero, "Hopf" for a pair
        of a state; of cycles also "period doubling" and "Neimark–Sacker".
    value, error
        p, and an estimate of its error.
    frequency
        |Im Λ|.
    multiplicity
        Number of exponents, or pairs, that cross at once.
    length
        Arclength from the place before.
    place
        The solution nearest to it.
    """

    kind: str
    value: float
    error: float
    frequency: float
    multiplicity: int
    length: float
    place: Place[S]


def events_between(follower: Follower[S], before: Place[S], after: Place[S]) -> list[Event[S]]:
    """The events on the step from one place to the next, in order."""
    step = _Step(follower, before, after)
    low, high = sorted((before.unstable, after.unstable))
    noise = follower.curve.noise(before.solution)
    events = [step.root(partial(_growth, k), noise) for k in range(low, high)]
    turns = before.tangent.value * after.tangent.value < 0.0
    fold = step.extremum() if turns else None
    groups: list[list[_Root[S]]] = []
    for root in sorted((one for one in events if one is not None), key=lambda one: one.length):
        if groups and root.length - groups[-1][-1].length <= SAME * after.length:
            groups[-1].append(root)
        else:
            groups.append([root])
    named = [_event(follower.curve, group, fold, after.length) for group in groups]
    if fold is not None and not any(event.kind == FOLD for event in named):
        # no exponent changes its sign: the branch meets one of higher symmetry, and comes back
        # as its own image
        named.append(Event(PITCHFORK, fold.value, fold.error, 0.0, 1, fold.length, fold.place))
    return sorted(named, key=lambda event: event.length)


def _growth(k: int, place: Place[S]) -> float:
    """The k-th largest real part, from 0 on."""
    # of a long chain only the leading ones are known
    return float(place.exponents[min(k, len(place.exponents) - 1)].real)


def turns_back(event: Event[S], before: Place[S], after: Place[S]) -> bool:
    """Whether a curve meets one of higher symmetry in an event, and comes back as its own image."""
    turned = before.tangent.value * after.tangent.value < 0.0
    return turned and event.kind == PITCHFORK and before.unstable == after.unstable


def _event(
    curve: Curve[S], group: list[_Root[S]], fold: _Root[S] | None, length: float
) -> Event[S]:
    """The event of roots that coincide."""
    first, count, error = group[0], len(group), max(root.error for root in group)
    solution, exponents = first.place.solution, first.place.exponents
    exponent = complex(exponents[int(np.abs(exponents.real).argmin())])
    if not curve.is_real(solution, exponent):
        kind, together = curve.oscillation(solution, exponent)
        given = abs(exponent.imag), max(count // together, 1)
    elif fold is not None and abs(fold.length - first.length) <= BESIDE * length:
        return Event(FOLD, fold.value, fold.error, 0.0, 1, fold.length, fold.place)
    else:
        kind, given = curve.branching(solution, exponents, count), (0.0, count)
    return Event(kind, first.value, error, *given, first.length, first.place)


@dataclass(frozen=True, eq=False)
class _Root(Generic[S]):
    """Where a test function vanishes."""

    length: float
    value: float
    error: float
    place: Place[S]


class _Step(Generic[S]):
    """The solutions on a step, each found once."""

    def __init__(self, follower: Follower[S], before: Place[S], after: Place[S]) -> None:
        self._follower, self._before = follower, before
        self._length = after.length
        self._places = {0.0: before, after.length: after}

    def _at(self, length: float) -> Place[S]:
        if length not in self._places:
            self._places[length] = self._follower.between(self._before, length)
        return self._places[length]

    def root(self, function: Callable[[Place[S]], float], rounding: float = 0.0) -> _Root[S] | None:
        """The root of a function between the ends; None if it has one sign there.

        ``rounding`` of the function is an error of p as well.
        """
        from scipy.optimize import brentq

        ends = [function(self._at(length)) for length in (0.0, self._length)]
        if ends[0] * ends[1] >= 0.0:
            return None
        tolerance = CLOSE * self._length
        try:
            brentq(lambda s: function(self._at(float(s))), 0.0, self._length, xtol=tolerance)
        except FloatingPointError:
            self._approach(function)
        (s0, f0), (s1, f1) = self._bracket(function)
        part = f0 / (f0 - f1)
        first, second = self._at(s0), self._at(s1)
        p0, p1 = first.solution.value, second.solution.value
        value = p0 + part * (p1 - p0)
        return _Root(
            length=s0 + part * (s1 - s0),
            value=float(value),
            error=float(
                abs(p1 - p0) * (s1 - s0) / self._length
                + abs((p1 - p0) / (f1 - f0)) * rounding
                + EPSILON * abs(value)
            ),
            place=first if abs(f0) <= abs(f1) else second,
        )

    def _approach(self, function: Callable[[Place[S]], float]) -> None:
        """Places on both sides of a root next to which no solution is found.

        Near a branch point the equations are almost singular. Interpolation between two places at
        a distance of a hundredth of the step is still good to 1e-4 of it.
        """
        for closer in (0.1, 0.01, 0.001):
            (s0, f0), (s1, f1) = self._bracket(function)
            middle = s0 + f0 / (f0 - f1) * (s1 - s0)
            for side in (-1.0, 1.0):
                length = middle + side * closer * self._length
                if s0 < length < s1:
                    with suppress(FloatingPointError):
                        self._at(length)

    def _bracket(
        self, function: Callable[[Place[S]], float]
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """The two neighbouring places, as (s, f), between which f first changes its sign."""
        known = sorted((length, function(place)) for length, place in self._places.items())
        begin = known[0][1]
        second = next(k for k, (_, value) in enumerate(known) if value * begin <= 0.0)
        return known[second - 1], known[second]

    def extremum(self) -> _Root[S] | None:
        """Where dp/ds vanishes; p there, of a parabola, is known better than the place."""

        def slope(place: Place[S]) -> float:
            return place.tangent.value

        found = self.root(slope)
        if found is None:
            return None
        nearest = sorted(self._places.items(), key=lambda one: abs(one[0] - found.length))[:2]
        values = [
            place.solution.value + 0.5 * (found.length - length) * slope(place)
            for length, place in nearest
        ]
        error = abs(values[0] - values[1]) + EPSILON * abs(values[0])
        return replace(found, value=float(values[0]), error=float(error))
