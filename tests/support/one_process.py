"""A sweep in one thread of a process of its own."""

from __future__ import annotations

import pickle
import subprocess
import sys

SWEEP = """
import pickle, sys
import nrchain

changes, grid, observe, path = pickle.loads(bytes.fromhex(sys.argv[1]))
found = nrchain.sweep(
    nrchain.load_scene("buckling", **changes), grid, observe=observe, workers=1
)
with open(path, "wb") as file:
    pickle.dump(found, file)
"""


def in_one_process(changes, grid, observe, path):
    """The sweep of ``buckling`` with changes; ``path`` is a file for it.

    A process that compiles a kernel may round differently from those that load it. A test of
    several processes runs such a sweep in its own process before: all kernels are then on disk.
    """
    given = pickle.dumps((changes, grid, observe, str(path))).hex()
    subprocess.run([sys.executable, "-c", SWEEP, given], check=True)
    return pickle.loads(path.read_bytes())
