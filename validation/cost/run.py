"""What does accuracy cost in time, and which choice is the cheapest at a given error?

Error against processor time along four axes: the stepping (integrator and tolerances), the reach of
the slip, the hydrodynamic model, and the resolution of a wave. Every axis has its own reference of
much smaller error: a run of Radau IIA at 1e-12, all pairs, the resolved spheres, the continuum law.
Times are medians of interleaved repetitions on the machine of the report; errors do not depend on
the machine.
"""

from __future__ import annotations

from validation.cost import model, reach, resolution, stepping
from validation.report.recorder import Recorder


def study(recorder: Recorder) -> None:
    stepping.compare(recorder)
    reach.compare(recorder)
    model.compare(recorder)
    resolution.compare(recorder)
    recorder.text(
        "**Choosing.** The errors of the axes add up, and differ by orders of magnitude. The error "
        "of the default tolerances is below 1e-4 of a radius. The error of the pair laws is below "
        "1 % at d = 10a for slip alone. The error of one-body friction is some 10 % where elastic "
        "forces move the spheres; pairwise friction removes it for a third more time. Nearest "
        "neighbours differ from all pairs by 17 to 73 %. Tolerances below the default make a run "
        "reproducible, not more accurate. `nrchain cost SCENE --target 1e-4` measures the same on "
        "your own scene."
    )
