"""s = ‖δ/(atol + rtol |y|)‖, z = h μ: which growth a step follows, and which it passes over.

A part δ of the poses that grows at rate μ is followed for one of two reasons.

- The step sees it. An L-stable step much longer than 1/μ damps what should grow, and errs by all
  of it, δ. Its error estimate is at least a (q + 1)-th of that with backward differences of order
  q, and nearly all of it when a step of Radau IIA is first tried. With s above ``SEEN`` such a
  step is refused, whatever z would be without that: the steps are as short as δ needs.
- The scheme is true to it. On linear equations every scheme multiplies δ by a function R(z), of
  any size of δ. Up to the z that a scheme names as ``followed`` it makes δ grow.

What is below the tolerance in steps beyond that is damped: a chain that buckles then ends straight.
And what is far below the errors that steps may leave along it may be made of them. Their bound is
‖δ (atol + rtol |y|)‖/‖δ‖², in units of δ and with |y| the largest so far; n is one over that. Such
a part matters if it would otherwise come to be seen, and would by then be no small part of what
bends the chain. The norms are those of the integrators: the root of the mean square over all
coordinates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.motion.integrators.base import Integrator
from nrchain.watch.growing_modes import TINY, Growth
from nrchain.watch.seed import BARELY, LEAST_ATOL

SEEN = 10.0
"""s from which on a step sees a part: an error of all of it is above the tolerance, for q ≤ 5."""

SOLVED = 1e-2
"""n below which Newton's iteration may end, or a linear solver not begin, whatever is left over."""

LARGEST = 1e-2
"""Bends of this many radii or radians no longer grow linearly: until then the largest wins."""

SHARE = 1e-2
"""What is less than this part of the bend at that time is let be."""

ABSENT = 1e-8
"""A mode below this part of the bend is not in it, by symmetry or otherwise."""

LEAST_RTOL = 1e-14
"""The least that ``run.rtol`` may be."""


@dataclass(frozen=True)
class Sight:
    """What the last step of an integrator, which came to ``y``, sees of small displacements.

    ``unit`` (dimension,) is what a coordinate is counted in: a radius, or a radian. ``most`` is the
    largest |y| so far, at any step. ``y`` is in the integrator's chart, and modes are in one about
    the poses reached. Their components differ by the tangent of the Cayley map: by the turn of a
    sphere since that chart was made, and by nothing in Radau's, which is made anew at every step.
    """

    unit: np.ndarray
    atol: float
    rtol: float
    y: np.ndarray
    most: np.ndarray
    followed: float

    @classmethod
    def of(cls, integrator: Integrator, atol: float, y: np.ndarray, most: np.ndarray) -> Sight:
        """That of an integrator with ``run.atol`` as given."""
        unit = integrator.atol / atol
        return cls(unit, atol, integrator.rtol, np.abs(y), most, integrator.followed)

    def across(self, axis: np.ndarray) -> float:
        """The largest tolerance of a displacement or a turn across the axis, in radii or radians.

        A coordinate along e_k counts by the part √(1 − (e_k·axis)²) of it that is across.
        """
        part = np.sqrt(np.maximum(1.0 - axis**2, 0.0))
        moved = (self.most / self.unit).reshape(-1, 3).max(axis=0, initial=0.0)
        return float((part * (self.atol + self.rtol * moved)).max())

    def sizes(self, parts: np.ndarray, atol: float, rtol: float) -> np.ndarray:
        """s (…) of parts (…, dimension) at these tolerances."""
        scale = atol * self.unit + rtol * self.y
        return np.sqrt(np.mean((parts / scale) ** 2, axis=-1))

    def certain(self, parts: np.ndarray, atol: float, rtol: float) -> np.ndarray:
        """n (…): parts (…, dimension) over what a step may leave of an error along them."""
        sizes, scale = parts / self.unit, atol + rtol * self.most / self.unit
        left = np.sqrt(np.mean((sizes * scale) ** 2, axis=-1))
        return np.mean(sizes**2, axis=-1) / np.maximum(left, TINY)

    def amplitudes(self, parts: np.ndarray) -> np.ndarray:
        """The largest coordinate (K,) of parts (K, dimension), in radii or radians."""
        return (parts / self.unit).max(axis=1, initial=0.0)

    def passed_over(self, growth: Growth, step: float, left: float, bend: float) -> int | None:
        """The mode that comes to be the largest of those that matter and are not followed.

        Those are not followed that are not seen, in steps that are too long; and all, where not
        even the largest is solved for.
        """
        rates, amplitudes = growth.rates, self.amplitudes(growth.parts)
        sizes = self.sizes(growth.parts, self.atol, self.rtol)
        certain = self.certain(growth.parts, self.atol, self.rtol)
        with np.errstate(divide="ignore"):
            high, far = np.log(amplitudes), np.log(sizes)
        ready = (math.log(LARGEST) - high) / rates
        until = min(left, max(float(ready.min(initial=left)), 0.0))
        grown = high + rates * until
        matters = (far + rates * until > 0.0) & (amplitudes > ABSENT * bend)
        matters &= grown > math.log(SHARE) + grown.max(initial=-math.inf)
        too_long = (sizes < SEEN) & (step * rates > self.followed)
        lost = matters & (too_long | (certain.max(initial=0.0) < SOLVED))
        return int(np.argmax(np.where(lost, grown, -math.inf))) if lost.any() else None

    def resolving(self, part: np.ndarray) -> str:
        """Tolerances at which this part is seen well; empty if there are none.

        ``run.rtol`` is named where it, on coordinates as large as these, hides what ``atol`` shows.
        """
        size = float(self.sizes(part, 1.0, 0.0))
        atol = min(self.atol, max(size / BARELY, LEAST_ATOL))
        if size < SEEN * atol:
            return ""
        finer = [f"run.atol = {atol:.1g}"] if atol < self.atol else []
        share = float(self.sizes(part, atol, self.rtol)) * atol / size
        share = min(share, float(self.certain(part, atol, self.rtol)))
        if share < 0.5:
            finer.append(f"run.rtol = {max(share * self.rtol, LEAST_RTOL):.1g}")
        return " and ".join(finer)
