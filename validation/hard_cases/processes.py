"""Runs in separate processes: with other numbers of threads, killed, or long."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nrchain import Scene, load_scene
from validation.hard_cases.outputs import namespace

ROOT = Path(__file__).parents[2]

START, MARK, STATE = "/nrchain/finished", "/checkpoints/sequence", "/checkpoints/state"
"""Data sets; a run is killed before it writes to one of them."""


@dataclass(frozen=True)
class Killed:
    """A killed run: when, the state of its file, where it resumed, and whether the bits agree."""

    when: str
    status: str
    snapshots: int
    begin: float | None
    agreed: bool


def answer(
    task: str, threads: int | None = None, within: Sequence[str] = (), **given: Any
) -> dict[str, Any]:
    """Run a task of :mod:`validation.hard_cases.child` in a process; return its answer.

    ``within`` is a command that wraps the process, ``threads`` its number of threads.
    """
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    more = {} if threads is None else {"NUMBA_NUM_THREADS": str(threads)}
    done = subprocess.run(
        [*within, sys.executable, "-m", "validation.hard_cases.child", task],
        input=json.dumps(given),
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": path} | more,
    )
    if done.returncode:
        raise RuntimeError(f"{task}: exit code {done.returncode}: {done.stderr[-500:]}")
    return json.loads(done.stdout.splitlines()[-1])


def digests(scene: Scene, threads: tuple[int, ...]) -> set[str]:
    """Hashes of the results of runs with these numbers of threads."""
    return {answer("digest", number, scene=scene.to_toml())["digest"] for number in threads}


def outputs() -> dict[str, str]:
    """Messages by case, for outputs that cannot be written or read."""
    with tempfile.TemporaryDirectory() as place:
        plain, disk = Path(place, "plain"), Path(place, "disk")
        plain.mkdir()
        disk.mkdir()
        return {
            **answer("outputs", place=str(plain))["messages"],
            **answer("small_disk", within=namespace(), place=str(disk))["messages"],
        }


def soak(directory: Path, steps: int) -> dict[str, Any]:
    """Memory growth of a run of ``steps`` steps that never comes to rest.

    The axis of the slip is tilted, so the chain tumbles. The first tenth of the run is not counted.
    """
    scene = load_scene(
        {
            "chain": {"particles": 4},
            "elasticity": {"stretch": 20.0, "shear": 20.0},
            "slip": {"4a": {"strength": 3000.0, "axis": [1.0, 0.3, 0.0]}},
            "start": {"shape": "random"},
            "run": {"end": 1e4, "snapshots": 1001, "max_steps": steps},
        }
    )
    path = str(directory / "soak.h5")
    return answer("soak", scene=scene.to_toml(), path=path, warm=steps // 10)


def kills_resumed(directory: Path, times: int, seed: int = 0, end: float = 200.0) -> list[Killed]:
    """Kill runs, resume them, and compare their bits with those of an uninterrupted run.

    A third of the moments are random in time, another third random among the writes to the file.
    The others are before the first snapshot counts, and between the data of a checkpoint, or of a
    snapshot, and the mark that makes it count. All runs load their kernels from disk.
    """
    snapshots = {"run.end": end, "run.snapshots": round(2 * end) + 1}
    scene = load_scene("spiral-left", **snapshots).to_toml()
    # this process compiles the kernels that the others load from disk
    whole = answer("write", scene=scene, path=str(directory / "whole.h5"))
    rng = np.random.default_rng(seed)
    paths = [str(directory / f"killed-{number}.h5") for number in range(times)]
    written = whole["written"]
    places = _places(written, times, rng)
    moments = rng.uniform(0.0, whole["seconds"], times).tolist()
    killed = answer("kill", scene=scene, paths=paths, places=places, seconds=moments)["killed"]
    found = answer("resume", paths=paths, scene=scene)
    return [
        Killed(
            f"before write {place} of {len(written)}, to {written[place - 1].lstrip('/')}"
            if place
            else f"after {moment:.3f} of {whole['seconds']:.3f} s",
            run["status"] if dead else "not killed",
            run["snapshots"],
            run["from"],
            run["digest"] == found["digest"],
        )
        for place, moment, dead, run in zip(places, moments, killed, found["runs"], strict=True)
    ]


def _places(written: list[str], times: int, rng: np.random.Generator) -> list[int]:
    """Numbers of the writes before which to kill; 0 for a random time."""
    third = times // 3
    anywhere = rng.integers(1, len(written) + 1, third).tolist()
    chosen = []
    for number in range(times - 2 * third):
        name = (START, MARK, STATE, START)[number % 4]
        counts = [count for count, one in enumerate(written, 1) if one.endswith(name)]
        chosen.append(counts[0] if number == 0 else int(rng.choice(counts)))
    return [*chosen, *anywhere, *[0] * third]
