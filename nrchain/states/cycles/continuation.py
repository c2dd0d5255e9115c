"""continue_cycle: cycles along a number of the scene, and where they change."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from nrchain.errors import SceneError, TrajectoryError, Words
from nrchain.inputs.rules import number, whole
from nrchain.notebook import table_html
from nrchain.run.folders import new_folder
from nrchain.run.interruption import Interruption, deferred
from nrchain.scene.scene import Scene
from nrchain.states.branches.branch import SpecialPoint
from nrchain.states.branches.curve import Direction
from nrchain.states.branches.events import HOPF, Event, events_between
from nrchain.states.branches.follow import LARGEST, Follower, Limits, Place
from nrchain.states.branches.steady import SteadyCurve
from nrchain.states.cycles.branch import CycleBranch, SpecialCycle
from nrchain.states.cycles.curve import CycleCurve, Round
from nrchain.states.cycles.cycle import MODES, find_cycle
from nrchain.states.cycles.file import read_cycles, write_cycles
from nrchain.states.cycles.hopf import orbits_leaving
from nrchain.states.parameters import parameters
from nrchain.states.spectrum import require_states
from nrchain.states.varied import Line, line
from nrchain.wording import brief

STEPS, INTERVALS = 100, 32
"""Most cycles of a branch either way, and intervals of each."""

DIES_OUT = "the oscillation dies out at a Hopf point"

SMALL = 0.02
"""An amplitude below this, in d, is that of an oscillation that dies out, if steps get small."""


@dataclass(frozen=True)
class CycleDiagram:
    """Branches of cycles along a line of scenes.

    Attributes
    ----------
    line
        The scene and the ranges of its keys.
    branches
        All that leave a Hopf point, or the one through a cycle.
    """

    line: Line
    branches: tuple[CycleBranch, ...]

    __repr__ = brief

    def _repr_html_(self) -> str:
        rows = []
        for place, one in enumerate(self.branches):
            ends = one.values[0], one.values[-1]
            rows.append(
                (
                    str(place),
                    *ends,
                    len(one),
                    int(one.is_stable.sum()),
                    "; ".join(filter(None, one.reasons)),
                )
            )
        key = self.line.key
        heads = ("cycles", f"{key} from", "to", "number", "stable", "ends: why")
        return table_html("Branches of cycles", rows, heads)

    @property
    def special(self) -> tuple[SpecialCycle, ...]:
        """The special points of all branches."""
        return tuple(point for branch in self.branches for point in branch.special)

    @classmethod
    def open(cls, folder: str | Path) -> Self:
        """Read the branches of a folder.

        Raises :class:`~nrchain.errors.TrajectoryError` for a folder without branches, or with a
        damaged one.
        """
        found = [read_cycles(path) for path in sorted(Path(folder).glob("cycles-*.h5"))]
        if not found:
            raise TrajectoryError(f"{folder}: holds no cycles: no file cycles-000.h5")
        return cls(found[0].line, tuple(found))


def continue_cycle(
    scene: Scene,
    along: Any,
    guess: Any,
    *,
    steps: int = STEPS,
    step: float = LARGEST,
    intervals: int = INTERVALS,
    output: str | Path | None = None,
) -> CycleDiagram:
    """Ẋ = w(X, p), X(T) = exp(Tξ) X(0) along p: cycles with their stability.

    Parameters
    ----------
    scene
        Any ends and effects, without ``effects = "auto"``.
    along
        The ends of a key, ``{"slip.3t": (0, 1000)}``, or of several that vary together, as for
        :func:`~nrchain.continue_state`.
    guess
        A cycle or a trajectory of this scene, which is on the line: one branch goes through it
        both ways. Or a Hopf point of :func:`~nrchain.continue_state`: all branches that leave it,
        one of each set of mirror images.
    steps, step
        Most cycles of a branch either way, and the largest arclength from one to the next:
        displacements are measured in d, p in its range.
    intervals
        Intervals of a period.
    output
        Folder for one file a branch, which :meth:`CycleDiagram.open` reads. Files of the same names
        are replaced.

    Raises
    ------
    SceneError
        For a key on which motion does not depend, a guess that leads to no cycle, and a scene that
        is not on the line.
    KeyboardInterrupt
        On Ctrl-C and SIGTERM, once the cycle under way is found and its branch is written.

    >>> from nrchain import continue_state, load_scene
    >>> changes = {"chain.particles": 12, "slip.2s": 200.0, "slip.3t": 4000.0}
    >>> scene = load_scene("buckling", **changes, **{"elasticity.ratio": 1e8})
    >>> along = {"slip.3t": (4000.0, 4500.0)}
    >>> onset = continue_state(scene, along, branches=1).special[-1]
    >>> found = continue_cycle(scene, along, onset, steps=1, intervals=8)
    >>> [bool(branch.is_stable[-1]) for branch in found.branches]
    [False, True]
    """
    require_states(scene)
    whole(least=1)("steps", steps)
    whole(least=2)("intervals", intervals)
    number(above=0.0)("step", step)
    limits = line(scene, along)
    curve = CycleCurve(limits, np.full(intervals, 1.0 / intervals))
    bounds = Limits(min(limits.low, limits.high), max(limits.low, limits.high), steps, step)
    folder = None if output is None else Path(output)
    found: list[CycleBranch] = []
    with (
        np.errstate(all="ignore"),
        new_folder(folder) if folder else nullcontext(),
        deferred() as interruption,
    ):
        for start, ways in _starts(curve, guess):
            if interruption.name:
                break
            found.append(_branch(curve, bounds, start, ways, interruption))
            if folder:
                write_cycles(folder / f"cycles-{len(found) - 1:03}.h5", found[-1])
    return CycleDiagram(limits, tuple(found))


def _starts(curve: CycleCurve, guess: Any) -> list[tuple[Round, list[Direction]]]:
    """The first cycle of every branch, with the directions in which it is followed."""
    if isinstance(guess, SpecialPoint):
        return [(start, [ahead]) for start, ahead in _from_hopf(curve, guess)]
    return [_from_cycle(curve, guess)]


def _from_hopf(curve: CycleCurve, point: SpecialPoint) -> list[tuple[Round, Direction]]:
    """The first cycles of the branches that leave a Hopf point."""
    if point.kind != HOPF:
        raise SceneError("guess", point.kind, "must be a Hopf point, a cycle or a trajectory")
    state = SteadyCurve(curve.line).at(point.poses, point.value)
    found = orbits_leaving(curve, state, point.frequency, point.multiplicity)
    if not found:
        raise SceneError("guess", Words("the Hopf point"), "has no cycle that is found next to it")
    return found


def _from_cycle(curve: CycleCurve, guess: Any) -> tuple[Round, list[Direction]]:
    """The cycle of a guess, and the directions both ways."""
    limits = curve.line
    found = find_cycle(limits.scene, guess, modes=1)
    given = {one.key: one.value for one in parameters(limits.scene)}
    value = given.get(limits.key, limits.low)
    if not limits.holds(value) or limits.at(value).to_mapping() != limits.scene.to_mapping():
        raise SceneError("guess", limits.key, "must have a value on the line in the scene")
    near = curve.at(found.orbit, found.origin, value)
    still = Direction(np.zeros(near.system.defects.size + near.condensed.numbers - 1), 1.0)
    start = curve.corrected(near, still).solution
    return start, [still, still.times(-1.0)]


def _branch(
    curve: CycleCurve,
    bounds: Limits,
    start: Round,
    ways: list[Direction],
    interruption: Interruption,
) -> CycleBranch:
    """The branch from a cycle, both ways or one."""
    places: list[Place[Round]] = []
    special: list[SpecialCycle] = []
    reasons = [DIES_OUT, DIES_OUT]
    for turn, ahead in enumerate(ways):
        follower = Follower(curve, bounds)
        try:
            begin = follower.place(start, ahead)
        except (FloatingPointError, np.linalg.LinAlgError) as error:
            value = f"{curve.line.key} = {start.value:.6g}"
            allowed = f"is no place from which cycles can be followed: {error}"
            raise SceneError("along", value, allowed) from None
        reached, events, reason = _followed(curve, follower, begin, interruption)
        if turn:
            # the second way leads to the beginning of the branch
            count = len(reached)
            special = [_moved(one, count) for one in special]
            special += [_special(one, count - 1 - index) for index, one in events]
            places = [*reached[::-1], *places]
            reasons[0] = reason
        else:
            places = [begin, *reached]
            special = [_special(one, index) for index, one in events]
            reasons[1] = reason
    return _record(curve, places, sorted(special, key=lambda one: one.index), reasons)


def _followed(
    curve: CycleCurve,
    follower: Follower[Round],
    begin: Place[Round],
    interruption: Interruption,
) -> tuple[list[Place[Round]], list[tuple[int, Event[Round]]], str]:
    """The places after the first, the events between them, and why they end."""
    place = begin
    places: list[Place[Round]] = []
    events: list[tuple[int, Event[Round]]] = []
    for reached in follower.places(begin):
        before, after = place.solution.orbit.excursions, reached.solution.orbit.excursions
        if np.vdot(before, after) <= 0.0:
            return places, events, DIES_OUT
        found = events_between(follower, place, reached)
        events += [(len(places), one) for one in found]
        places.append(reached)
        place = reached
        if interruption.name:
            return places, events, "it was interrupted"
    small = SMALL * curve.line.scene.chain.spacing
    dies = place.solution.orbit.amplitude <= small and "small" in follower.reason
    return places, events, DIES_OUT if dies else follower.reason


def _special(event: Event[Round], index: int) -> SpecialCycle:
    """What a branch keeps of an event."""
    orbit = event.place.solution.orbit
    return SpecialCycle(
        event.kind,
        event.value,
        event.error,
        event.frequency * orbit.period,
        event.multiplicity,
        index,
        orbit,
    )


def _moved(special: SpecialCycle, count: int) -> SpecialCycle:
    """A special point after so many further cycles."""
    return replace(special, index=special.index + count)


def _record(
    curve: CycleCurve,
    places: list[Place[Round]],
    special: list[SpecialCycle],
    reasons: list[str],
) -> CycleBranch:
    """The branch of these places."""
    solutions = [place.solution for place in places]
    periods = np.array([one.orbit.period for one in solutions])
    exponents = np.array([place.exponents[:MODES] for place in places])
    return CycleBranch(
        line=curve.line,
        values=np.array([one.value for one in solutions]),
        periods=periods,
        amplitudes=np.array([one.orbit.amplitude for one in solutions]),
        multipliers=np.exp(exponents * periods[:, None]),
        unstable=np.array([place.unstable for place in places]),
        errors=np.array([curve.noise(one) for one in solutions]) * periods,
        special=tuple(special),
        reasons=(reasons[0], reasons[1]),
        origin=solutions[0].origin,
        orbits=tuple(one.orbit for one in solutions),
    )
