"""Kernels kept on disk are those of the sources that lie beside them."""

import shutil
import subprocess
import sys
from pathlib import Path

import nrchain._compile as compiled

CALLER = (
    "from p._compile import kernel\nfrom p.called import g\n\n@kernel\ndef f(x):\n    return g(x)\n"
)
CALLED = "from p._compile import kernel\n\n@kernel\ndef g(x):\n    return {factor} * x\n"
SCRIPT = """
from p.caller import f
print(f(1.0), sum(f.stats.cache_hits.values()))
"""


def test_a_kernel_is_compiled_again_when_one_it_calls_has_changed(tmp_path):
    package = tmp_path / "p"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "caller.py").write_text(CALLER)
    shutil.copy(Path(compiled.__file__), package)

    def run(factor):
        (package / "called.py").write_text(CALLED.format(factor=factor))
        command = [sys.executable, "-c", SCRIPT]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        return done.stdout.split()

    assert run(2.0) == ["2.0", "0"]
    assert run(2.0) == ["2.0", "1"]
    assert run(3.0) == ["3.0", "0"]
