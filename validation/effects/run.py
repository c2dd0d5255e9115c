"""Does a plan say what an effect will do, and does a choice by tolerance hold it?

Random chains with fixed seeds. Of each, every effect that it has is dropped and every one that it
has not is added, by runs of their own at tight tolerance; what the ends of these runs are apart is
held against what the plan said before. A difference counts if it is ten times the integrator's own
error in the run of the scene, at the tolerance that the scene asks for.

Growth rates are held against those of waves on periodic chains, simulated and fitted.

Then each scene leaves its hydrodynamics to ``effects = "auto"``: the run is held against that of
the full model, and its time against those of all combinations of reach, finite size and friction,
of which the cheapest that stays within the tolerance is the rival.
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
