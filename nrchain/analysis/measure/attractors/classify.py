"""Which attractor a run has reached, since when, and how sure that is."""

from __future__ import annotations

from nrchain.analysis.measure.attractors.kinds import Attracted, Attractor
from nrchain.analysis.measure.attractors.steady import steady_attractor
from nrchain.analysis.measured_chain import MeasurementError, positions_of, require_trajectory
from nrchain.outcome import Cause
from nrchain.trajectory.trajectory import Trajectory

STOPS = {Cause.TOUCH: Attracted.TOUCHING, Cause.TURN: Attracted.TORN, Cause.CHART: Attracted.TORN}
"""What a chain ends in if it stops for one of these causes."""


def attractor(trajectory: Trajectory) -> Attractor:
    """The kind of attractor at the end of a run, since when, and the numbers that decided.

    A run that stopped because spheres touch, or because a link has turned by a quarter turn, ends
    as "touching" or "torn". Otherwise Newton's method goes from the last snapshot to the next
    state. If no mode of it grows, and the chain is within 0.1 a of it, the run ends in this state:
    ``since`` is the first snapshot from which on all spheres are within 1e-3 a of it, but for
    motions of the chain as a whole, or None if the chain is still farther away. Its kind is
    "straight", "buckled" or "coiled" at rest, "swimming", "spinning" or "rotating shape" if it
    moves by more than a, or turns by more than 1 rad, in the time of the run.

    Raises :class:`~nrchain.analysis.measured_chain.MeasurementError` for a trajectory without
    snapshots.
    """
    positions = positions_of(require_trajectory(trajectory))
    if not len(positions):
        raise MeasurementError("the trajectory has no snapshots")
    if trajectory.cause in STOPS:
        return Attractor(
            STOPS[trajectory.cause], float(trajectory.time[-1]), confidence=trajectory.reason
        )
    steady = steady_attractor(trajectory, positions)
    if steady is not None:
        return steady
    return Attractor(Attracted.UNSETTLED, confidence="no stable state is near the last snapshot")
