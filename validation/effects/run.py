"""Does a plan predict what an effect does, and does a choice by tolerance meet the tolerance?

Random chains with fixed seeds. Each effect of a chain is dropped, and each effect that it lacks is
added, in a run of its own at tight tolerance. The distance between the ends of the runs is compared
with the estimate of the plan. A difference counts if it exceeds ten times the integrator's error in
the run of the scene at its own tolerance.

Growth rates are compared with those of simulated waves on periodic chains.

Then each scene uses ``effects = "auto"``. Its run is compared with that of the full model, and its
time with that of the cheapest combination of reach, finite size and friction that meets the
tolerance.
"""

from __future__ import annotations

from validation.effects import auto, estimates
from validation.report.recorder import Recorder
from validation.report.threads import one_thread


def study(recorder: Recorder) -> None:
    with one_thread():
        estimates.compare(recorder)
        estimates.compare_growth(recorder)
        auto.compare(recorder)
