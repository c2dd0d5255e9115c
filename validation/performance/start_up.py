"""The time of the first command of the README over that of its libraries and of a compilation.

Processes take turns, and the time is the processor's: a ratio is then the same on a slow machine,
and on a busy one.
"""

from __future__ import annotations

import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from validation.performance.scenes import PROJECT
from validation.performance.timing import child_environment
from validation.report.recorder import Recorder

LIBRARIES = "import numba, scipy.linalg, sksundae.cvode, matplotlib.figure"
"""What a run needs whatever the package does."""

COMPILATION = str(Path(__file__).with_name("fixed_compilation.py"))

BEFORE = 3.1
"""Cold start over the fixed compilation, of commit b17b23b: measured in turns."""

COLD = 4.1
"""The same, as measured since functions that only kernels call are optimised once."""

FURTHER = 0.25
"""Largest start of a further scene over the cold start."""

TURNS = 5

COMBINATIONS: dict[str, tuple[str, ...]] = {
    "free ends": ("chain.ends=free",),
    "periodic": ("chain.ends=periodic",),
    "3a and 4a beside 2s": ("slip.3a=10.0", "slip.4a=10.0"),
    "slip of all pairs": ("slip.neighbours=all",),
    "steric repulsion": ("steric.kind=wca", "steric.strength=1.0"),
    "uniform force": ("field.force=[0.0, 0.0, -0.001]",),
    "shear flow": ("flow.gradient=[[0, 1e-3, 0], [0, 0, 0], [0, 0, 0]]",),
    "friction between spheres": ("friction=pairwise",),
}
"""Scenes that differ from the shipped one in modes, ends or effects. They run to :data:`END`."""

END = "run.end=10"


def compare(recorder: Recorder) -> None:
    """Record warm and cold starts of ``nrchain run buckling``, and those of further scenes."""
    if recorder.quick:
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cold, fixed = [], []
        for _ in range(3):
            shutil.rmtree(folder / "kernels", ignore_errors=True)
            cold.append(_command(folder))
            fixed.append(processor_time([COMPILATION], folder))
        turns = [
            (_command(folder), processor_time(["-c", LIBRARIES], folder)) for _ in range(TURNS)
        ]
        further = {words: _further(folder, changes) for words, changes in COMBINATIONS.items()}
    warm, imports = (float(np.median(values)) for values in zip(*turns, strict=True))
    first, compilation = float(np.median(cold)), float(np.median(fixed))
    recorder.benchmark(
        "nrchain run buckling, warm against cold",
        warm,
        first,
        what="the whole command, with kernels on disk and with an empty cache, in seconds of the "
        f"processor; its libraries alone take {imports:.2f} s, and a fixed compilation "
        f"{compilation:.2f} s",
    )
    recorder.bound(
        "warm start of nrchain run buckling over the import of its libraries",
        np.median([ours / theirs for ours, theirs in turns]),
        most=1.5,
        source=PROJECT,
    )
    recorder.shortfall(
        "cold start of nrchain run buckling over a fixed compilation",
        first / compilation,
        asked=BEFORE,
        reached=COLD,
        source="Radau IIA compiles its steps, its charts and two eliminations, in 9 s more of the "
        "processor than CVODE, once an installation",
    )
    recorder.table(
        "Start of further scenes",
        ["Scene", "Processor time (s)", "Over the cold start"],
        [(words, seconds, seconds / first) for words, seconds in further.items()],
        "nrchain run buckling with changes, when the kernels of the scene as shipped are on disk.",
    )
    recorder.bound(
        "start of a further scene over the cold start, at most",
        max(further.values()) / first,
        most=FURTHER,
        source=PROJECT,
    )


def _further(folder: Path, changes: tuple[str, ...]) -> float:
    """Seconds of the command with changes, with no more kernels than those of the scene."""
    other = folder / "other"
    shutil.copytree(folder / "kernels", other / "kernels")
    try:
        return _command(other, *(word for change in (*changes, END) for word in ("--set", change)))
    finally:
        shutil.rmtree(other)


def _command(folder: Path, *changes: str) -> float:
    """Seconds of ``nrchain run buckling`` with its kernels kept in ``folder``."""
    place = str(folder / "run")
    return processor_time(
        ["-m", "nrchain", "run", "buckling", "-o", place, "--overwrite", *changes], folder
    )


def processor_time(arguments: list[str], folder: Path) -> float:
    """Processor time of a Python process, in seconds.

    It may write bytecode, which an installed package has.
    """
    environment = child_environment() | {"NUMBA_CACHE_DIR": str(folder / "kernels")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    before = _children()
    subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, check=True
    )
    return _children() - before


def _children() -> float:
    """Processor time of the children of this process that have ended, in seconds."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime
