"""X(s), p(s): the states of one branch, with their stability and the points where it changes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nrchain.notebook import record_html
from nrchain.scene.scene import Scene
from nrchain.states.branches.curve import Direction
from nrchain.states.branches.events import Event
from nrchain.states.branches.follow import Place
from nrchain.states.branches.steady import Steady
from nrchain.states.state import State, find_state
from nrchain.states.varied import Line
from nrchain.types import Poses
from nrchain.wording import brief

LEADING = 8
"""Rates that are kept of every state."""


COLUMNS = (
    "values",
    "positions",
    "frames",
    "velocity",
    "rotation",
    "turn",
    "rates",
    "unstable",
    "errors",
    "steps",
    "lengths",
)
"""What a branch has of every state."""


@dataclass(frozen=True)
class SpecialPoint:
    """Where the stability of a branch changes, or where it turns back.

    Attributes
    ----------
    kind
        "fold"; "pitchfork" or "transcritical", where other branches cross, or "branch point" where
        rounding hides which of the two; or "Hopf", where an oscillation sets in.
    value, error
        p, and an estimate of its error.
    frequency
        |Im Λ| of a Hopf point, in rad per unit time; 0 for the others.
    multiplicity
        How many rates, or pairs of a Hopf point, cross at once; 2 where rotations about x leave
        the branch as it is.
    index
        It lies between the states ``index`` and ``index + 1`` of its branch.
    positions, frames
        (N, 3) and (N, 3, 3): the state next to it.

    >>> from nrchain import continue_state, load_scene
    >>> scene = load_scene("buckling", **{"chain.particles": 8, "elasticity.ratio": 1e8})
    >>> point = continue_state(scene, {"slip.2s": (0.0, 500.0)}, branches=1).special[0]
    >>> point.kind, point.multiplicity
    ('pitchfork', 2)
    """

    kind: str
    value: float
    error: float
    frequency: float
    multiplicity: int
    index: int
    positions: np.ndarray
    frames: np.ndarray

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def poses(self) -> Poses:
        """Positions and frames."""
        return self.positions, self.frames


@dataclass(frozen=True)
class StateBranch:
    """States of rest and of steady motion along a line of scenes, in order of the arclength.

    Attributes
    ----------
    line
        The scene and the ranges of its keys.
    values
        (m,) p: the first key.
    positions, frames
        (m, N, 3) and (m, N, 3, 3).
    velocity, rotation, turn
        (m, 3), (m, 3) and (m,): the motion as a whole, as in :class:`~nrchain.State`.
    rates
        (m, k): the leading rates Λ, from the largest real part on, without neutral ones.
    unstable
        (m,): how many rates have a positive real part.
    errors, steps
        (m,): the last correction of Newton's method, in lengths and radians, and its steps.
    lengths
        (m,): arclength from the state before.
    special
        Points where the stability changes.
    reason
        Why the branch ends; empty while it is followed.
    parent
        The branch and the special point of it from which this one leaves; None for the first.
    leaves
        The direction in which it goes on from its last state.

    >>> from nrchain import continue_state, load_scene
    >>> scene = load_scene("buckling", **{"chain.particles": 8, "elasticity.ratio": 1e8})
    >>> (straight,) = continue_state(scene, {"slip.2s": (0.0, 500.0)}, branches=1).branches
    >>> len(straight.values) == len(straight.unstable)
    True
    """

    line: Line
    values: np.ndarray
    positions: np.ndarray
    frames: np.ndarray = field(repr=False)
    velocity: np.ndarray
    rotation: np.ndarray
    turn: np.ndarray = field(repr=False)
    rates: np.ndarray
    unstable: np.ndarray
    errors: np.ndarray = field(repr=False)
    steps: np.ndarray = field(repr=False)
    lengths: np.ndarray = field(repr=False)
    special: tuple[SpecialPoint, ...]
    reason: str
    parent: tuple[int, int] | None
    leaves: Direction = field(repr=False)

    __repr__ = brief
    _repr_html_ = record_html

    def __len__(self) -> int:
        return len(self.values)

    @property
    def is_stable(self) -> np.ndarray:
        """(m,): whether no rate has a positive real part."""
        return self.unstable == 0

    @property
    def amplitude(self) -> np.ndarray:
        """(m,): the largest distance of a sphere from the line; see :func:`distance_from_line`."""
        return np.array([distance_from_line(self.line.scene, one) for one in self.positions])

    @property
    def speed(self) -> np.ndarray:
        """(m,): |V|."""
        return np.linalg.norm(self.velocity, axis=1)

    def state(self, index: int) -> State:
        """A state of the branch with its spectrum."""
        poses = self.positions[index], self.frames[index]
        return find_state(self.line.at(self.values[index]), poses)


def distance_from_line(scene: Scene, positions: np.ndarray) -> float:
    """The largest distance of a sphere from the line through the clamps, or along x, or fitted.

    Clamped chains: the line through the held spheres. Periodic ones: parallel to x through the
    centre. Free ones: the principal axis of the positions.
    """
    centre, axis = positions.mean(axis=0), np.array([1.0, 0.0, 0.0])
    if scene.chain.ends == "clamped":
        centre = positions[0]
        axis = positions[-1] - positions[0]
        axis = axis / np.linalg.norm(axis)
    elif scene.chain.ends == "free":
        axis = np.linalg.svd(positions - centre, full_matrices=False)[2][0]
    away = positions - centre
    return float(np.linalg.norm(away - np.outer(away @ axis, axis), axis=1).max())


class Record:
    """A branch that grows from its first place, or from what there is of it."""

    def __init__(
        self,
        line: Line,
        parent: tuple[int, int] | None,
        places: list[Place[Steady]],
        before: StateBranch | None = None,
    ) -> None:
        self._line, self._parent, self._before = line, parent, before
        self._places = places
        self._special = [] if before is None else list(before.special)

    def add(self, place: Place[Steady], events: list[Event[Steady]]) -> None:
        """The next place, with the events on the way to it."""
        index = len(self._places) - 1 + (0 if self._before is None else len(self._before))
        for event in events:
            self._special.append(
                SpecialPoint(
                    event.kind,
                    event.value,
                    event.error,
                    event.frequency,
                    event.multiplicity,
                    index,
                    *event.place.solution.point.poses,
                )
            )
        self._places.append(place)

    def branch(self, reason: str) -> StateBranch:
        """The branch so far."""
        columns = {name: [row[name] for row in map(_row, self._places)] for name in COLUMNS}
        if self._before is not None:
            columns = {name: [*getattr(self._before, name), *columns[name]] for name in COLUMNS}
            last = self._before.leaves
        if self._places:
            last = self._places[-1].tangent
        return StateBranch(
            line=self._line,
            **{name: np.array(column) for name, column in columns.items()},
            special=tuple(self._special),
            reason=reason,
            parent=self._parent,
            leaves=last,
        )


def _row(place: Place[Steady]) -> dict[str, Any]:
    """What a branch keeps of a place."""
    point = place.solution.point
    return {
        "values": place.solution.value,
        "positions": point.positions,
        "frames": point.frames,
        "velocity": point.motion.velocity,
        "rotation": point.motion.rotation,
        "turn": point.motion.turn,
        "rates": place.exponents[:LEADING],
        "unstable": place.unstable,
        "errors": place.error,
        "steps": place.steps,
        "lengths": place.length,
    }
