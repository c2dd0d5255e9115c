"""netCDF: the labelled dataset of :meth:`nrchain.Trajectory.to_xarray`, with all digits."""

from __future__ import annotations

from pathlib import Path

from nrchain.errors import TrajectoryError
from nrchain.exchange.record import FramePoses, Record, pick_frame
from nrchain.inputs.optional import optional
from nrchain.trajectory.labelled import FRAME, POSITION
from nrchain.trajectory.trajectory import Trajectory

ENGINE, RECORD = "h5netcdf", "record"


def write(trajectory: Trajectory, record: Record, path: Path) -> None:
    """Write a netCDF 4 file; the attribute ``record`` holds the record."""
    optional(ENGINE, "exchange", "a netCDF file")
    dataset = trajectory.to_xarray()
    dataset.attrs[RECORD] = record.to_json()
    dataset.to_netcdf(path, engine="h5netcdf")


def read(path: Path, index: int) -> FramePoses:
    """Frame ``index`` of a netCDF file with the variables ``position`` and ``frame``."""
    optional(ENGINE, "exchange", "a netCDF file")
    library = optional("xarray", "exchange", "a netCDF file")
    with library.open_dataset(path, engine=ENGINE, decode_times=False) as dataset:
        if not {POSITION, FRAME, "time"} <= dataset.variables.keys():
            raise TrajectoryError(f"{path}: must have the variables time, {POSITION} and {FRAME}")
        place = pick_frame(path, index, dataset.sizes["time"])
        row = dataset.isel(time=place)
        return FramePoses(
            row[POSITION].transpose("sphere", "axis").values,
            row[FRAME].transpose("sphere", "vector", "axis").values,
            place,
            float(row["time"]),
            Record.from_json(dataset.attrs.get(RECORD, "")),
        )
