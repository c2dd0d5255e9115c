"""nrchain: chains of active colloids in Stokes flow that break action and reaction."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from nrchain import (
        auto,
        cost,
        effect_plots,
        estimate,
        lattice,
        measure,
        plan,
        plots,
        regime,
        rod,
        scene_rules,
        slip_modes,
        work,
    )
    from nrchain.api import active_wrenches, elastic_energy, elastic_wrenches
    from nrchain.decomposition import Contributions, contribution_sizes, contributions
    from nrchain.description import describe
    from nrchain.effect_check import check_effect
    from nrchain.effects.base import Effect, OneBodyEffect
    from nrchain.effects.registry import register_effect, unregister_effect
    from nrchain.errors import (
        BackendError,
        NrchainError,
        SceneError,
        SceneWarning,
        TrajectoryError,
        UnknownNameError,
    )
    from nrchain.lattice import (
        Branch,
        lattice_operator,
        lattice_rates,
        steady_rotation,
        steady_stress,
        steady_velocity,
    )
    from nrchain.outcome import Cause
    from nrchain.rod import Rod
    from nrchain.run import resume, simulate
    from nrchain.scene import Scene, Slip, load_scene, scene_names
    from nrchain.scene_rules import Section
    from nrchain.slip_modes import SlipMode, register
    from nrchain.trajectory import Trajectory

# Public modules and names are imported when they are first used: `import nrchain` stays light.
_MODULES = {
    "auto",
    "cost",
    "effect_plots",
    "estimate",
    "lattice",
    "measure",
    "plan",
    "plots",
    "regime",
    "rod",
    "scene_rules",
    "slip_modes",
    "work",
}
_HOMES = {
    "active_wrenches": "nrchain.api",
    "elastic_energy": "nrchain.api",
    "elastic_wrenches": "nrchain.api",
    "Contributions": "nrchain.decomposition",
    "contribution_sizes": "nrchain.decomposition",
    "contributions": "nrchain.decomposition",
    "check_effect": "nrchain.effect_check",
    "Effect": "nrchain.effects.base",
    "OneBodyEffect": "nrchain.effects.base",
    "register_effect": "nrchain.effects.registry",
    "unregister_effect": "nrchain.effects.registry",
    "BackendError": "nrchain.errors",
    "NrchainError": "nrchain.errors",
    "SceneError": "nrchain.errors",
    "SceneWarning": "nrchain.errors",
    "TrajectoryError": "nrchain.errors",
    "UnknownNameError": "nrchain.errors",
    "Branch": "nrchain.lattice",
    "lattice_operator": "nrchain.lattice",
    "lattice_rates": "nrchain.lattice",
    "steady_rotation": "nrchain.lattice",
    "steady_stress": "nrchain.lattice",
    "steady_velocity": "nrchain.lattice",
    "Cause": "nrchain.outcome",
    "Rod": "nrchain.rod",
    "describe": "nrchain.description",
    "resume": "nrchain.run",
    "simulate": "nrchain.run",
    "Scene": "nrchain.scene",
    "Slip": "nrchain.scene",
    "load_scene": "nrchain.scene",
    "scene_names": "nrchain.scene",
    "Section": "nrchain.scene_rules",
    "SlipMode": "nrchain.slip_modes",
    "register": "nrchain.slip_modes",
    "Trajectory": "nrchain.trajectory",
}

__all__ = [
    "BackendError",
    "Branch",
    "Cause",
    "Contributions",
    "Effect",
    "NrchainError",
    "OneBodyEffect",
    "Rod",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Section",
    "Slip",
    "SlipMode",
    "Trajectory",
    "TrajectoryError",
    "UnknownNameError",
    "active_wrenches",
    "auto",
    "check_effect",
    "contribution_sizes",
    "contributions",
    "cost",
    "describe",
    "effect_plots",
    "elastic_energy",
    "elastic_wrenches",
    "estimate",
    "lattice",
    "lattice_operator",
    "lattice_rates",
    "load_scene",
    "measure",
    "plan",
    "plots",
    "regime",
    "register",
    "register_effect",
    "resume",
    "rod",
    "scene_names",
    "scene_rules",
    "simulate",
    "slip_modes",
    "steady_rotation",
    "steady_stress",
    "steady_velocity",
    "unregister_effect",
    "work",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"nrchain.{name}")
    if name not in _HOMES:
        # with name and obj Python adds which name of dir() is nearest
        told = f"module 'nrchain' has no attribute {name!r}"
        raise AttributeError(told, name=name, obj=sys.modules[__name__])
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
