"""Call the command line in a test: in this process or in one of its own, with a stub for runs."""

import subprocess
import sys
from functools import cache

import numpy as np
import typer.main
import typer.testing
from typer.testing import CliRunner

from nrchain.cli.app import app
from nrchain.cli.exits import REFUSED
from nrchain.run.recording import Progress
from nrchain.trajectory.block import Block
from nrchain.trajectory.trajectory import Trajectory
from nrchain.trajectory.writer import TrajectoryWriter

SMALL = ("--set", "chain.particles=3", "--set", "run.end=0.1", "--set", "run.snapshots=2")


built = cache(typer.main.get_command)
"""The command of an application, built once: that takes longer than most commands do."""

typer.testing._get_command = built


def call(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def assert_refused(result, *parts, code=REFUSED):
    """The code, and one line on stderr that has the parts and is no traceback."""
    assert result.exit_code == code
    assert len(result.stderr.splitlines()) == 1
    assert result.stderr.startswith("nrchain: ")
    for part in parts:
        assert str(part) in result.stderr


def program(*arguments, **options):
    """A process of its own, as from a shell."""
    return subprocess.run(
        [sys.executable, "-m", "nrchain", *map(str, arguments)],
        **{"stderr": subprocess.PIPE, "text": True, "check": False} | options,
    )


class Stub:
    """Stands in for simulate and resume; writes straight chains and ends as a test says."""

    def __init__(self):
        self.scene = None
        self.error = None
        self.reason = ""
        self.reached = None

    def simulate(self, scene, *, output, overwrite=False, progress=None, choice=None, start=None):
        self.scene = scene
        times = np.linspace(0.0, scene.run.end, scene.run.snapshots)
        with TrajectoryWriter(output, scene, times, overwrite=overwrite, choice=choice) as writer:
            self.fill(writer, range(self.reached or len(times)), progress)
        return Trajectory.open(output)

    def resume(self, path, *, unwatched=False, until=None, progress=None):
        with TrajectoryWriter.reopen(path) as writer:
            self.scene = writer.scene
            begin = len(Trajectory.open(path).time)
            self.fill(writer, range(begin, len(writer.times)), progress)
        return Trajectory.open(path)

    def fill(self, writer, indices, progress):
        particles, count = writer.scene.chain.particles, len(writer.times)
        positions = np.zeros((particles, 3))
        positions[:, 0] = 10.0 * np.arange(particles)
        frames = np.broadcast_to(np.eye(3), (particles, 3, 3))
        for index in indices:
            time = float(writer.times[index])
            writer.write(index, Block.of_one(time, positions, frames, index))
            counters = {"steps": 7 * index, "wall_time": 0.5}
            writer.update_counters(counters)
            if progress:
                end = float(writer.times[-1])
                progress(Progress(time, end, index + 1, count, counters, 0.5))
        if self.error:
            raise self.error
        writer.close("stopped" if self.reason else "completed", self.reason)
