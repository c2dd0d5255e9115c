"""What does accuracy cost in time, and which choice is the cheapest at a given error?

Error against processor time along four axes: the stepping (integrator and tolerances), the reach of
the slip, the hydrodynamic model, and the resolution of a wave. Every axis has its own reference of
much smaller error: a run of Radau IIA at 1e-12, all pairs, the resolved spheres, the continuum law.
Times are medians of interleaved repetitions on the machine of the report; errors do not depend on
the machine.
"""

from __future__ import annotations

from nrchain import rod
from validation.cost import model, reach, resolution, stepping
from validation.report.recorder import Recorder


def study(recorder: Recorder) -> None:
    stepping.compare(recorder)
    reach.compare(recorder)
    model.compare(recorder)
    resolution.compare(recorder)
    left_out = [1.0 - 1.0 / rod.reach_ratio(mode, 0.1) for mode in ("2s", "3a", "3t", "4a")]
    recorder.text(
        "**Choosing.** The errors of the axes add up, and differ by orders of magnitude. The error "
        "of the default tolerances is below 1e-4 of a radius. The pair laws of slip alone are off "
        "by up to 2 % at d = 10a (2s to leading order). One-body friction is off by 12 % at that "
        "distance where elastic forces move the spheres; pairwise friction removes this error. "
        f"Nearest neighbours leave out {min(left_out):.0%} to {max(left_out):.0%} of the active "
        "rates at qd = 0.1. Tolerances below the default make a run reproducible, not more "
        "accurate. `nrchain cost SCENE --target 1e-4` measures the same on your own scene."
    )
