"""The layout of a trajectory file: HDF5 laid out as H5MD.

    /h5md                          version (1, 1), author, creator
    /particles/trajectory/box      periodic along x, with edges (T, 3), or none
    /particles/trajectory/position value (T, N, 3), time (T,), step (T,)
    /particles/trajectory/frame    value (T, N, 3, 3), the same time and step by hard links
    /observables/trajectory        with run.verify: position_error and frame_error, each with value
                                   (T,) and the same time and step
    /parameters                    scene (its TOML text), effects that act, versions (of the
                                   packages that ran it), choice (JSON: the effects that
                                   effects = "auto" left out), provenance (JSON: what the run
                                   started from, how it was extended), and start, where the scene
                                   is given poses: position (N, 3), frame (N, 3, 3)
    /nrchain                       layout, units, the name of the file, times asked for, the number
                                   of finished snapshots, counters, status, cause, reason, two
                                   checkpoints

T is the number of finished snapshots. :mod:`nrchain.trajectory.new_file` makes a file with room for
all those asked for.

H5MD 1.1: P. de Buyl, P. H. Colberg, F. Höfling, Comput. Phys. Commun. 185, 1546 (2014).
"""

from __future__ import annotations

from typing import Any

from nrchain.outcome import Cause

GROUP = "particles/trajectory"
POSITION = f"{GROUP}/position"
FRAME = f"{GROUP}/frame"
EDGES = f"{GROUP}/box/edges"
ERRORS = {
    "position_error": "observables/trajectory/position_error",
    "frame_error": "observables/trajectory/frame_error",
}
"""The estimated errors of a run with ``run.verify``."""

SCENE = "parameters/scene"
STARTS = {"positions": "parameters/start/position", "frames": "parameters/start/frame"}
"""The keys of ``[start]`` that the file keeps as arrays."""

CHOICE = "parameters/choice"
EFFECTS = "parameters/effects"
PROVENANCE = "parameters/provenance"
VERSIONS = "parameters/versions"
CHOICE_ROOM = 64
"""Bytes by which a choice may grow when a run is resumed: the time to which it was watched."""

OURS = "nrchain"
LAYOUT = 2
"""The number of this layout, an attribute of the group ``nrchain``."""

NAME = "nrchain/name"
PLANNED = "nrchain/times"
FINISHED = "nrchain/finished"
COUNTS = "nrchain/counters"
STATUS = "nrchain/status"
CAUSE = "nrchain/cause"
REASON = "nrchain/reason"
CHECKPOINTS = "nrchain/checkpoints"

TIMES = ("wall_time", "processor_time")
COUNTERS = ("steps", "evaluations", "jacobians", "solves", "restarts", *TIMES)
"""What a run counts: whole numbers, and the seconds of :data:`TIMES`; see :mod:`nrchain.work`."""

STATUSES = ("running", "completed", "stopped")
"""The status of a run by its code in the file. A killed run is left as running."""

CAUSES = (None, *Cause)
"""Why a run stopped, by its code in the file. The first is for a run that did not stop."""

REASON_BYTES = 1024
CHECKPOINT_STATE = 6
"""Numbers of a checkpoint besides its poses: time, snapshot, spin, drift. The counters follow."""

LENGTH, TIME = "Angstrom", "ps"
"""Names for the scene's units of length and time. Programs without reduced units, such as
MDAnalysis, read only files whose units they know."""


def snapshot_series(file: Any) -> list[str]:
    """The names of the data sets with one row for each snapshot."""
    names = [f"{POSITION}/value", f"{FRAME}/value", f"{POSITION}/step", f"{POSITION}/time"]
    more = [f"{element}/value" for element in (EDGES, *ERRORS.values()) if element in file]
    return names + more


def replace_text(file: Any, name: str, text: str) -> None:
    """Replace a text. Raises ValueError if the new one does not fit."""
    import h5py

    encoded, length = text.encode(), h5py.check_string_dtype(file[name].dtype).length
    if length is not None and len(encoded) > length:
        raise ValueError(f"{name} holds {length} bytes, and {len(encoded)} are to be written")
    file[name][()] = encoded
