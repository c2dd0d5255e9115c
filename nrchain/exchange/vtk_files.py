"""VTK's XML: a ``.vtp`` for each frame, and a ``.pvd`` that gives their times.

A ``.vtp`` has a point for each sphere, with ``e1``, ``e2``, ``e3`` and ``radius``, and a line for
each link. Numbers are 64-bit, little-endian, in base64. The field ``nrchain`` holds the record as
bytes. The frames of ``x.pvd`` lie in the folder ``x-vtp`` beside it.
"""

from __future__ import annotations

import base64
import re
import struct
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from xml.etree import ElementTree
from xml.sax.saxutils import escape

import numpy as np

from nrchain.errors import TrajectoryError
from nrchain.exchange.record import FramePoses, Record, pick_frame
from nrchain.trajectory.trajectory import Trajectory

TYPES = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1", "Float32": "<f4", "Int32": "<i4"}
"""Names of VTK for types of NumPy."""

VECTORS = ("e1", "e2", "e3")
RECORD, TIME = "nrchain", "TimeValue"
"""Fields of a ``.vtp``; ParaView takes the time from the second."""

_OPENING = (
    '<?xml version="1.0"?>\n<VTKFile type="{}" version="1.0" byte_order="LittleEndian"'
    ' header_type="UInt64">'
)


def write(trajectory: Trajectory, record: Record, path: Path) -> None:
    """Write a ``.pvd`` and a folder of ``.vtp`` files, which replace those of an earlier one."""
    folder = frames_folder(path.with_name(path.name.removesuffix(".partial")))
    folder.mkdir(exist_ok=True)
    try:
        _clear(folder)
        sets = _write_frames(trajectory, record, folder)
        parts = [_OPENING.format("Collection"), "<Collection>", *sets, "</Collection>"]
        path.write_text("\n".join([*parts, "</VTKFile>\n"]), encoding="utf-8")
    except BaseException:
        _clear(folder)
        with suppress(OSError):
            folder.rmdir()
        raise


def _write_frames(trajectory: Trajectory, record: Record, folder: Path) -> list[str]:
    """Write the frames, and return the lines that name them and their times."""
    chain, note = trajectory.scene.chain, np.frombuffer(record.to_json().encode(), np.uint8)
    radii = np.full(chain.particles, chain.radius)
    sets = []
    for k, time in enumerate(trajectory.time.tolist()):
        file = folder / f"{k:06d}.vtp"
        vectors = dict(zip(VECTORS, trajectory.frames[k].swapaxes(0, 1), strict=True))
        fields = {TIME: np.array([time]), RECORD: note}
        poly = _poly_data(trajectory.positions[k], vectors | {"radius": radii}, fields)
        file.write_text(poly, encoding="ascii")
        name = escape(f"{folder.name}/{file.name}", {'"': "&quot;"})
        sets.append(f'<DataSet timestep="{time!r}" part="0" file="{name}"/>')
    return sets


def _clear(folder: Path) -> None:
    """Remove the frames of an earlier export."""
    for old in folder.iterdir():
        if re.fullmatch(r"\d+\.vtp", old.name):
            old.unlink()


def frames_folder(path: Path) -> Path:
    """The folder of the frames of a ``.pvd``."""
    return path.with_name(f"{path.stem}-vtp")


def read_collection(path: Path, index: int) -> FramePoses:
    """Frame ``index`` of a ``.pvd``."""
    sets = ElementTree.parse(path).getroot().findall("Collection/DataSet")
    place = pick_frame(path, index, len(sets))
    found = read_frame(path.parent / sets[place].attrib["file"], 0)
    time = float(sets[place].attrib["timestep"])
    return FramePoses(found.positions, found.frames, place, time, found.record)


def read_frame(path: Path, index: int) -> FramePoses:
    """The one frame of a ``.vtp`` with the vectors ``e1``, ``e2`` and ``e3`` at its points."""
    pick_frame(path, index, 1)
    root = ElementTree.parse(path).getroot()
    piece, wide = root.find("PolyData/Piece"), root.get("header_type", "UInt32") == "UInt64"
    if piece is None or root.get("byte_order") != "LittleEndian" or root.get("compressor"):
        raise TrajectoryError(
            f"{path}: must be poly data, little-endian and not compressed, as nrchain export has it"
        )
    points = piece.find("Points/DataArray")
    vectors = {one.get("Name"): one for one in piece.findall("PointData/DataArray")}
    if points is None or not vectors.keys() >= set(VECTORS):
        raise TrajectoryError(f"{path}: must have points with the vectors {', '.join(VECTORS)}")
    fields = {one.get("Name"): one for one in root.findall("PolyData/FieldData/DataArray")}
    frames = [_numbers(path, vectors[name], wide).reshape(-1, 3) for name in VECTORS]
    record, time = "", None
    if RECORD in fields:
        record = _numbers(path, fields[RECORD], wide).tobytes().decode()
    if TIME in fields:
        time = float(_numbers(path, fields[TIME], wide)[0])
    positions = _numbers(path, points, wide).reshape(-1, 3)
    shown = np.stack(frames, axis=1).astype(float)
    precision = "float32" if points.get("type") == "Float32" else "float64"
    return FramePoses(positions.astype(float), shown, 0, time, Record.from_json(record), precision)


def _poly_data(
    positions: np.ndarray, points: Mapping[str, np.ndarray], fields: Mapping[str, np.ndarray]
) -> str:
    count = len(positions)
    ends = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    return "\n".join(
        [
            _OPENING.format("PolyData"),
            "<PolyData>\n<FieldData>",
            *(_data(name, values, tuples=len(values)) for name, values in fields.items()),
            "</FieldData>",
            f'<Piece NumberOfPoints="{count}" NumberOfLines="{count - 1}" NumberOfVerts="0"'
            ' NumberOfStrips="0" NumberOfPolys="0">',
            f"<PointData>{''.join(_data(name, values) for name, values in points.items())}"
            "</PointData>",
            f"<Points>{_data('Points', positions)}</Points>",
            f"<Lines>{_data('connectivity', ends.ravel())}"
            f"{_data('offsets', 2 * np.arange(1, count))}</Lines>",
            "</Piece>\n</PolyData>\n</VTKFile>\n",
        ]
    )


def _data(name: str, values: np.ndarray, tuples: int | None = None) -> str:
    """An array as XML: the number of its bytes and the bytes, in base64."""
    kind = next(k for k, dtype in TYPES.items() if np.dtype(dtype) == values.dtype)
    content = np.ascontiguousarray(values).tobytes()
    text = base64.b64encode(struct.pack("<Q", len(content)) + content).decode()
    size = f' NumberOfTuples="{tuples}"' if tuples is not None else ""
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    return f'<DataArray type="{kind}" Name="{name}"{width}{size} format="binary">{text}</DataArray>'


def _numbers(path: Path, array: ElementTree.Element, wide: bool) -> np.ndarray:
    """The numbers of an array in base64 or in plain text."""
    kind, text = TYPES.get(array.get("type", "")), (array.text or "").strip()
    if kind is None or array.get("format") not in ("binary", "ascii"):
        raise TrajectoryError(
            f"{path}: {array.get('Name')} must be of type {', '.join(TYPES)}, in the format binary "
            "or ascii"
        )
    if array.get("format") == "ascii":
        return np.array(text.split(), kind)
    content, head = base64.b64decode(text, validate=True), 8 if wide else 4
    if int.from_bytes(content[:head], "little") != len(content) - head:
        raise TrajectoryError(f"{path}: {array.get('Name')} is cut short")
    return np.frombuffer(content[head:], kind)
