"""What ``--json`` prints of each result. docs/running.md lists the keys; they are stable."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nrchain.accuracy.cost import Advice, WorkPrecision
    from nrchain.accuracy.plan_effects import EffectPlan
    from nrchain.analysis.measure import Attractor
    from nrchain.diagrams.diagram import PhaseDiagram
    from nrchain.planning.plan import Plan
    from nrchain.states.branches.branch import SpecialPoint
    from nrchain.states.branches.continuation import BranchDiagram
    from nrchain.states.cycles.branch import SpecialCycle
    from nrchain.states.cycles.continuation import CycleDiagram
    from nrchain.states.modes import Mode
    from nrchain.states.spectrum import Spectrum
    from nrchain.sweeps.result import Sweep
    from nrchain.sweeps.without_value import WithoutValue
    from nrchain.theory.dispersion import Dispersion
    from nrchain.theory.rod.coarse_graining import Moduli
    from nrchain.trajectory.trajectory import Trajectory

Record = dict[str, Any]


def run_record(trajectory: Trajectory, picture: Path | None, attractor: Attractor | None) -> Record:
    """How a run ended, what it counted, and where its files are."""
    from nrchain.effects.registry import acting

    run = trajectory.scene.run
    choice = trajectory.choice
    return {
        "status": trajectory.status,
        "cause": trajectory.cause,
        "reason": trajectory.reason,
        "advice": trajectory.advice,
        "time": trajectory.time[-1] if len(trajectory) else None,
        "end": run.end,
        "snapshots": len(trajectory),
        "snapshots_asked": run.snapshots,
        "counters": dict(trajectory.counters),
        "effects": [effect.name for effect in acting(trajectory.scene)],
        "left_out": list(choice.left_out) if choice else [],
        "position_error": _largest(trajectory.position_error),
        "frame_error": _largest(trajectory.frame_error),
        "attractor": attractor
        and {
            "kind": attractor.kind,
            "since": attractor.since,
            "period": attractor.period,
            "confidence": attractor.confidence,
        },
        "trajectory": trajectory.path,
        "picture": picture,
    }


def _largest(errors: Any) -> float | None:
    """The largest error that is known."""
    import numpy as np

    known = np.isfinite(errors) if errors is not None else np.zeros(0, bool)
    return float(errors[known].max()) if known.any() else None


def plan_record(
    predicted: Plan, effects: EffectPlan, without_effect: list[tuple[str, str]]
) -> Record:
    """The lines of a plan, and what each effect contributes and costs."""
    from nrchain.accuracy.effect_cells import name

    pairs = zip(effects.estimates.estimates, effects.others, strict=True)
    return {
        "lines": [
            {"quantity": line.quantity, "value": line.value, "meaning": line.meaning}
            for line in predicted.lines
        ],
        "effects": [
            {
                "effect": name(one.change),
                "velocity": one.velocity,
                "velocity_along": one.velocity_along,
                "growth": one.growth,
                "displacement": one.displacement,
                "turn": one.turn,
                "until": one.until,
                "seconds": other,
            }
            for one, other in pairs
        ],
        "seconds": effects.own,
        "not_possible": [{"effect": name(one), "why": one.reason} for one in effects.refused],
        "warnings": predicted.warnings,
        "without_effect": [{"key": key, "why": why} for key, why in without_effect],
    }


def cost_record(found: WorkPrecision, advice: Advice | None) -> Record:
    """Error, counts and processor time of each setting, and the setting for a target."""
    points = [
        {
            "axis": one.axis,
            "setting": one.setting,
            "error": one.measured.error,
            **one.measured.work._asdict(),
            "seconds": one.measured.median,
            "whole_run_seconds": found.whole_run(one.measured),
        }
        for one in found.points
    ]
    return {
        "reached": found.reached,
        "end": found.scene.run.end,
        "points": points,
        "skipped": found.skipped,
        "advice": advice
        and {
            "target": advice.target,
            "setting": advice.point.setting,
            "arguments": advice.arguments,
            "reached": advice.reached,
            "error": advice.error,
            "seconds": advice.seconds,
        },
    }


def solid_record(found: Moduli, odd: bool, sourced: bool) -> Record:
    """The moduli by symbol for a transversely isotropic chain, and as matrices for all."""
    parts = {
        "slip": found.active,
        "elasticity": found.elastic,
        "total": found.total,
        "logarithm": found.logarithm,
    }
    return {
        "isotropic": found.symmetry.isotropic,
        "odd": odd,
        "sourced": sourced,
        "stress": found.stress,
        "constants": {name: part.symbols() for name, part in parts.items()}
        if found.symmetry.isotropic
        else None,
        "C": found.total.C,
        "H": found.total.H,
        "prestress": found.total.prestress,
        "presource": found.total.presource,
        "drag": found.drag,
    }


def dispersion_record(found: Dispersion, picture: Path) -> Record:
    """Growth and frequency of each branch by every theory, over the wavenumbers."""
    from nrchain.theory.lattice import Branch

    theories: Record = {"lattice": {}, "rod": {}, "beam": {}}
    for branch in Branch:
        theories["lattice"][branch.spoken] = _rates(found.lattice[:, branch])
        for name, waves in (("rod", found.rod), ("beam", found.beam)):
            if waves is not None and branch in waves.branches:
                theories[name][branch.spoken] = _rates(waves.column(branch))
    return {
        "wavenumbers": found.wavenumbers,
        "axes": found.frame,
        **theories,
        "picture": picture,
    }


def _rates(rates: Any) -> Record:
    return {"growth": rates.real, "frequency": 0.0 - rates.imag}


def spectrum_record(found: Spectrum) -> Record:
    """The state, its leading modes, and the slope of the leading rate with each key."""
    motion = found.state.motion
    return {
        "straight": found.is_straight,
        "stable": found.is_stable,
        "velocity": motion.velocity,
        "rotation": motion.rotation,
        "turn": motion.turn,
        "residual": found.state.residual,
        "abscissa": found.abscissa,
        "neutral": list(found.neutral.names),
        "modes": [_mode(one) for one in found.modes],
        "sensitivities": found.sensitivities(),
    }


def _mode(one: Mode) -> Record:
    return {
        "growth": one.growth,
        "frequency": one.frequency,
        "multiplicity": one.multiplicity,
        "error": one.error,
        "condition": one.condition,
    }


def phases_record(found: PhaseDiagram, picture: Path, table: Path) -> Record:
    """The regions and thresholds of a diagram, and where its files are."""
    return {
        "complete": found.is_complete,
        "points": len(found.points),
        "keys": [found.x.key, found.y.key],
        "regions": [
            {
                "kind": one.kind,
                "points": len(one.points),
                "share": one.share,
                "x": one.x,
                "y": one.y,
                "confirmed": one.agrees,
            }
            for one in found.regions
        ],
        "thresholds": [
            {"flutters": one.flutters, "x": one.x, "y": one.y, "frequency": one.frequency}
            for one in found.curves
        ],
        "notes": list(found.notes),
        "picture": picture,
        "runs": table,
    }


def branch_record(found: BranchDiagram, picture: Path, cycles: list[Record]) -> Record:
    """The states of each branch, its special points, and the cycles that leave Hopf points."""
    return {
        "key": found.line.key,
        "branches": [
            {
                "values": one.values,
                "unstable": one.unstable,
                "amplitude": one.amplitude,
                "speed": one.speed,
                "parent": one.parent,
                "reason": one.reason,
                "special": [_special(point, "frequency") for point in one.special],
            }
            for one in found.branches
        ],
        "cycles": cycles,
        "picture": picture,
    }


def cycles_record(found: CycleDiagram, picture: Path) -> Record:
    """The cycles of each branch and their special points."""
    return {
        "branches": [
            {
                "values": one.values,
                "stable": one.is_stable,
                "period": one.periods,
                "reasons": one.reasons,
                "special": [_special(point, "angle") for point in one.special],
            }
            for one in found.branches
        ],
        "picture": picture,
    }


def sweep_record(found: Sweep, tables: list[Path]) -> Record:
    """The points of a sweep with what was observed, and where its tables are."""
    return {
        "keys": list(found.keys),
        "points": [
            {
                "values": one.values,
                "outcome": one.outcome,
                "cause": one.cause,
                "reason": one.reason,
                "observables": one.observables,
                "trajectory": one.trajectory,
            }
            for one in found.points
        ],
        "failed": len(found.failed),
        "without_value": without_value_record(found.without_value),
        "tables": tables,
    }


def without_value_record(found: Iterable[WithoutValue]) -> list[Record]:
    """The observables that have no value at some points, and the most frequent cause."""
    return [{"name": one.name, "points": one.points, "cause": one.cause} for one in found]


def _special(one: SpecialPoint | SpecialCycle, measure: str) -> Record:
    return {
        "kind": one.kind,
        "value": one.value,
        "error": one.error,
        measure: getattr(one, measure),
        "multiplicity": one.multiplicity,
    }
