"""One of each public class, shown and copied by tests; what takes long is computed once."""

from __future__ import annotations

from functools import cache

import numpy as np

import nrchain
from nrchain import cost, estimate, measure, plan, regime, rod, slip_modes, work
from nrchain.effects.registry import effects
from nrchain.errors import SceneError
from nrchain.scene.chain_sections import StartSpec


def scene():
    """A scene with a section of every kind: two modes, an effect of its own section, an axis."""
    changes = {
        "chain.radius": 1.25,
        "chain.viscosity": 0.5,
        "slip.3a": {"strength": 40.0, "axis": [0.0, 1.0, 0.0]},
        "field.force": [0.0, 0.0, -1.0],
        "start.amplitude": 0.5,
        "run.end": 0.5,
        "run.snapshots": 5,
    }
    return nrchain.load_scene("buckling", **changes)


@cache
def trajectory():
    return nrchain.simulate(scene())


def poses():
    return trajectory().positions[-1], trajectory().frames[-1]


def wave_rate():
    a_wave = measure.wave(periodic_trajectory(), kind="y")
    return measure.rate(a_wave)


@cache
def periodic_trajectory():
    changes = {
        "chain.ends": "periodic",
        "start.shape": "sine",
        "start.amplitude": 0.5,
        "run.end": 5.0,
        "run.snapshots": 11,
    }
    return nrchain.simulate(nrchain.load_scene("passive", **changes))


@cache
def threshold():
    return nrchain.critical_strength(
        nrchain.load_scene("buckling", **{"chain.particles": 6}), "slip.2s", (200.0, 2000.0)
    )


@cache
def cycle():
    changes = {
        "chain.particles": 12,
        "slip.2s": 200.0,
        "slip.3t": 6500.0,
        "elasticity.ratio": 1e8,
        "run.end": 1000.0,
        "run.snapshots": 1001,
    }
    run = nrchain.simulate(nrchain.load_scene("buckling", **changes))
    return nrchain.find_cycle(run.scene, run, tolerance=1e-3)


@cache
def diagram():
    short = nrchain.load_scene("buckling", **{"chain.particles": 5, "start.amplitude": 0.5})
    return nrchain.phases(
        short, ("slip.2s", 0.0, 3000.0, 2), ("slip.3t", 0.0, 9.0, 2), "random", levels=0
    )


@cache
def swept():
    return nrchain.sweep(scene(), {"slip.2s": [0.0, 50.0]})


@cache
def branches():
    small = nrchain.load_scene("buckling", **{"chain.particles": 6})
    return nrchain.continue_state(small, {"slip.2s": (400.0, 900.0)}, branches=1)


@cache
def cycles():
    found = cycle()
    along = {"slip.3t": (6500.0, 8000.0)}
    return nrchain.continue_cycle(found.scene, along, found, steps=1, intervals=8)


def special_cycle():
    orbit = cycles().branches[0].orbits[0]
    return nrchain.SpecialCycle("fold", 6600.0, 1e-3, 0.0, 1, 0, orbit)


@cache
def work_precision():
    short = nrchain.load_scene("passive", **{"chain.particles": 4, "run.end": 1.0})
    return cost.work_precision(short, budget=0.1)


@cache
def estimates():
    return estimate.estimate_effects(scene(), budget=0.05)


@cache
def planned():
    return plan.plan(scene())


def one_neighbour() -> nrchain.Scene:
    return nrchain.load_scene("wave", **{"slip.neighbours": 1})


@cache
def motion():
    rod_of_chain = nrchain.rod_of(one_neighbour())
    return rod_of_chain.simulate(*rod_of_chain.bent(np.zeros(6)), times=[0.0, 1.0])


