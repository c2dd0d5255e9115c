"""The integrators, by their names in ``run.integrator``."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from nrchain.errors import SceneError
from nrchain.inputs.names import did_you_mean

if TYPE_CHECKING:
    from nrchain.motion.integrators.base import Integrator

INTEGRATORS = {
    "cvode": "nrchain.motion.integrators.cvode:Cvode",
    "radau": "nrchain.motion.integrators.radau:Radau",
    "scipy-bdf": "nrchain.motion.integrators.scipy_bdf:ScipyBdf",
}
"""The class of each, imported at first use."""


def find_integrator(name: str) -> type[Integrator]:
    """The class of an integrator.

    Raises :class:`~nrchain.errors.SceneError` with the known names for an unknown one.
    """
    check_integrator(name)
    module, _, attribute = INTEGRATORS[name].partition(":")
    return getattr(import_module(module), attribute)


def resolve_name(name: str, is_near: bool) -> str:
    """The integrator that ``run.integrator`` stands for: ``"auto"`` is the fastest at equal error.

    Radau IIA needs fewer steps, and solves more systems in each. Banded systems cost little; those
    of all pairs are solved by iterations (``python -m validation integrators``).
    """
    if name != "auto":
        return name
    return "radau" if is_near else "cvode"


def check_integrator(name: str) -> None:
    """Raise SceneError for an unknown name, without importing an integrator."""
    if name in INTEGRATORS:
        return
    hint = did_you_mean(name, INTEGRATORS)
    raise SceneError("run.integrator", name, f"must be one of {', '.join(INTEGRATORS)}{hint}")
