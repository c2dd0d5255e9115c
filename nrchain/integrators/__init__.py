"""The integrators on offer, by the name that a scene gives as ``run.integrator``."""

from __future__ import annotations

from difflib import get_close_matches
from importlib import import_module
from typing import TYPE_CHECKING

from nrchain.errors import SceneError

if TYPE_CHECKING:
    from nrchain.integrators.base import Integrator

INTEGRATORS = {
    "cvode": "nrchain.integrators.cvode:Cvode",
    "radau": "nrchain.integrators.radau:Radau",
    "scipy-bdf": "nrchain.integrators.scipy_bdf:ScipyBdf",
}
"""Where each is; imported only when it is used."""


def find_integrator(name: str) -> type[Integrator]:
    """The class of an integrator.

    Raises :class:`~nrchain.errors.SceneError` for a name that is none, with those that are.
    """
    check_integrator(name)
    module, _, attribute = INTEGRATORS[name].partition(":")
    return getattr(import_module(module), attribute)


def check_integrator(name: str) -> None:
    """Refuse a name that is no integrator's, without importing any."""
    if name in INTEGRATORS:
        return
    near = get_close_matches(str(name), INTEGRATORS, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    raise SceneError("run.integrator", name, f"{hint}must be one of {', '.join(INTEGRATORS)}")
