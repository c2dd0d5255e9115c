"""Is the chain the solid of the paper: its symmetry classes, its moduli, work and waves?

Classes follow from the action of Rot and Ref on the blocks of a rod, moduli from the code of the
simulation. They are compared with the paper's tables, with the exact lattice for all pairs, and
with closed forms for uniform strain. The work of the chain in a cycle is measured in such states.
Waves of its rod are compared with the paper's equations, with the exact lattice, and with the
growth of a push on it. Source: the paper, Secs. III to VI and Appendix C.
"""

from __future__ import annotations

from validation.report.recorder import Recorder
from validation.solid import figures, moduli, symmetry, waves, work


def study(recorder: Recorder) -> None:
    recorder.step("symmetry")
    symmetry.compare(recorder)
    recorder.step("moduli")
    moduli.compare(recorder)
    recorder.step("work in cycles")
    work.compare(recorder)
    recorder.step("waves")
    waves.compare(recorder)
    recorder.step("figures")
    figures.draw(recorder)
    _findings(recorder)


def _findings(recorder: Recorder) -> None:
    recorder.text(
        "**The solid.** The classes of all 28 constants and every entry of the paper's table of "
        "moduli follow from the group action and from the code of the simulation. Three entries "
        "are misprinted. The printed matrix of a block has the sign of ↺ opposite to that of the "
        "equations of motion."
    )
    recorder.text(
        "**Waves.** The symbol of any material is the paper's for its four modes, and that of the "
        "lattice up to (qd)³. The bending law of 3a is an exception: a term in u‴ that the rod "
        "drops is of its size. Mixes of 2s and 3t turn from absolutely to convectively unstable "
        "where the pinch of the rod says so."
    )
    recorder.text(
        "**Two stresses.** The table is that of linear response. In a wave a source that changes "
        "with the gradient of the strain cannot be told from the divergence of a stress: linear "
        "response counts it as stress. What two halves of a bent chain exert on each other is half "
        "of that in C^{Fτ} and in the torques of C^{Mτ}, with lever arms besides. This stress does "
        "the work of a cycle, at any strain. With it the chain of 3t has an energy, where the "
        "printed moduli are odd. 3a and 4a are odd with both."
    )
