"""What a run started from, step by step, back to the first run: kept in every file.

A run from the frame of another file has a step for that frame, after the steps of that file. An
exported file has a step for the run it was made from. A run that was extended has a step for the
end it had before.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np

from nrchain.errors import shorten
from nrchain.scene.scene import Scene
from nrchain.trajectory.file import FILE_NAME
from nrchain.version import __version__

How = Literal["started", "exported", "extended"]

DIGITS = 16
"""Hexadecimal digits of a hash: half of these collide among billions of runs."""

SHOWN = 14
"""Characters of a path in :attr:`Provenance.line`."""


@dataclass(frozen=True)
class Step:
    """One step from a file to the next.

    Attributes
    ----------
    how
        ``"started"``: a run began at a frame of the source. ``"exported"``: a file was written from
        the source. ``"extended"``: a run was given a later end.
    source
        The file of the source, as an absolute path; empty for what was in memory only.
    format
        ``"run"`` for a trajectory of nrchain, the ending of an exported file such as ``"gsd"``, or
        ``"arrays"``.
    frame
        Which snapshot of the source, from 0; of an export or extension, the last.
    time
        The time of that snapshot, in the units of the source's scene; None if it is not known.
    scene
        Hash of the source's scene (:func:`scene_hash`); empty if it has none.
    poses
        Hash of the poses (:func:`pose_hash`): of the frame, as read; of an export, of all frames.
    precision
        ``"float64"``, or ``"float32"``: the poses are rounded to that.
    version
        Of the nrchain that took the step.
    """

    how: How
    source: str
    format: str
    frame: int
    time: float | None
    scene: str
    poses: str
    precision: str = "float64"
    version: str = __version__

    def words(self) -> str:
        """The step in a few words."""
        if self.how == "extended":
            return f"extended from t = {self.time:.6g}"
        if self.format == "arrays":
            return "from arrays in memory"
        name = _short(self.source) or "memory"
        if self.how == "exported":
            return f"exported from {name}"
        at = "" if self.time is None else f", t = {self.time:.6g}"
        rounded = f", {self.precision}" if self.precision != "float64" else ""
        return f"from {name}:{self.frame}{at}{rounded}"


@dataclass(frozen=True, repr=False)
class Provenance:
    """The steps that led to a file, the first one first; none for a run of a scene alone."""

    steps: tuple[Step, ...] = ()

    def then(self, step: Step) -> Self:
        """The chain with one more step."""
        return type(self)((*self.steps, step))

    def __bool__(self) -> bool:
        return bool(self.steps)

    @property
    def line(self) -> str:
        """The last step in one line, and how many there were before; empty without steps.

        >>> step = Step("started", "/data/a/trajectory.h5", "run", 9, 4.5, "", "")
        >>> Provenance((step,)).line
        'from a:9, t = 4.5'
        """
        if not self:
            return ""
        *before, last = self.steps
        earlier = f"; {len(before)} earlier step{'s' * (len(before) > 1)}" if before else ""
        return last.words() + earlier

    def to_table(self) -> list[dict[str, Any]]:
        """The steps as plain tables."""
        return [asdict(step) for step in self.steps]

    @classmethod
    def from_table(cls, table: list[dict[str, Any]]) -> Self:
        return cls(tuple(Step(**step) for step in table))

    def to_json(self) -> str:
        return json.dumps(self.to_table())

    @classmethod
    def from_json(cls, text: str) -> Self:
        return cls.from_table(json.loads(text))

    def __repr__(self) -> str:
        return f"<Provenance: {shorten(self.line) if self else 'a scene'}>"


FROM_SCENE = Provenance()
"""A run that started from its scene alone."""


def array_step(positions: np.ndarray, frames: np.ndarray) -> Step:
    """The step of a run that started from arrays."""
    return Step("started", "", "arrays", 0, None, "", pose_hash(positions, frames))


def scene_hash(scene: Scene) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of a scene, written as TOML."""
    return _digest(scene.to_toml().encode())


def pose_hash(positions: np.ndarray, frames: np.ndarray) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of positions and then frames.

    They are taken as little-endian numbers of 64 bits, in C order.
    """
    parts = (np.ascontiguousarray(part, "<f8").tobytes() for part in (positions, frames))
    return _digest(*parts)


def source_name(path: Path | None) -> str:
    """The absolute path of a source, or nothing."""
    return "" if path is None else str(path.absolute())


def _digest(*parts: Any) -> str:
    found = hashlib.sha256()
    for part in parts:
        found.update(part)
    return found.hexdigest()[:DIGITS]


def _short(path: str) -> str:
    """The name of a file, or the folder of a run, cut from the left to :data:`SHOWN`."""
    file = Path(path)
    name = file.parent.name if file.name == FILE_NAME else file.name
    return name if len(name) <= SHOWN else "…" + name[1 - SHOWN :]
