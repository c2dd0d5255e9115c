"""What does accuracy cost in time, and which choice is the cheapest for a given error?

Error against processor time along the four axes on which accuracy is bought: the stepping
(integrator and tolerances), the reach of the slip, the hydrodynamic model and the resolution of a
wave. Every axis has its own reference, far below all that is measured against it: a run of Radau
IIA at 1e-12, all pairs, the resolved spheres, the continuum law. Times are medians of interleaved
repetitions on the machine that made the report; errors do not depend on it.
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
        "**Choosing.** The errors of the axes add up, and differ by orders of magnitude: the "
        "default tolerances stay below 1e-4 of a radius; the pair laws are within a per cent at "
        "d = 10a for slip alone; one-body friction is some 10 % off wherever elastic forces move "
        "the spheres, which pairwise friction mends for a third more time; nearest neighbours are "
        "17 to 73 % off all pairs. "
        "Tighter tolerances than the default make a run reproducible; they make it no truer. "
        "`nrchain cost SCENE --target 1e-4` measures the same on a scene of one's own."
    )
