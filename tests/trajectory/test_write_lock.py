"""Where a file is claimed, a system without file locks is refused in the README's words."""

import subprocess
import sys
from pathlib import Path

import pytest

from nrchain.cli.exits import REFUSED
from nrchain.errors import SYSTEMS

README = Path(__file__).parents[2] / "README.md"
WITHOUT = "import sys; sys.modules['fcntl'] = None; "


def without_fcntl(code, tmp_path):
    command = [sys.executable, "-c", WITHOUT + code]
    return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)


def test_the_readme_names_the_systems():
    assert SYSTEMS in " ".join(README.read_text(encoding="utf-8").split())


@pytest.mark.parametrize("error", ["ImportError", "nrchain.NrchainError"])
def test_importing_that_part_elsewhere_fails_with_that_sentence(error, tmp_path):
    code = f"import nrchain\ntry:\n    nrchain.simulate\nexcept {error} as e:\n    print(e)"
    ended = without_fcntl(f"exec({code!r})", tmp_path)
    assert (ended.stdout, ended.returncode) == (SYSTEMS + "\n", 0), ended.stderr


def test_the_command_says_it_in_one_line_and_makes_nothing(tmp_path):
    code = "sys.argv = ['nrchain', 'run', 'passive']; from nrchain.__main__ import main; main()"
    ended = without_fcntl(code, tmp_path)
    assert ended.stderr.strip().endswith(SYSTEMS)
    assert "Traceback" not in ended.stderr
    assert ended.returncode == REFUSED
    assert not list(tmp_path.iterdir())


def test_what_needs_no_file_runs_anywhere(tmp_path):
    ended = without_fcntl("import nrchain; print(*nrchain.scene_names())", tmp_path)
    assert "buckling" in ended.stdout
