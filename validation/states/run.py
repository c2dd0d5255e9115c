"""Which states does a chain have, where do they change, and what does it end in?

Pushers buckle, 3a coils with both hands, and 2s with 3t oscillates by itself: the paper leaves open
whether chains with apolar and polar modes can. Branches of states are compared with zeros of the
spectrum, with Euler's loads, with the square root laws of their onsets, and with runs that start
next to them: every state attracts or repels a chain at the rate of its leading mode. Phase diagrams
show what runs end in. A filament with a follower force is compared with the literature.
"""

from __future__ import annotations

from validation.report.recorder import Recorder
from validation.states.benchmark import benchmark
from validation.states.buckling import buckling, coils
from validation.states.cycles import cycles
from validation.states.diagrams import diagrams
from validation.states.figures import BRANCHES_CAPTION, branches
from validation.states.mixes import mixes
from validation.states.speed import speed


def study(recorder: Recorder) -> None:
    recorder.step("pushers buckle")
    pushers = buckling(recorder)
    recorder.step("3a coils")
    coils(recorder)
    mix = mixes(recorder)
    recorder.figure("state-branches", branches(pushers, mix), BRANCHES_CAPTION)
    cycles(recorder)
    benchmark(recorder)
    recorder.step("costs")
    speed(recorder)
    diagrams(recorder)
    recorder.text(
        "Chains with apolar and polar modes **oscillate by themselves**. A clamped chain of "
        "pushers with 3t straightens at one strength of 3t and begins to go round at a larger "
        "one, at the frequency of the mode that turns unstable there. Amplitudes grow as the "
        "square root of the distance from this Hopf point. Cycles attract runs, or repel them, at "
        "the rate of their Floquet multipliers."
    )
