"""nrchain: chains of active colloids with nonreciprocal interactions in Stokes flow."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING, Any

from nrchain.scene import extensions
from nrchain.version import __version__ as __version__

if TYPE_CHECKING:
    from nrchain import units
    from nrchain.accuracy import cost
    from nrchain.analysis import measure
    from nrchain.analysis.decomposition import Contributions, contribution_sizes, contributions
    from nrchain.analysis.flow import Flow, flow
    from nrchain.diagrams.compute import phases
    from nrchain.diagrams.diagram import PhaseDiagram
    from nrchain.effects.base import Effect, OneBodyEffect
    from nrchain.effects.registry import register_effect, unregister_effect
    from nrchain.effects.shared.check import check_effect
    from nrchain.errors import (
        BackendError,
        NrchainError,
        SceneError,
        SceneWarning,
        TrajectoryError,
        UnknownNameError,
    )
    from nrchain.exchange.export import export
    from nrchain.figures.catalogue import draw_figure, save_figure
    from nrchain.hydrodynamics import slip_modes
    from nrchain.hydrodynamics.slip import Slip
    from nrchain.hydrodynamics.slip_mode import SlipMode
    from nrchain.hydrodynamics.slip_modes import register
    from nrchain.inputs import rules
    from nrchain.inputs.rules import Section
    from nrchain.motion.wrenches import active_wrenches, elastic_energy, elastic_wrenches
    from nrchain.outcome import Cause
    from nrchain.planning import auto, estimate, plan, regime
    from nrchain.planning.description import describe
    from nrchain.run import work
    from nrchain.run.ensemble import simulate_many
    from nrchain.run.members import Member
    from nrchain.run.simulation import resume, simulate
    from nrchain.scene.loading import load_scene
    from nrchain.scene.scene import Scene
    from nrchain.scene.toml import scene_names
    from nrchain.states.branches.branch import SpecialPoint, StateBranch
    from nrchain.states.branches.continuation import BranchDiagram, continue_state
    from nrchain.states.critical import CriticalStrength, critical_strength
    from nrchain.states.cycles.branch import CycleBranch, SpecialCycle
    from nrchain.states.cycles.continuation import CycleDiagram, continue_cycle
    from nrchain.states.cycles.cycle import Cycle, find_cycle
    from nrchain.states.mode_waves import ModeWaves, mode_waves
    from nrchain.states.modes import Mode
    from nrchain.states.spectrum import Spectrum, spectrum
    from nrchain.states.state import State, find_state
    from nrchain.sweeps.compute import sweep
    from nrchain.sweeps.result import Sweep, SweepPoint
    from nrchain.theory import lattice, rod
    from nrchain.theory.dispersion import Dispersion, dispersion
    from nrchain.theory.lattice import (
        Branch,
        lattice_operator,
        lattice_rates,
        steady_rotation,
        steady_stress,
        steady_velocity,
    )
    from nrchain.theory.rod import Material, Rod, rod_of
    from nrchain.theory.rod.coarse_graining import moduli
    from nrchain.trajectory.trajectory import Snapshot, Trajectory
    from nrchain.view import (
        dispersion_plots,
        effect_plots,
        flow_plots,
        phase_plots,
        plots,
        sweep_plots,
    )
    from nrchain.view.films import film
    from nrchain.view.space.render import render

# Public modules and names are imported at first use, so that `import nrchain` stays light.
_MODULES = {
    "auto": "nrchain.planning.auto",
    "cost": "nrchain.accuracy.cost",
    "dispersion_plots": "nrchain.view.dispersion_plots",
    "effect_plots": "nrchain.view.effect_plots",
    "estimate": "nrchain.planning.estimate",
    "flow_plots": "nrchain.view.flow_plots",
    "lattice": "nrchain.theory.lattice",
    "measure": "nrchain.analysis.measure",
    "phase_plots": "nrchain.view.phase_plots",
    "plan": "nrchain.planning.plan",
    "plots": "nrchain.view.plots",
    "regime": "nrchain.planning.regime",
    "rod": "nrchain.theory.rod",
    "rules": "nrchain.inputs.rules",
    "slip_modes": "nrchain.hydrodynamics.slip_modes",
    "sweep_plots": "nrchain.view.sweep_plots",
    "units": "nrchain.units",
    "work": "nrchain.run.work",
}
_MODULE_OF = {
    "active_wrenches": "nrchain.motion.wrenches",
    "elastic_energy": "nrchain.motion.wrenches",
    "elastic_wrenches": "nrchain.motion.wrenches",
    "Contributions": "nrchain.analysis.decomposition",
    "contribution_sizes": "nrchain.analysis.decomposition",
    "contributions": "nrchain.analysis.decomposition",
    "Flow": "nrchain.analysis.flow",
    "flow": "nrchain.analysis.flow",
    "PhaseDiagram": "nrchain.diagrams.diagram",
    "phases": "nrchain.diagrams.compute",
    "check_effect": "nrchain.effects.shared.check",
    "Effect": "nrchain.effects.base",
    "OneBodyEffect": "nrchain.effects.base",
    "register_effect": "nrchain.effects.registry",
    "unregister_effect": "nrchain.effects.registry",
    "export": "nrchain.exchange.export",
    "BackendError": "nrchain.errors",
    "NrchainError": "nrchain.errors",
    "SceneError": "nrchain.errors",
    "SceneWarning": "nrchain.errors",
    "TrajectoryError": "nrchain.errors",
    "UnknownNameError": "nrchain.errors",
    "Branch": "nrchain.theory.lattice",
    "lattice_operator": "nrchain.theory.lattice",
    "lattice_rates": "nrchain.theory.lattice",
    "steady_rotation": "nrchain.theory.lattice",
    "steady_stress": "nrchain.theory.lattice",
    "steady_velocity": "nrchain.theory.lattice",
    "Cause": "nrchain.outcome",
    "Dispersion": "nrchain.theory.dispersion",
    "dispersion": "nrchain.theory.dispersion",
    "Material": "nrchain.theory.rod",
    "moduli": "nrchain.theory.rod.coarse_graining",
    "Rod": "nrchain.theory.rod",
    "rod_of": "nrchain.theory.rod",
    "describe": "nrchain.planning.description",
    "resume": "nrchain.run.simulation",
    "simulate": "nrchain.run.simulation",
    "Member": "nrchain.run.members",
    "simulate_many": "nrchain.run.ensemble",
    "Scene": "nrchain.scene.scene",
    "BranchDiagram": "nrchain.states.branches.continuation",
    "SpecialPoint": "nrchain.states.branches.branch",
    "StateBranch": "nrchain.states.branches.branch",
    "continue_state": "nrchain.states.branches.continuation",
    "CriticalStrength": "nrchain.states.critical",
    "critical_strength": "nrchain.states.critical",
    "Cycle": "nrchain.states.cycles.cycle",
    "CycleBranch": "nrchain.states.cycles.branch",
    "CycleDiagram": "nrchain.states.cycles.continuation",
    "SpecialCycle": "nrchain.states.cycles.branch",
    "continue_cycle": "nrchain.states.cycles.continuation",
    "find_cycle": "nrchain.states.cycles.cycle",
    "Mode": "nrchain.states.modes",
    "ModeWaves": "nrchain.states.mode_waves",
    "mode_waves": "nrchain.states.mode_waves",
    "Spectrum": "nrchain.states.spectrum",
    "spectrum": "nrchain.states.spectrum",
    "State": "nrchain.states.state",
    "find_state": "nrchain.states.state",
    "film": "nrchain.view.films",
    "render": "nrchain.view.space.render",
    "draw_figure": "nrchain.figures.catalogue",
    "save_figure": "nrchain.figures.catalogue",
    "Slip": "nrchain.hydrodynamics.slip",
    "Sweep": "nrchain.sweeps.result",
    "SweepPoint": "nrchain.sweeps.result",
    "sweep": "nrchain.sweeps.compute",
    "load_scene": "nrchain.scene.loading",
    "scene_names": "nrchain.scene.toml",
    "Section": "nrchain.inputs.rules",
    "SlipMode": "nrchain.hydrodynamics.slip_mode",
    "register": "nrchain.hydrodynamics.slip_modes",
    "Snapshot": "nrchain.trajectory.trajectory",
    "Trajectory": "nrchain.trajectory.trajectory",
}

__all__ = [
    "BackendError",
    "Branch",
    "BranchDiagram",
    "Cause",
    "Contributions",
    "CriticalStrength",
    "Cycle",
    "CycleBranch",
    "CycleDiagram",
    "Dispersion",
    "Effect",
    "Flow",
    "Material",
    "Member",
    "Mode",
    "ModeWaves",
    "NrchainError",
    "OneBodyEffect",
    "PhaseDiagram",
    "Rod",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Section",
    "Slip",
    "SlipMode",
    "Snapshot",
    "SpecialCycle",
    "SpecialPoint",
    "Spectrum",
    "State",
    "StateBranch",
    "Sweep",
    "SweepPoint",
    "Trajectory",
    "TrajectoryError",
    "UnknownNameError",
    "active_wrenches",
    "auto",
    "check_effect",
    "continue_cycle",
    "continue_state",
    "contribution_sizes",
    "contributions",
    "cost",
    "critical_strength",
    "describe",
    "dispersion",
    "dispersion_plots",
    "draw_figure",
    "effect_plots",
    "elastic_energy",
    "elastic_wrenches",
    "estimate",
    "export",
    "film",
    "find_cycle",
    "find_state",
    "flow",
    "flow_plots",
    "lattice",
    "lattice_operator",
    "lattice_rates",
    "load_scene",
    "measure",
    "mode_waves",
    "moduli",
    "phase_plots",
    "phases",
    "plan",
    "plots",
    "regime",
    "register",
    "register_effect",
    "render",
    "resume",
    "rod",
    "rod_of",
    "rules",
    "save_figure",
    "scene_names",
    "simulate",
    "simulate_many",
    "slip_modes",
    "spectrum",
    "steady_rotation",
    "steady_stress",
    "steady_velocity",
    "sweep",
    "sweep_plots",
    "units",
    "unregister_effect",
    "work",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(_MODULES[name])
    if name not in _MODULE_OF:
        # with name and obj, Python adds the nearest name of dir()
        message = f"module 'nrchain' has no attribute {name!r}"
        raise AttributeError(message, name=name, obj=sys.modules[__name__])
    value = getattr(importlib.import_module(_MODULE_OF[name]), name)
    globals()[name] = value
    return value


# scenes get the registry of effects from here, and import no effect themselves
extensions.provide(lambda: importlib.import_module("nrchain.effects.registry"))


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
