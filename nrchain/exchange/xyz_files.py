"""Extended XYZ: one line a sphere, with the columns that OVITO knows by name.

``species``, ``pos``, ``orientation`` and ``radius``. OVITO takes quaternions with the scalar last,
(x, y, z, w). Numbers have all their digits. Positions of a periodic chain are unwrapped, and
``Lattice`` has its period along x.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np

from nrchain.errors import TrajectoryError
from nrchain.exchange.record import FramePoses, Record, pick_frame, turned_frames
from nrchain.geometry.quaternions import quaternions_of
from nrchain.trajectory.trajectory import Trajectory

PROPERTIES = "species:S:1:pos:R:3:orientation:R:4:radius:R:1"

SPECIES = "X"
"""The species of a sphere: the symbol for no element."""

_PAIR = re.compile(r'(\w+)=(?:"([^"]*)"|(\S+))')


def write(trajectory: Trajectory, record: Record, path: Path) -> None:
    """Write an extended XYZ file; the comment of the first frame holds the record."""
    radius = repr(trajectory.scene.chain.radius)
    orientations = np.roll(quaternions_of(trajectory.frames), -1, axis=-1)
    rows = np.concatenate([trajectory.positions, orientations], axis=-1)
    cell = _cell(trajectory)
    with path.open("w", encoding="ascii", newline="\n") as file:
        for k, time in enumerate(trajectory.time.tolist()):
            note = f' nrchain="{record.unquoted()}"' if k == 0 else ""
            file.write(f"{trajectory.scene.chain.particles}\n")
            file.write(f"{cell} Properties={PROPERTIES} Time={time!r}{note}\n")
            for row in rows[k].tolist():
                file.write(f"{SPECIES} {' '.join(map(repr, row))} {radius}\n")


def read(path: Path, index: int) -> FramePoses:
    """Frame ``index`` of an extended XYZ file with positions and orientations."""
    with path.open(encoding="utf-8") as file:
        comments, places = [], []
        for comment, place in _frames(file):
            comments.append(comment)
            places.append(place)
        place = pick_frame(path, index, len(places))
        file.seek(places[place])
        count = int(file.readline())
        keys = _keys(file.readline())
        table = [line.split() for line in islice(file, count)]
    columns = _columns(keys.get("Properties", ""))
    missing = {"pos": 3, "orientation": 4}.items() - {
        n: e - b for n, (b, e) in columns.items()
    }.items()
    if missing:
        raise TrajectoryError(
            f"{path}: its Properties must have pos:R:3 and orientation:R:4, the quaternion "
            "(x, y, z, w) of each sphere"
        )
    positions, turned = (
        np.array([line[slice(*columns[name])] for line in table], float)
        for name in ("pos", "orientation")
    )
    time = keys.get("Time")
    return FramePoses(
        positions,
        turned_frames(path, np.roll(turned, 1, axis=-1)),
        place,
        None if time is None else float(time),
        Record.from_unquoted(_keys(comments[0]).get("nrchain", "")),
    )


def _cell(trajectory: Trajectory) -> str:
    if trajectory.scene.chain.ends != "periodic":
        return 'pbc="F F F"'
    reach = np.abs(trajectory.positions[..., 1:]).max() + trajectory.scene.chain.radius
    across = float(2.0 * reach)
    edges = np.diag([trajectory.scene.period, across, across]).ravel().tolist()
    numbers = (" ".join(map(repr, of)) for of in (edges, [0.0, -across / 2, -across / 2]))
    return 'Lattice="{}" Origin="{}" pbc="T F F"'.format(*numbers)


def _frames(file: TextIO) -> Iterator[tuple[str, int]]:
    """The comment of each frame, and where the frame begins."""
    place = file.tell()
    while (line := file.readline()).strip():
        count = int(line)
        comment = file.readline()
        for _ in range(count):
            if not file.readline():
                return
        yield comment, place
        place = file.tell()


def _keys(comment: str) -> dict[str, str]:
    return {name: quoted or plain for name, quoted, plain in _PAIR.findall(comment)}


def _columns(properties: str) -> dict[str, tuple[int, int]]:
    """The first column of each property, and that after its last."""
    parts, found, begin = properties.split(":"), {}, 0
    for name, _, width in zip(parts[::3], parts[1::3], parts[2::3], strict=False):
        found[name] = begin, begin + int(width)
        begin += int(width)
    return found
