"""Outputs that cannot be written and inputs that cannot be read: each gives a one-line message.

Cases of a full or read-only disk use a small file system in memory, in a mount name space of their
own. If the machine allows none, a limit on the size of files emulates the full disk; the name of
the case says so.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

from nrchain import NrchainError, Scene, Trajectory, load_scene, resume, simulate
from validation.hard_cases.permissions import permissions_bind

DISK = 256 * 1024
"""Bytes of the small disk."""

NOT_TRIED = "not tried: permissions do not apply to this user"
"""Answer if root cannot give up the capabilities that bypass permissions."""

GOES_ON = ("a disk that fills up during the run",)
"""Cases that complete, because the whole file exists before the run starts."""


def message_of(attempt: Callable[[], object]) -> str:
    """The message of a refused attempt, or the end of its run."""
    try:
        ended = attempt()
    except NrchainError as error:
        return str(error)
    if not isinstance(ended, Trajectory):
        return "nothing"
    return ended.status if ended.cause is None else f"{ended.status} {ended.reason}"


def scene_of(snapshots: int) -> Scene:
    return load_scene("buckling", **{"run.end": 1.0, "run.snapshots": snapshots})


def plain(place: str) -> dict[str, str]:
    """Messages by case, for the cases that any machine can run, in an empty directory."""
    folder = Path(place)
    whole = folder / "whole.h5"
    simulate(scene_of(5), output=whole)
    (folder / "file").write_text("")
    bits = whole.read_bytes()
    found = {
        "no such directory": lambda: simulate(scene_of(5), output=folder / "none" / "x.h5"),
        "a file in place of a directory": lambda: simulate(
            scene_of(5), output=folder / "file" / "x.h5"
        ),
        "a device in place of a file": lambda: simulate(scene_of(5), output="/dev/full"),
        "a file that exists": lambda: simulate(scene_of(5), output=whole),
        "a file removed during the run": lambda: _removed(folder / "gone.h5"),
        "a file cut short during the run": lambda: _cut(folder / "shorter.h5"),
        "more snapshots than memory holds": lambda: simulate(scene_of(10**15)),
        "more snapshots than HDF5 can count": lambda: simulate(
            scene_of(2**62), output=folder / "huge.h5"
        ),
        "a truncated file": lambda: _open(folder / "cut.h5", bits[: len(bits) // 2]),
        "a file of noise": lambda: _open(folder / "noise.h5", bytes(range(256)) * 64),
        "an empty file": lambda: _open(folder / "empty.h5", b""),
    }
    answers = {name: message_of(attempt) for name, attempt in found.items()}
    answers |= _protected(folder, whole)
    return {name: text.replace(place, "…") for name, text in answers.items()}


def _protected(folder: Path, whole: Path) -> dict[str, str]:
    """Messages for paths whose permissions forbid writing."""
    scene, stopped = scene_of(5), folder / "stopped.h5"
    simulate(load_scene(scene, **{"run.max_steps": 3}), output=stopped)
    attempts = {
        "a file that may only be read": (
            whole,
            lambda: simulate(scene, output=whole, overwrite=True),
        ),
        "a run to resume that may only be read": (stopped, lambda: resume(stopped)),
        "a directory that may only be read": (
            folder,
            lambda: simulate(scene, output=folder / "x.h5"),
        ),
    }
    answers = {}
    with permissions_bind(folder) as bound:
        for name, (path, attempt) in attempts.items():
            mode = path.stat().st_mode
            path.chmod(0o555 if path.is_dir() else 0o444)
            answers[name] = message_of(attempt) if bound else NOT_TRIED
            path.chmod(mode)
    return answers


def _removed(path: Path) -> Trajectory:
    return simulate(scene_of(5), output=path, progress=lambda _: path.unlink(missing_ok=True))


def _cut(path: Path) -> Trajectory:
    return simulate(scene_of(5), output=path, progress=lambda _: os.truncate(path, 3000))


def _open(path: Path, content: bytes) -> Trajectory:
    path.write_bytes(content)
    return Trajectory.open(path)


def on_small_disk(place: str) -> dict[str, str]:
    """Messages on a disk of 256 kB or, if none can be mounted, under a limit on file sizes."""
    simulate(scene_of(5))
    if not mount(place):
        resource.setrlimit(resource.RLIMIT_FSIZE, (DISK, DISK))
        name = "no room on the disk (emulated: a limit on the size of files)"
        return {name: message_of(lambda: simulate(scene_of(150), output=Path(place) / "x.h5"))}
    folder = Path(place)
    room = shutil.disk_usage(folder).free
    answers = {
        "more than a disk of 256 kB holds": message_of(
            lambda: simulate(scene_of(1000), output=folder / "x.h5")
        ),
        # the arrays fit by count, and what HDF5 lays around them does not
        "no room on a disk of 256 kB": message_of(
            lambda: simulate(scene_of(_filling(room)), output=folder / "x.h5")
        ),
        "a disk that fills up during the run": message_of(
            lambda: simulate(
                scene_of(50), output=folder / "y.h5", progress=lambda _: _fill(folder / "filler")
            )
        ),
    }
    (folder / "filler").unlink()
    subprocess.run(["mount", "-o", "remount,ro", place], check=True, capture_output=True)
    answers["a disk that may only be read"] = message_of(
        lambda: simulate(scene_of(5), output=folder / "z.h5")
    )
    return {text: answer.replace(place, "…") for text, answer in answers.items()}


def mount(place: str) -> bool:
    """Mount a disk of :data:`DISK` bytes in our own name space; return whether it worked."""
    command = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "none", place]
    try:
        return subprocess.run(command, capture_output=True).returncode == 0
    except FileNotFoundError:
        return False


def _filling(room: int) -> int:
    """The largest number of snapshots that fits into ``room`` bytes."""
    particles = scene_of(2).chain.particles
    return room // (96 * particles + 24) - 2


def _fill(path: Path) -> None:
    """Fill the rest of the disk."""
    try:
        with path.open("ab", buffering=0) as file:
            while True:
                file.write(bytes(4096))
    except OSError:
        return


def namespace() -> list[str]:
    """The command that gives a process its own mounts; empty if there is none."""
    command = ["unshare", "--user", "--map-root-user", "--mount"]
    with tempfile.TemporaryDirectory() as place:
        probe = [*command, "mount", "-t", "tmpfs", "none", place]
        try:
            allowed = subprocess.run(probe, capture_output=True).returncode == 0
        except FileNotFoundError:
            allowed = False
    return command if allowed else []
