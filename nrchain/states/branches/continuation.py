"""continue_state: the branch of a state along a number of the scene, and those that leave it."""

from __future__ import annotations

import hashlib
import time as clock
from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from nrchain.errors import SceneError, TrajectoryError
from nrchain.inputs.rules import number, whole
from nrchain.notebook import table_html
from nrchain.progress import Shown, updates
from nrchain.run.folders import new_folder
from nrchain.run.interruption import Interruption, deferred
from nrchain.scene.scene import Scene
from nrchain.states.branches.branch import Record, SpecialPoint, StateBranch, distance_from_line
from nrchain.states.branches.curve import Direction
from nrchain.states.branches.events import FOLD, HOPF, Event, events_between, turns_back
from nrchain.states.branches.file import read_branch, write_branch
from nrchain.states.branches.follow import LARGEST, Follower, Limits, Place
from nrchain.states.branches.steady import Steady, SteadyCurve
from nrchain.states.branches.switching import Start, leaving
from nrchain.states.parameters import parameters
from nrchain.states.search import given_poses
from nrchain.states.spectrum import require_states
from nrchain.states.state import find_state
from nrchain.states.varied import Line, line
from nrchain.types import Poses
from nrchain.wording import brief

BRANCHES, STEPS = 8, 400
"""Most branches, and most states of each."""

SAVE = 1.0
"""Seconds between two writes of a branch that grows."""

MEETS = "it meets a branch of higher symmetry, beyond which its image follows"

NEAR, ALIKE = 1e-3, 0.1
"""Branch points are compared if they are nearer than this part of the range, and are one if the
branches there differ by less than this fraction."""


@dataclass(frozen=True)
class BranchDiagram:
    """Branches of states along a line of scenes.

    Attributes
    ----------
    line
        The scene and the ranges of its keys.
    branches
        The first one begins at the state of the guess; each of the others leaves one before it.

    >>> from nrchain import continue_state, load_scene
    >>> scene = load_scene("buckling", **{"chain.particles": 8, "elasticity.ratio": 1e8})
    >>> len(continue_state(scene, {"slip.2s": (0.0, 500.0)}, branches=1).branches)
    1
    """

    line: Line
    branches: tuple[StateBranch, ...]

    __repr__ = brief

    def _repr_html_(self) -> str:
        rows = []
        for place, one in enumerate(self.branches):
            ends = one.values[0], one.values[-1]
            rows.append((str(place), *ends, len(one), int(one.is_stable.sum()), one.reason))
        key = self.line.key
        heads = ("branch", f"{key} from", "to", "states", "stable", "ends: why")
        return table_html("Branches of states", rows, heads)

    @property
    def special(self) -> tuple[SpecialPoint, ...]:
        """The special points of all branches."""
        return tuple(point for branch in self.branches for point in branch.special)

    @classmethod
    def open(cls, folder: str | Path) -> Self:
        """Read the branches of a folder.

        Raises :class:`~nrchain.errors.TrajectoryError` for a folder without branches, or with a
        damaged one.
        """
        found = [read_branch(path)[0] for path in _files(Path(folder))]
        if not found:
            raise TrajectoryError(f"{folder}: holds no branch: no file branch-000.h5")
        return cls(found[0].line, tuple(found))


def continue_state(
    scene: Scene,
    along: Mapping[str, tuple[float, float]],
    guess: Any = None,
    *,
    nudge: float = 0.0,
    branches: int = BRANCHES,
    steps: int = STEPS,
    step: float = LARGEST,
    output: str | Path | None = None,
    progress: bool | Callable[[StateBranch], None] | None = None,
) -> BranchDiagram:
    """G(X, p) = 0 along p: states with their stability, and the branches that leave them.

    Steps have a given arclength ds² = Σ_i (|du_i|² + ρ² |dφ_i|²)/(N d²) + dp²/(p₁ − p₀)², with p₀
    and p₁ the ends of the range: folds are passed. Where a rate crosses zero, the branches that
    leave are followed, one of each set that a symmetry maps to each other. At a Hopf point of a
    straight chain of isotropic measure, shapes that go round steadily leave, and are followed as
    states.

    Parameters
    ----------
    scene
        Any ends and effects that allow a state, without ``effects = "auto"``.
    along
        The ends of a key, ``{"slip.2s": (0, 150)}``, or of several, which vary together along a
        line. Points on the line are named by the first key.
    guess, nudge
        As for :func:`~nrchain.find_state`, at the beginning of the line. If a guess is given and
        the key has a value within its range in the scene, the branch begins at this value and is
        followed both ways, as two branches.
    branches
        Most branches that are followed.
    steps, step
        Most states of a branch, and the largest arclength from one to the next.
    output
        Folder for one file a branch, which is written as it grows. If it holds branches of the same
        request, they are continued.
    progress
        True shows a bar in a terminal or a notebook, on standard error. A function is called with
        the branch after every state.

    Raises
    ------
    SceneError
        For a key on which motion does not depend, ends at which the scene is refused, a guess that
        leads to no state, and a beginning at which the direction of the branch is undetermined.
    TrajectoryError
        For a folder with the branches of another request.
    KeyboardInterrupt
        On Ctrl-C and SIGTERM, once the state under way is found and written.

    >>> from nrchain import load_scene
    >>> scene = load_scene("buckling", **{"chain.particles": 8})
    >>> found = continue_state(scene, {"slip.2s": (0.0, 600.0)}, branches=1)
    >>> [point.kind for point in found.special][:1]
    ['pitchfork']
    """
    require_states(scene)
    whole(least=1)("branches", branches)
    whole(least=1)("steps", steps)
    number(above=0.0)("step", step)
    number()("nudge", nudge)
    limits = line(scene, along)
    request = {
        "nudge": float(nudge),
        "steps": steps,
        "step": float(step),
        "guess": "" if guess is None else _digest(given_poses(scene, guess, "guess")),
    }
    folder = None if output is None else Path(output)
    known = [] if folder is None else _known(folder, limits, request)
    with (
        np.errstate(all="ignore"),
        new_folder(folder) if folder else nullcontext(),
        updates(progress, _shown) as update,
        deferred() as interruption,
    ):
        driver = _Driver(limits, folder, request, interruption, update)
        return driver.run(_starts(driver.curve, guess, nudge), branches, known)


