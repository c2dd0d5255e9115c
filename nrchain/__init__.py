"""nrchain: chains of active colloids in Stokes flow that break action and reaction."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
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

# Each public name is imported when it is first used, so that `import nrchain` stays light.
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
    "active_wrenches",
    "check_effect",
    "contribution_sizes",
    "contributions",
    "describe",
    "elastic_energy",
    "elastic_wrenches",
    "lattice_operator",
    "lattice_rates",
    "load_scene",
    "register",
    "register_effect",
    "resume",
    "scene_names",
    "simulate",
    "steady_rotation",
    "steady_stress",
    "steady_velocity",
    "unregister_effect",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'nrchain' has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
