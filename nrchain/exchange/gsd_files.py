"""GSD files with the schema of HOOMD: 32-bit positions, quaternions and a box.

A periodic chain is wrapped into its box along x, with the counts of images that unwrap it. HOOMD
wants a closed box with all spheres in it: in open directions it reaches as far as the chain ever
goes. Particle ``i`` is sphere ``i``, a bond joins neighbours along the chain, and the logged
quantity ``nrchain/time`` is the time of a frame.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nrchain.exchange.record import FramePoses, Record, pick_frame, turned_frames
from nrchain.geometry.quaternions import quaternions_of
from nrchain.inputs.optional import optional
from nrchain.trajectory.trajectory import Trajectory

TIME = "nrchain/time"
"""The logged quantity that is the time of a frame."""

RECORD = "nrchain/record"
"""The chunk of the first frame with the record as bytes. It is not logged: OVITO lists what is."""

SLACK = 1.01
"""The box over the extent of the chain in open directions, so that rounding stays inside."""


def write(trajectory: Trajectory, record: Record, path: Path) -> None:
    """Write a GSD file; every frame has all positions and quaternions."""
    hoomd, chain = _library(), trajectory.scene.chain
    box = _box(trajectory)
    wrapped, images = _wrapped(trajectory.positions, box, chain.ends == "periodic")
    turned = quaternions_of(trajectory.frames).astype(np.float32)
    with hoomd.open(str(path), "w") as file:
        for k, time in enumerate(trajectory.time):
            frame = hoomd.Frame()
            frame.configuration.step = trajectory.indices[k]
            frame.configuration.box = [*box, 0.0, 0.0, 0.0]
            frame.configuration.dimensions = 3
            frame.particles.N = chain.particles
            frame.particles.position, frame.particles.image = wrapped[k], images[k]
            frame.particles.orientation = turned[k]
            frame.particles.types = ["sphere"]
            frame.particles.type_shapes = [{"type": "Sphere", "diameter": 2 * chain.radius}]
            frame.particles.diameter = np.full(chain.particles, 2 * chain.radius, np.float32)
            pairs = _links(chain.particles, chain.ends == "periodic")
            frame.bonds.N, frame.bonds.group, frame.bonds.types = len(pairs), pairs, ["link"]
            frame.log[TIME] = np.array([time])
            if k == 0:
                file.file.write_chunk(RECORD, np.frombuffer(record.to_json().encode(), np.uint8))
            file.append(frame)


def read(path: Path, index: int) -> FramePoses:
    """Frame ``index`` of a GSD file with the schema of HOOMD; images are unwrapped."""
    with _library().open(str(path), "r") as file:
        place = pick_frame(path, index, len(file))
        frame, text = file[place], ""
        if file.file.chunk_exists(frame=0, name=RECORD):
            text = file.file.read_chunk(frame=0, name=RECORD).tobytes().decode()
    box = np.asarray(frame.configuration.box, float)
    positions = np.asarray(frame.particles.position, float)
    images = frame.particles.image
    if images is not None:
        positions = positions + np.asarray(images, float) @ _box_vectors(box)
    time = frame.log.get(TIME)
    return FramePoses(
        positions,
        turned_frames(path, np.asarray(frame.particles.orientation, float)),
        place,
        None if time is None else float(time[0]),
        Record.from_json(text),
        "float32",
    )


def _library() -> Any:
    return optional("gsd.hoomd", "exchange", "a GSD file")


def _box(trajectory: Trajectory) -> np.ndarray:
    """The edges (3,) of a box about the origin: the period, and the extent where it is open."""
    radius = trajectory.scene.chain.radius
    edges = 2.0 * SLACK * (np.abs(trajectory.positions).max(axis=(0, 1)) + radius)
    if trajectory.scene.chain.ends == "periodic":
        edges[0] = trajectory.scene.period
    return edges.astype(np.float32)


def _wrapped(
    positions: np.ndarray, box: np.ndarray, periodic: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Positions in the box, as 32-bit numbers, and the images (T, N, 3) they come from."""
    images = np.zeros(positions.shape, np.int32)
    if not periodic:
        return positions.astype(np.float32), images
    edge = float(box[0])
    images[..., 0] = np.floor(positions[..., 0] / edge + 0.5)
    inside = positions.copy()
    inside[..., 0] -= edge * images[..., 0]
    wrapped = inside.astype(np.float32)
    # rounded up to the face, which belongs to the next image
    above = wrapped[..., 0] >= np.float32(edge / 2)
    images[..., 0] += above
    wrapped[..., 0] = np.where(above, np.float32(-edge / 2), wrapped[..., 0])
    return wrapped, images


def _box_vectors(box: np.ndarray) -> np.ndarray:
    """The three vectors, as rows, of a box (Lx, Ly, Lz, xy, xz, yz) of HOOMD."""
    x, y, z, xy, xz, yz = box
    return np.array([[x, 0.0, 0.0], [xy * y, y, 0.0], [xz * z, yz * z, z]])


def _links(particles: int, periodic: bool) -> np.ndarray:
    first = np.arange(particles - (not periodic))
    return np.column_stack([first, (first + 1) % particles])