def _shown(branch: StateBranch) -> Shown:
    """What the bar shows of a branch that grows: where it is, and how many states it has."""
    text = f"{branch.line.key} = {branch.values[-1]:.6g}"
    return Shown(len(branch), None, text, f"{len(branch)} states")


class _Begin(NamedTuple):
    """Where a branch begins, and the special point that it leaves, with its place on its branch."""

    solution: Steady
    direction: Direction
    parent: tuple[int, int] | None = None
    special: SpecialPoint | None = None


def _starts(curve: SteadyCurve, guess: Any, nudge: float) -> list[_Begin]:
    """The first state, with the directions in which it is followed."""
    limits = curve.line
    value, inside = limits.low, False
    own = _value(limits)
    if guess is not None and own is not None and limits.holds(own):
        value, inside = own, own not in (limits.low, limits.high)
    found = find_state(limits.at(value), guess, nudge=nudge)
    solution = curve.at(found.poses, value)
    still = np.zeros(solution.point.chain.dimension)
    ways = (1.0, -1.0) if inside else (1.0 if value == limits.low else -1.0,)
    sense = np.sign(limits.high - limits.low)
    return [_Begin(solution, Direction(still, way * sense)) for way in ways]


def _value(limits: Line) -> float | None:
    """The value of the first key in the scene, if the scene lies on the line."""
    given = {one.key: one.value for one in parameters(limits.scene)}
    own = given.get(limits.key)
    if own is None:
        return None
    wanted = limits.values(own)
    on_line = all(
        abs(given.get(key, np.inf) - wanted[key]) <= 1e-9 * abs(wanted[key]) for key in wanted
    )
    return own if on_line else None


