"""Error against work: what the accuracy of a scene costs, measured on the scene itself.

Three choices set the accuracy: the stepping (integrator and tolerances), the reach of the flows,
and the hydrodynamic model. :func:`work_precision` runs the scene, or as much of its beginning as a
budget of counted work allows, with many settings of each. The error of a stepping is the distance
from a reference with far tighter tolerances. The error of a reach or a model is the distance from
the same run with everything that the package can simulate. Which runs are made, their errors and
their counts are the same on every machine. :mod:`nrchain.work` defines the times.
"""

from __future__ import annotations

from nrchain.accuracy.cost.results import Advice, Point, WorkPrecision, check_target
from nrchain.accuracy.cost.short_runs import BUDGET, work_precision

__all__ = ["BUDGET", "Advice", "Point", "WorkPrecision", "check_target", "work_precision"]
