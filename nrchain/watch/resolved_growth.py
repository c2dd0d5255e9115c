"""s = ‖δ/(atol + rtol |y|)‖, z = h μ: which growth a step h resolves, and which it damps.

A part δ of the poses that grows at rate μ is resolved for one of two reasons.

- Step control sees it. An L-stable step much longer than 1/μ damps what should grow and errs by all
  of δ. Its error estimate is at least a (q + 1)-th of that with backward differences of order q,
  and nearly all of it when a step of Radau IIA is first tried. With s above ``SEEN`` such a step is
  rejected: the steps become as short as δ needs.
- The scheme reproduces it. On linear equations every scheme multiplies δ, of any size, by a
  function R(z). Up to the z that a scheme names as its ``growth_limit``, R(z) makes δ grow.

Parts below the tolerance, in longer steps than that, are damped: a chain that buckles then ends
straight. Parts far below the errors that steps may leave along them may consist of such errors. A
bound of these errors is ‖δ (atol + rtol |y|)‖/‖δ‖², in units of δ and with |y| the largest so far;
n is its inverse. A part that is lost matters if it would otherwise rise above the tolerance and by
then be no small part of the bend. The norms are those of the integrators: the root of the mean
square over all coordinates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.motion.bend import LARGEST
from nrchain.motion.integrators.base import Integrator
from nrchain.watch.growing_modes import TINY, Growth
from nrchain.watch.seed import BARELY, LEAST_ATOL

SEEN = 10.0
"""s above which step control sees a part: its loss exceeds the tolerance, for orders q ≤ 5."""

SOLVED = 1e-2
"""n below which Newton's iteration, or a linear solver, may end before it has found the part."""

SHARE = 1e-2
"""Parts smaller than this fraction of the bend at that time do not matter."""

ABSENT = 1e-8
"""A mode below this fraction of the bend is absent from it, by symmetry or otherwise."""

LEAST_RTOL = 1e-14
"""The least that ``run.rtol`` may be."""


@dataclass(frozen=True)
class Resolution:
    """Which small displacements the last step of an integrator, which reached ``y``, resolves.

    Attributes
    ----------
    unit
        (dimension,) of each coordinate: a radius, or a radian.
    atol, rtol
        Of a step, ``atol`` in radii and radians.
    y
        |y| in the integrator's chart. Modes are in a chart about the poses reached. Their
        components differ by the tangent of the Cayley map: by the turn of a sphere since the chart
        was made, and by nothing in Radau's, which is made anew at every step.
    most
        The largest |y| so far, at any step.
    growth_limit, share
        Those of the integrator: ``atol`` and ``rtol`` over ``share`` are those of the scene.
    """

    unit: np.ndarray
    atol: float
    rtol: float
    y: np.ndarray
    most: np.ndarray
    growth_limit: float
    share: float = 1.0

    @classmethod
    def of(cls, integrator: Integrator, unit: float, y: np.ndarray, most: np.ndarray) -> Resolution:
        """That of an integrator; ``unit`` is its ``atol`` of one radian, and of one radius."""
        return cls(
            integrator.atol / unit,
            unit,
            integrator.rtol,
            np.abs(y),
            most,
            integrator.growth_limit,
            integrator.share,
        )

    def across(self, axis: np.ndarray) -> float:
        """The largest tolerance of a displacement or a turn across the axis, in radii or radians.

        A coordinate along e_k counts by the part √(1 − (e_k·axis)²) of it that is across.
        """
        part = np.sqrt(np.maximum(1.0 - axis**2, 0.0))
        moved = (self.most / self.unit).reshape(-1, 3).max(axis=0, initial=0.0)
        return float((part * (self.atol + self.rtol * moved)).max())

    def over_tolerance(self, parts: np.ndarray, atol: float, rtol: float) -> np.ndarray:
        """s (…) of parts (…, dimension) at these tolerances."""
        scale = atol * self.unit + rtol * self.y
        return np.sqrt(np.mean((parts / scale) ** 2, axis=-1))

    def over_step_errors(self, parts: np.ndarray, atol: float, rtol: float) -> np.ndarray:
        """n (…): parts (…, dimension) over the error that a step may leave along them."""
        sizes, scale = parts / self.unit, atol + rtol * self.most / self.unit
        left = np.sqrt(np.mean((sizes * scale) ** 2, axis=-1))
        return np.mean(sizes**2, axis=-1) / np.maximum(left, TINY)

    def amplitudes(self, parts: np.ndarray) -> np.ndarray:
        """The largest coordinate (K,) of parts (K, dimension), in radii or radians."""
        return (parts / self.unit).max(axis=1, initial=0.0)

    def lost_mode(self, growth: Growth, step: float, left: float, bend: float) -> int | None:
        """The unresolved mode that matters and becomes the largest in the time ``left``; or None.

        Unresolved are modes that step control does not see, in steps that are too long for them;
        and all modes, where not even the largest of them exceeds the errors of steps.
        """
        rates, amplitudes = growth.rates, self.amplitudes(growth.parts)
        sizes = self.over_tolerance(growth.parts, self.atol, self.rtol)
        certain = self.over_step_errors(growth.parts, self.atol, self.rtol)
        with np.errstate(divide="ignore"):
            high, far = np.log(amplitudes), np.log(sizes)
        ready = (math.log(LARGEST) - high) / rates
        until = min(left, max(float(ready.min(initial=left)), 0.0))
        grown = high + rates * until
        matters = (far + rates * until > 0.0) & (amplitudes > ABSENT * bend)
        matters &= grown > math.log(SHARE) + grown.max(initial=-math.inf)
        too_long = (sizes < SEEN) & (step * rates > self.growth_limit)
        lost = matters & (too_long | (certain.max(initial=0.0) < SOLVED))
        return int(np.argmax(np.where(lost, grown, -math.inf))) if lost.any() else None

    def finer_tolerances(self, part: np.ndarray) -> str:
        """Tolerances that resolve this part well, as keys of a scene; empty if there are none.

        ``run.rtol`` is named where it hides, on coordinates as large as these, what ``atol`` shows.
        """
        size = float(self.over_tolerance(part, 1.0, 0.0))
        atol = min(self.atol, max(size / BARELY, LEAST_ATOL))
        if size < SEEN * atol:
            return ""
        finer = [f"run.atol = {atol / self.share:.1g}"] if atol < self.atol else []
        share = float(self.over_tolerance(part, atol, self.rtol)) * atol / size
        share = min(share, float(self.over_step_errors(part, atol, self.rtol)))
        if share < 0.5:
            finer.append(f"run.rtol = {max(share * self.rtol / self.share, LEAST_RTOL):.1g}")
        return " and ".join(finer)
