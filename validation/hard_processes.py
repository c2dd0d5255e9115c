"""Runs in processes of their own: killed, given other threads, or with nowhere to write to."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from nrchain import Trajectory, TrajectoryError, load_scene, resume, simulate
from nrchain.scene import Scene

_RUN = """
import sys, resource, nrchain
if len(sys.argv) > 3:
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]),) * 2)
scene = nrchain.Scene.from_toml(open(sys.argv[1]).read())
try:
    nrchain.simulate(scene, output=sys.argv[2], overwrite=True)
except nrchain.NrchainError as error:
    print(error)
    sys.exit(2)
"""

_DIGEST = """
import sys, hashlib, nrchain
scene = nrchain.Scene.from_toml(sys.stdin.read())
print(hashlib.sha256(nrchain.simulate(scene).positions.tobytes()).hexdigest())
"""


def _child(scene: Scene, path: Path, *more: str) -> subprocess.Popen[str]:
    text = path.with_suffix(".toml")
    text.write_text(scene.to_toml())
    return subprocess.Popen(
        [sys.executable, "-c", _RUN, str(text), str(path), *more],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def kills_resumed(directory: Path, times: int, seed: int = 0) -> tuple[int, int]:
    """(killed, agreed): runs killed at random moments, and how many went on to the same bits."""
    scene = load_scene("spiral-left", **{"run.end": 200.0, "run.snapshots": 401})
    began = time.perf_counter()
    whole = simulate(scene, output=directory / "whole.h5")
    seconds = time.perf_counter() - began
    rng, killed, agreed = np.random.default_rng(seed), 0, 0
    for number in range(times):
        path = directory / f"killed-{number}.h5"
        child = _child(scene, path)
        while child.poll() is None and not path.exists():
            time.sleep(0.002)
        time.sleep(seconds * rng.uniform(0.0, 0.7))
        child.kill()
        child.communicate()
        killed += Trajectory.open(path).status == "running"
        try:
            again = resume(path)
        except TrajectoryError:
            # killed before its first checkpoint: said so, and is run again
            again = simulate(scene, output=path, overwrite=True)
        agreed += np.array_equal(again.positions, whole.positions) and np.array_equal(
            again.frames, whole.frames
        )
    return killed, agreed


def digests(scene: Scene, threads: tuple[int, ...]) -> set[str]:
    """What runs with these numbers of threads leave, each by its hash."""
    return {
        subprocess.run(
            [sys.executable, "-c", _DIGEST],
            input=scene.to_toml(),
            env=os.environ | {"NUMBA_NUM_THREADS": str(number)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for number in threads
    }


def unwritable(directory: Path) -> dict[str, str]:
    """How runs end that cannot write, or read what was cut short, each in one line."""
    scene = load_scene("buckling", **{"run.end": 1.0})
    child = _child(scene, directory / "full.h5", "65536")
    told, trace = child.communicate()
    found = {"no room on the disk": told.strip() if child.returncode == 2 else trace[-300:]}
    blocked = directory / "file"
    blocked.write_text("")
    simulate(scene, output=directory / "cut.h5")
    whole = (directory / "cut.h5").read_bytes()
    (directory / "cut.h5").write_bytes(whole[: len(whole) // 2])
    attempts = {
        "no such directory": lambda: simulate(scene, output=directory / "none" / "x.h5"),
        "a file in place of a directory": lambda: simulate(scene, output=blocked / "x.h5"),
        "a truncated file": lambda: Trajectory.open(directory / "cut.h5"),
    }
    for name, attempt in attempts.items():
        try:
            attempt()
            found[name] = ""
        except TrajectoryError as error:
            found[name] = str(error)
    return {name: text.replace(str(directory), "…") for name, text in found.items()}
