"""Slip arguments of public functions: modes by label, with a strength for each sphere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from nrchain.errors import SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.slip import Slip
from nrchain.inputs.arguments import finite_array


class GivenSlip(NamedTuple):
    """One mode: its label, the strength of each sphere (N,) and its body axis, a unit vector."""

    label: str
    strengths: np.ndarray
    axis: np.ndarray


def given_slips(slip: Any, count: int) -> list[GivenSlip]:
    """Read a slip given as {label: number, array, Slip, or table of strength and axis}.

    Raises SceneError for any other type, for unknown modes, wrong shapes and numbers that are not
    finite.
    """
    if not isinstance(slip, Mapping):
        allowed = "must be a table of mode labels, each with a number, N numbers or a Slip"
        raise SceneError("slip", slip, allowed)
    found = []
    for label, given in slip.items():
        slip_modes.find(label)
        name = f"slip[{label!r}]"
        strength, axis = given, (1.0, 0.0, 0.0)
        if isinstance(given, Slip | Mapping):
            mode = given if isinstance(given, Slip) else _read_table(name, given)
            strength, axis = mode.strength, mode.axis
        values = finite_array(name, strength)
        if values.ndim:
            values = finite_array(name, strength, (count,))
        strengths = np.broadcast_to(values, (count,))
        found.append(GivenSlip(label, strengths, np.asarray(axis) / np.linalg.norm(axis)))
    return found


def _read_table(name: str, table: Mapping[str, Any]) -> Slip:
    try:
        return Slip.from_mapping(table)
    except SceneError as error:
        raise SceneError(f"{name}.{error.key}", error.value, error.allowed) from None
