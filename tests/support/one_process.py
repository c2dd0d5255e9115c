"""A sweep by the command line, in one thread of a process of its own."""

from __future__ import annotations

import nrchain
from support.command_line import program


def in_one_process(scene, folder, *words):
    """The sweep of a scene whose changes are ``scene``, with further words of the command.

    A process that compiles a kernel may round differently from those that load it. A test of
    several processes calls this before, so that all kernels are on disk, and compares with a call
    after.
    """
    changes = [word for key, value in scene.items() for word in ("--set", f"{key}={value}")]
    result = program("sweep", "buckling", *changes, *words, "-o", folder, "--workers", 1)
    assert result.returncode == 0, result.stderr
    return nrchain.Sweep.open(folder)
