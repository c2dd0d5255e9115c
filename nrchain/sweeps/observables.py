"""Trajectory → numbers and words: what a sweep keeps of each run.

Names that begin with ``end.`` are of the last snapshot. Those that begin with ``measure.`` are the
functions of :mod:`nrchain.measure` with their defaults, reduced to one number or word. Own
observables are functions of the trajectory.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from nrchain.analysis import measure
from nrchain.analysis.measured_chain import MeasurementError, links_of, positions_of
from nrchain.errors import NrchainError, SceneError
from nrchain.inputs.names import did_you_mean
from nrchain.motion.wrenches import elastic_energy
from nrchain.trajectory.trajectory import Trajectory

Value = float | int | str | None
Observable = Callable[[Trajectory], Any]

DEFAULT = ("end.time", "end.size")
"""What is observed unless something is named."""


class Measured:
    """A trajectory with what several observables need, each measured once."""

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory

    @property
    def last(self) -> np.ndarray:
        """(N, 3) positions of the last snapshot, unwrapped."""
        return positions_of(self.trajectory)[-1]

    @cached_property
    def attractor(self) -> measure.Attractor:
        return measure.attractor(self.trajectory)

    @cached_property
    def fit(self) -> measure.ShapeFit:
        return measure.fit_shape(self.trajectory)

    @cached_property
    def hand(self) -> measure.Handedness:
        return measure.handedness(self.trajectory)

    @cached_property
    def lyapunov(self) -> measure.Estimate:
        return measure.lyapunov(self.trajectory)

    @cached_property
    def rate(self) -> measure.Rate:
        return measure.rate(measure.wave(self.trajectory))

    @cached_property
    def spin(self) -> measure.Estimate:
        return measure.spin(self.trajectory)

    @cached_property
    def velocity(self) -> tuple[float, ...]:
        return tuple(one.value for one in measure.translation(self.trajectory))


def _size(of: Measured) -> float:
    """√⟨δ²⟩, δ the distance of a sphere from the line that fits the chain best."""
    centred = of.last - of.last.mean(axis=0)
    if of.trajectory.scene.chain.ends == "periodic":
        square = float((centred[:, 1:] ** 2).sum())
    else:
        square = float((np.linalg.svd(centred, compute_uv=False)[1:] ** 2).sum())
    return math.sqrt(square / len(centred))


def _gyration(of: Measured) -> float:
    centred = of.last - of.last.mean(axis=0)
    return math.sqrt(float((centred**2).sum()) / len(centred))


def _distance(of: Measured) -> float:
    return float(np.linalg.norm(links_of(of.trajectory)[-1].sum(axis=0)))


def _energy(of: Measured) -> float:
    scene = of.trajectory.scene
    return elastic_energy(
        of.last,
        of.trajectory.frames[-1],
        spacing=scene.chain.spacing,
        ends=scene.chain.ends,
        measure=scene.elasticity.measure,
        **scene.moduli._asdict(),
    )


def _error(of: Measured) -> float:
    error = of.trajectory.position_error
    if error is None:
        raise MeasurementError("the run has no estimate of its error; set run.verify = true")
    return float(error[-1])


NAMED: dict[str, tuple[str, Callable[[Measured], Any]]] = {
    "end.time": ("time that the run reached", lambda of: float(of.trajectory.time[-1])),
    "end.size": ("rms distance of the spheres from the line that fits them best", _size),
    "end.gyration": ("radius of gyration", _gyration),
    "end.distance": ("end-to-end distance; the period of a periodic chain", _distance),
    "end.energy": ("elastic energy", _energy),
    "end.error": ("estimated error of the positions, with run.verify", _error),
    "measure.attractor": ("kind of attractor, a word", lambda of: str(of.attractor.kind)),
    "measure.attractor.since": (
        "time from which on the chain is on it",
        lambda of: of.attractor.since,
    ),
    "measure.attractor.period": ("its period", lambda of: of.attractor.period),
    "measure.fit_shape": ("growth of the wave fitted to all snapshots", lambda of: _growth(of.fit)),
    "measure.fit_shape.frequency": (
        "its angular frequency",
        lambda of: of.fit.rate.frequency.value,
    ),
    "measure.fit_shape.misfit": ("its misfit, of the shape", lambda of: of.fit.misfit),
    "measure.handedness": ("mean volume of three links over d³", lambda of: of.hand.size[-1]),
    "measure.handedness.hand": ("1 right-handed, −1 left-handed", lambda of: of.hand.hand[-1]),
    "measure.lyapunov": ("largest Lyapunov exponent", lambda of: of.lyapunov.value),
    "measure.lyapunov.error": ("its standard error", lambda of: of.lyapunov.error),
    "measure.rate": ("growth of the wave of the start", lambda of: of.rate.growth.value),
    "measure.rate.error": ("standard error of its rate", lambda of: of.rate.error),
    "measure.rate.frequency": ("its angular frequency", lambda of: of.rate.frequency.value),
    "measure.rate.misfit": ("its misfit, of the wave", lambda of: of.rate.misfit),
    "measure.spin": ("angular velocity about e₁", lambda of: of.spin.value),
    "measure.spin.error": ("its standard error", lambda of: of.spin.error),
    "measure.straightness": (
        "end-to-end distance over contour length, at the end",
        lambda of: measure.straightness(of.trajectory)[-1],
    ),
    "measure.translation": ("mean speed of the chain", lambda of: math.hypot(*of.velocity)),
    "measure.translation.x": ("x of its mean velocity", lambda of: of.velocity[0]),
    "measure.translation.y": ("y of its mean velocity", lambda of: of.velocity[1]),
    "measure.translation.z": ("z of its mean velocity", lambda of: of.velocity[2]),
    "measure.turned_angle": (
        "angle turned about e₁, in radians",
        lambda of: measure.turned_angle(of.trajectory)[-1],
    ),
    "measure.wave": (
        "amplitude of the wave of the start, at the end",
        lambda of: abs(measure.wave(of.trajectory).amplitude[-1]),
    ),
}
"""What each named observable is, and how it is measured."""


def read_observables(
    given: str | Iterable[str] | Mapping[str, Observable | str] | None,
) -> dict[str, Observable | None]:
    """Observables by name: None for a named one, else the function.

    Raises :class:`~nrchain.errors.SceneError` for an unknown name, with those that there are.
    """
    if given is None:
        given = DEFAULT
    if isinstance(given, str):
        given = [given]
    if not isinstance(given, Iterable):
        raise SceneError("observe", given, "must be names, or a table of names and functions")
    found: dict[str, Observable | None] = {}
    items = given.items() if isinstance(given, Mapping) else ((name, name) for name in given)
    for name, what in items:
        if not isinstance(name, str) or not name:
            raise SceneError("observe", name, "must be a name")
        if callable(what):
            if name in NAMED:
                raise SceneError("observe", name, "is the name of another observable")
            found[name] = what
        elif what in (None, name) and name in NAMED:
            found[name] = None
        else:
            hint = did_you_mean(name, NAMED)
            raise SceneError("observe", name, f"must be one of {', '.join(NAMED)}{hint}")
    if not found:
        allowed = f"must have at least one name, of {', '.join(NAMED)}, or an own function"
        raise SceneError("observe", given, allowed)
    return found


def observe(
    trajectory: Trajectory, observables: Mapping[str, Observable | None]
) -> tuple[dict[str, Value], dict[str, str]]:
    """The observables of a trajectory, and why those that are None cannot be measured."""
    of = Measured(trajectory)
    values: dict[str, Value] = {}
    reasons: dict[str, str] = {}
    for name, function in observables.items():
        try:
            found = NAMED[name][1](of) if function is None else function(trajectory)
            values[name] = _scalar(found)
        except Exception as error:
            is_own = isinstance(error, NrchainError)
            reasons[name] = str(error) if is_own else f"{type(error).__name__}: {error}"
            values[name] = None
    return values, reasons


def _growth(fit: measure.ShapeFit) -> float:
    return fit.rate.growth.value


def _scalar(found: Any) -> Value:
    """A number or a word as JSON keeps it."""
    plain = (
        found.item()
        if isinstance(found, np.generic) or (np.ndim(found) == 0 and hasattr(found, "item"))
        else found
    )
    if isinstance(plain, bool):
        return int(plain)
    if plain is None or isinstance(plain, (int, float, str)):
        return str(plain) if isinstance(plain, str) else plain
    raise MeasurementError(f"gives {type(found).__name__}, and must give one number or word")
