"""λ = lim (1/t) ln ‖δ(t)‖/‖δ(0)‖: the largest Lyapunov exponent, from tangents of a trajectory."""

from __future__ import annotations

from nrchain.analysis.measure.line_fit import Estimate, first_snapshot
from nrchain.analysis.measured_chain import MeasurementError, positions_of, require_trajectory
from nrchain.comoving.relative import RelativeChain
from nrchain.comoving.tangents import FEWEST, largest_exponent
from nrchain.trajectory.trajectory import Trajectory


def lyapunov(trajectory: Trajectory, start: float | None = None) -> Estimate:
    """λ with its error, from the snapshots at and after ``start`` (None: all of them).

    Small changes follow the derivative of the model along the snapshots
    (:mod:`nrchain.comoving.tangents`). The first fifth of that time turns them into the direction
    of fastest growth, and does not count. The error joins the scatter of the mean over eight parts
    of the rest, and a third of the difference from λ with every second snapshot left out: snapshots
    must be close enough to follow the motion, some 30 or more in a period.

    Raises :class:`~nrchain.analysis.measured_chain.MeasurementError` for fewer than 40 snapshots,
    and for interactions of all pairs among more than 500 spheres.

    >>> import nrchain
    >>> run = nrchain.simulate(nrchain.load_scene("passive", **{"run.end": 4000.0}))
    >>> decay = nrchain.spectrum(run.scene).leading.growth
    >>> bool(abs(lyapunov(run).value / decay - 1.0) < 0.01)
    True
    """
    time = require_trajectory(trajectory).time
    first = first_snapshot(time, start)
    positions, frames = positions_of(trajectory)[first:], trajectory.frames[first:]
    time = time[first:]
    if len(time) < FEWEST:
        raise MeasurementError(f"{len(time)} snapshots: at least {FEWEST} are needed")
    chain = RelativeChain(trajectory.scene, (positions[0], frames[0]))
    try:
        return Estimate(*largest_exponent(chain, time, positions, frames))
    except (FloatingPointError, ValueError) as error:
        raise MeasurementError(str(error)) from error
