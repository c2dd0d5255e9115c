"""The studies by name, in the order of the report; each is imported when it runs.

A study is a module with a function ``study(recorder)``. Its docstring states the question and the
source of the answer. To add a study, add a row here.
"""

from __future__ import annotations

import importlib
import time
import traceback
from dataclasses import dataclass

from validation.report.recorder import Listener, Recorder
from validation.report.style import STYLE


@dataclass(frozen=True)
class Study:
    """Module and title of a study."""

    module: str
    title: str


STUDIES: dict[str, Study] = {
    "pair_laws": Study(
        "validation.pair_laws.run",
        "Pair laws: PyStokes, the closed forms and the paper, side by side",
    ),
    "flow": Study(
        "validation.flow.run",
        "The flow: at any points, against PyStokes and resolved spheres, directly and by a tree",
    ),
    "rest": Study("validation.rest.run", "The chain at rest: prestress, pre-moment, V₀ and Ω₀"),
    "linear_response": Study(
        "validation.linear_response.run",
        "Linear response: the lattice operator, the paper's equations and the continuum laws",
    ),
    "continuum": Study(
        "validation.continuum.run",
        "Continuum laws from simulation: growth rates and phase velocities",
    ),
    "long_range": Study(
        "validation.long_range.run",
        "Long range: all pairs, how many neighbours, and friction between the spheres",
    ),
    "solid": Study(
        "validation.solid.run",
        "The solid: symmetry classes, moduli of any chain, and work per cycle of strain",
    ),
    "spectrum": Study(
        "validation.spectrum.run",
        "Finite chains: rates about their states, buckling, coiling and flutter",
    ),
    "states": Study(
        "validation.states.run",
        "States: branches and their thresholds, oscillations that sustain themselves, phases",
    ),
    "rod": Study(
        "validation.rod.run",
        "The nonlinear rod: chain against rod at large deflections, and where they differ",
    ),
    "performance": Study(
        "validation.performance.run", "Performance: against common practice, and scaling with N"
    ),
    "cost": Study("validation.cost.run", "What accuracy costs in time: four work–precision maps"),
    "integrators": Study(
        "validation.integrators.run",
        "Integrators: which one for which class of scene, and what a tolerance means",
    ),
    "verification": Study(
        "validation.verification.run",
        "Verification: the error that a run estimates of itself, against its error",
    ),
    "effects": Study(
        "validation.effects.run",
        "Effects: what a plan predicts of each, and what a tolerance leaves out",
    ),
    "hard_cases": Study(
        "validation.hard_cases.run",
        "Hard cases: how each run ends, and which laws completed runs obey",
    ),
}


@dataclass(frozen=True)
class Outcome:
    """Result of a study: its records, its time in seconds, and the error that stopped it, or ""."""

    recorder: Recorder
    seconds: float
    error: str

    @property
    def passed(self) -> bool:
        return not self.recorder.failed


def run_study(name: str, *, quick: bool = False, listener: Listener | None = None) -> Outcome:
    """Run one study; an exception becomes a failed check with its message."""
    recorder = Recorder(name, quick=quick, listener=listener)
    begin, error = time.perf_counter(), ""
    try:
        from matplotlib import rc_context, rcdefaults, rcParams

        with rc_context():
            rcdefaults()  # figures do not depend on the settings of the user
            rcParams.update(STYLE)
            importlib.import_module(STUDIES[name].module).study(recorder)
    except Exception as stop:
        where = traceback.extract_tb(stop.__traceback__)[-1]
        error = f"{type(stop).__name__}: {stop} ({where.name}, line {where.lineno})"
        recorder.fail("the study runs to its end", error)
    return Outcome(recorder, time.perf_counter() - begin, error)