class _Driver:
    """Follows branches one after the other, those that leave the first ones first."""

    def __init__(
        self,
        limits: Line,
        folder: Path | None,
        request: dict[str, Any],
        interruption: Interruption,
        progress: Callable[[StateBranch], None] | None,
    ) -> None:
        self.curve = SteadyCurve(limits)
        self._folder, self._request = folder, request
        self._interruption, self._progress = interruption, progress
        self._limits = Limits(
            min(limits.low, limits.high),
            max(limits.low, limits.high),
            request["steps"],
            request["step"],
        )
        self._written = 0.0

    def run(self, starts: list[_Begin], most: int, known: list[StateBranch]) -> BranchDiagram:
        """All branches, up to a number."""
        found: list[StateBranch] = []
        for begin in self._begins(starts, found):
            before = known[len(found)] if len(found) < len(known) else None
            if before is None or not before.reason:
                before = self._follow(begin, len(found), before)
            found.append(before)
            # what leaves further special points takes long to find, and is not looked for
            if len(found) == most or self._interruption.name:
                break
        return BranchDiagram(self.curve.line, tuple(found))

    def _begins(self, starts: list[_Begin], found: list[StateBranch]) -> Iterator[_Begin]:
        """Where branches begin: the given starts, then what leaves each branch that was found."""
        yield from starts
        index = 0
        while index < len(found):
            for place, special in enumerate(found[index].special):
                for start in self._leaving(special):
                    if not any(_ends_there(branch, special, start) for branch in found):
                        yield _Begin(start.solution, start.direction, (index, place), special)
            index += 1

    def _leaving(self, special: SpecialPoint) -> list[Start]:
        if special.kind == FOLD:
            return []
        try:
            return leaving(self.curve, self._event(special))
        except (FloatingPointError, np.linalg.LinAlgError):
            # rounding hides the modes that cross: nothing is found that leaves
            return []

    def _event(self, special: SpecialPoint) -> Event[Steady]:
        """A special point as an event: with the solution next to it."""
        solution = self.curve.at(special.poses, special.value)
        still = Direction(np.zeros(solution.point.chain.dimension), 1.0)
        exponents = self.curve.exponents(solution)
        place = Place(solution, still, exponents, 0, 0.0, 0, 0.0)
        given = (special.error, special.frequency, special.multiplicity)
        return Event(special.kind, special.value, *given, 0.0, place)

    def _follow(self, begin: _Begin, index: int, before: StateBranch | None) -> StateBranch:
        """A branch to its end, or to an interruption."""
        done = 0 if before is None else len(before) - 1
        follower = Follower(self.curve, replace(self._limits, steps=self._limits.steps - done))
        if before is None:
            place = self._first(follower, begin)
            record = Record(self.curve.line, begin.parent, [*self._root(begin, place), place])
        else:
            solution = self.curve.at((before.positions[-1], before.frames[-1]), before.values[-1])
            place = follower.place(solution, before.leaves)
            record = Record(self.curve.line, begin.parent, [], before)
        reason = ""
        for reached in follower.places(place):
            events = events_between(follower, place, reached)
            record.add(reached, events)
            if any(turns_back(event, place, reached) for event in events):
                reason = MEETS
                break
            place = reached
            self._report(record, index)
            if self._interruption.name:
                break
        else:
            reason = follower.reason
        branch = record.branch(reason)
        self._write(branch, index)
        return branch

    def _first(self, follower: Follower[Steady], begin: _Begin) -> Place[Steady]:
        """The first place of a branch, whose direction must be determined."""
        try:
            return follower.place(begin.solution, begin.direction)
        except (FloatingPointError, np.linalg.LinAlgError) as error:
            value = f"{self.curve.line.key} = {begin.solution.value:.6g}"
            allowed = f"is no place from which a branch can be followed: {error}"
            raise SceneError("along", value, allowed) from None

    def _root(self, begin: _Begin, place: Place[Steady]) -> list[Place[Steady]]:
        """The special point that a branch leaves; it counts as stable as the branch is there."""
        if begin.special is None or begin.special.kind == HOPF:
            # a shape that goes round has a rotation also where its amplitude vanishes
            return []
        solution = self.curve.at(begin.special.poses, begin.special.value)
        return [replace(place, solution=solution, exponents=self.curve.exponents(solution))]

    def _report(self, record: Record, index: int) -> None:
        """Show a branch, and write it from time to time."""
        due = clock.monotonic() >= self._written + SAVE
        if not (due or self._progress):
            return
        branch = record.branch("")
        if self._progress:
            self._progress(branch)
        if due:
            self._write(branch, index)

    def _write(self, branch: StateBranch, index: int) -> None:
        if self._folder:
            write_branch(self._folder / f"branch-{index:03}.h5", branch, self._request)
        self._written = clock.monotonic()


def _ends_there(branch: StateBranch, special: SpecialPoint, start: Start) -> bool:
    """Whether a branch arrives at this pitchfork along the branch that would leave it.

    Near a pitchfork p − p* and the rates are linear in the square of the amplitude.
    """
    if branch.reason != MEETS:
        return False
    meets, limits = branch.special[-1], branch.line
    if abs(meets.value - special.value) > NEAR * limits.length:
        return False
    amplitude = branch.amplitude**2
    own = distance_from_line(limits.scene, start.solution.point.positions) ** 2
    last = meets.index + 1
    order = np.argsort(amplitude[:last])
    value = np.interp(own, amplitude[:last][order], branch.values[:last][order])
    away = start.solution.value - special.value
    return bool(abs(value - start.solution.value) <= ALIKE * abs(away))


def _digest(poses: Poses) -> str:
    """What tells the poses of one guess from those of another."""
    return hashlib.sha256(b"".join(np.ascontiguousarray(p).tobytes() for p in poses)).hexdigest()


def _files(folder: Path) -> list[Path]:
    return sorted(folder.glob("branch-*.h5"))


def _known(folder: Path, limits: Line, request: dict[str, Any]) -> list[StateBranch]:
    """The branches of the same request in a folder."""
    found = []
    for path in _files(folder):
        branch, asked = read_branch(path)
        mine = limits.scene.to_mapping(), dict(limits.ranges), request
        theirs = branch.line.scene.to_mapping(), dict(branch.line.ranges), asked
        for name, one, other in zip(("scene", "range", "request"), mine, theirs, strict=True):
            if one != other:
                raise TrajectoryError(
                    f"{path}: holds a branch of another {name}; choose another folder"
                )
        found.append(branch)
    return found