SPECIMENS = {
    "nrchain.BackendError": lambda: nrchain.BackendError("an unknown release"),
    "nrchain.Branch": lambda: nrchain.Branch.SHEAR_MINUS,
    "nrchain.BranchDiagram": branches,
    "nrchain.Cause": lambda: nrchain.Cause.TOUCH,
    "nrchain.Contributions": lambda: nrchain.contributions(scene(), *poses()),
    "nrchain.CriticalStrength": threshold,
    "nrchain.Cycle": cycle,
    "nrchain.CycleBranch": lambda: cycles().branches[0],
    "nrchain.CycleDiagram": cycles,
    "nrchain.Effect": lambda: [e(scene()) for e in effects() if e.acts(scene())],
    "nrchain.Flow": lambda: nrchain.flow(scene(), [[5.0, 3.0, 0.0], [0.0, 0.0, 0.0]]),
    "nrchain.Dispersion": lambda: nrchain.dispersion(nrchain.load_scene("wave"), [0.01, 0.02]),
    "nrchain.Material": lambda: nrchain.Material.of(nrchain.load_scene("wave")),
    "nrchain.Member": lambda: next(nrchain.simulate_many([scene()])),
    "nrchain.Mode": lambda: threshold().spectrum.leading,
    "nrchain.ModeWaves": lambda: nrchain.mode_waves(nrchain.dispersion(nrchain.load_scene("wave"))),
    "nrchain.NrchainError": lambda: nrchain.NrchainError("a fault"),
    "nrchain.OneBodyEffect": lambda: [
        e(scene()) for e in effects() if issubclass(e, nrchain.OneBodyEffect)
    ],
    "nrchain.PhaseDiagram": diagram,
    "nrchain.Rod": lambda: nrchain.Rod.of(nrchain.load_scene("wave")),
    "nrchain.Scene": scene,
    "nrchain.SceneError": lambda: SceneError("chain.spacing", 1.0, "must exceed two radii"),
    "nrchain.SceneWarning": lambda: nrchain.SceneWarning("a straight start"),
    "nrchain.Section": lambda: [scene().chain, scene().further, StartSpec(shape="sine")],
    "nrchain.Slip": lambda: nrchain.Slip((1.0, 2.0), axis=(0.0, 1.0, 0.0)),
    "nrchain.SlipMode": lambda: slip_modes.find("2s"),
    "nrchain.Snapshot": lambda: trajectory()[-1],
    "nrchain.SpecialCycle": special_cycle,
    "nrchain.SpecialPoint": lambda: branches().special[0],
    "nrchain.Spectrum": lambda: threshold().spectrum,
    "nrchain.State": lambda: nrchain.find_state(nrchain.load_scene("wave")),
    "nrchain.StateBranch": lambda: branches().branches[0],
    "nrchain.Sweep": swept,
    "nrchain.SweepPoint": lambda: swept().points[0],
    "nrchain.Trajectory": trajectory,
    "nrchain.TrajectoryError": lambda: nrchain.TrajectoryError("runs/a: is missing"),
    "nrchain.UnknownNameError": lambda: nrchain.UnknownNameError("'a' is not known"),
    "nrchain.cost.Advice": lambda: work_precision().advise(1e-2),
    "nrchain.cost.Point": lambda: work_precision().points[0],
    "nrchain.cost.WorkPrecision": work_precision,
    "nrchain.estimate.Estimate": lambda: estimates().estimates[0],
    "nrchain.estimate.Estimates": estimates,
    "nrchain.measure.Attracted": lambda: measure.Attracted.BUCKLED,
    "nrchain.measure.Attractor": lambda: measure.attractor(trajectory()),
    "nrchain.measure.Estimate": lambda: measure.Estimate(1.5, 0.25),
    "nrchain.measure.Handedness": lambda: measure.handedness(trajectory()),
    "nrchain.measure.MeasurementError": lambda: measure.MeasurementError("no wave"),
    "nrchain.measure.Rate": wave_rate,
    "nrchain.measure.ShapeFit": lambda: measure.fit_shape(periodic_trajectory(), kind="y"),
    "nrchain.measure.Wave": lambda: measure.wave(periodic_trajectory(), kind="y"),
    "nrchain.plan.Line": lambda: planned().lines[0],
    "nrchain.plan.Plan": planned,
    "nrchain.regime.Judgement": lambda: regime.try_judge(nrchain.load_scene("buckling")),
    "nrchain.rod.Class": lambda: rod.classes()["F_pre"],
    "nrchain.rod.Constants": lambda: rod.Constants.named({"F_pre": 1.0}),
    "nrchain.rod.CosseratRod": lambda: nrchain.rod_of(one_neighbour()),
    "nrchain.rod.Motion": motion,
    "nrchain.rod.RodError": lambda: rod.RodError("the rod stops"),
    "nrchain.rod.Instability": lambda: rod.rod_instability(
        nrchain.Material.of(nrchain.load_scene("buckling"))
    ),
    "nrchain.rod.Moduli": lambda: nrchain.moduli(nrchain.load_scene("wave")),
    "nrchain.rod.Modulus": lambda: rod.TABLE[0],
    "nrchain.rod.Response": lambda: rod.uniform_response(nrchain.load_scene("wave"), [0] * 6),
    "nrchain.rod.Symbol": lambda: rod.rod_symbol(nrchain.Material.of(nrchain.load_scene("wave"))),
    "nrchain.rod.Symmetry": lambda: rod.symmetry_of_modes({"4a": (1, 0, 0)}),
    "nrchain.rod.Waves": lambda: rod.rod_waves(
        nrchain.Material.of(nrchain.load_scene("wave")), [0.01, 0.02]
    ),
    "nrchain.rod.Work": lambda: rod.Work(1.0, 1e-9),
    "nrchain.work.RunCost": lambda: work.cost_of(trajectory()),
    "nrchain.work.Stopwatch": work.Stopwatch,
    "nrchain.work.Work": lambda: work_precision().points[0].measured.work,
    "nrchain.units.Units": lambda: nrchain.units.Units(1e-6, 1.0, 1e-12),
}
"""One of each public class, by the shortest name it has."""
