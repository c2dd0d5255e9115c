"""Kernels on disk match the sources beside them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba import types
from numba.core.compiler import Flags

import nrchain
import nrchain._compile as compiled
from nrchain._linking import KernelFlags

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


def test_the_name_of_a_kernel_depends_on_the_constants_beside_it(tmp_path, monkeypatch):
    """A table that a kernel compiles in stands in a module of its own, without kernels."""
    monkeypatch.setattr(compiled, "__file__", str(tmp_path / "_compile.py"))
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "called.py").write_text(CALLED.format(factor=2.0))
    names = set()
    for value in (1.0, 2.0):
        (tmp_path / "deep" / "constants.py").write_text(f"NODE = {value}")
        names.add(compiled.sources.__wrapped__())
    assert len(names) == 2


def test_the_name_of_a_kernel_depends_on_every_module_with_kernels(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled, "__file__", str(tmp_path / "_compile.py"))
    (tmp_path / "deep").mkdir()

    def kernel_name(factor, name="called", other=""):
        for path in tmp_path.rglob("*.py"):
            path.unlink()
        (tmp_path / "deep" / f"{name}.py").write_text(CALLED.format(factor=factor))
        (tmp_path / "plain.py").write_text(other)
        return compiled.sources.__wrapped__()

    assert kernel_name(2.0) == kernel_name(2.0) == kernel_name(2.0, other="x = 1")
    assert (
        len(
            {
                kernel_name(2.0),
                kernel_name(3.0),
                kernel_name(2.0, "renamed"),
                kernel_name(2.0, other=CALLER),
            }
        )
        == 4
    )


@pytest.fixture
def nowhere(tmp_path):
    """Run a command where neither the package nor the user's cache can be written, for root too."""
    package = tmp_path / "p"
    package.mkdir()
    for name, text in (("caller", CALLER), ("called", CALLED.format(factor=2.0))):
        (package / f"{name}.py").write_text(text)
    shutil.copy(Path(compiled.__file__), package)
    ours = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(nrchain.__file__).parent, tmp_path / "nrchain", ignore=ours)
    folders = [package, *(path.parent for path in (tmp_path / "nrchain").rglob("*.py"))]
    for folder in set(folders):
        # a file in the place of the folder keeps everybody from writing into it
        (folder / "__pycache__").touch()
    (tmp_path / "temporary").mkdir()

    def run(*command, **environment):
        unset = {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null", "MPLCONFIGDIR": str(tmp_path)}
        unset["TMPDIR"] = str(tmp_path / "temporary")
        inherited = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", *unset)}
        return subprocess.run(
            [sys.executable, *command],
            cwd=tmp_path,
            env=inherited | unset | environment,
            capture_output=True,
            text=True,
            check=True,
        )

    return run


def test_kernels_go_to_a_temporary_folder_where_nothing_else_can_be_written(nowhere, tmp_path):
    first, second = nowhere("-c", SCRIPT), nowhere("-c", SCRIPT)
    assert first.stdout.split() == ["2.0", "0"]
    assert second.stdout.split() == ["2.0", "1"]
    assert first.stderr.count("NUMBA_CACHE_DIR") == 1
    assert str(tmp_path / "temporary") in first.stderr


def test_the_setting_that_the_warning_names_keeps_kernels(nowhere, tmp_path):
    kept = {"NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    assert nowhere("-c", SCRIPT, **kept).stderr == ""
    assert nowhere("-c", SCRIPT, **kept).stdout.split() == ["2.0", "1"]


def test_kernels_of_a_folder_that_others_can_write_to_are_not_loaded(nowhere, tmp_path):
    nowhere("-c", SCRIPT)
    (open_to_all,) = (tmp_path / "temporary").glob("nrchain-kernels-*")
    open_to_all.chmod(0o777)
    after = nowhere("-c", SCRIPT)
    assert after.stdout.split() == ["2.0", "0"]
    assert f"in {open_to_all}," not in after.stderr


def test_a_temporary_folder_is_kept_to_if_it_is_ours_and_not_if_another_made_it(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    folder_of = compiled.temporary_folder.__wrapped__
    with pytest.warns(RuntimeWarning, match="NUMBA_CACHE_DIR"):
        folders = [folder_of() for _ in range(2)]
    assert folders == [tmp_path / f"nrchain-kernels-{os.getuid()}"] * 2
    another = os.getuid() + 1
    monkeypatch.setattr("os.getuid", lambda: another)
    # under the name of that user there is a folder, but it belongs to the real one
    with pytest.warns(RuntimeWarning, match="NUMBA_CACHE_DIR"):
        safe = folder_of()
    assert safe.parent == tmp_path
    assert safe.name != f"nrchain-kernels-{another}"
    assert safe.stat().st_mode & 0o077 == 0


def test_kernels_are_compiled_where_no_folder_can_be_written_at_all(nowhere):
    # Python looks for a temporary folder in the working directory too, where it can be written
    hide = "import tempfile; tempfile.tempdir = '/dev/null'\n"
    for _ in range(2):
        done = nowhere("-c", hide + SCRIPT)
        assert done.stdout.split() == ["2.0", "0"]
        assert done.stderr.count("compiled again by every process") == 1


def test_every_command_runs_there_and_says_so_in_one_line(nowhere):
    assert "buckling" in nowhere("-m", "nrchain", "scenes").stdout
    done = nowhere("-m", "nrchain", "effects")
    assert "stretch" in done.stdout
    (line,) = done.stderr.splitlines()
    assert line.startswith("nrchain: warning: ")
    assert "NUMBA_CACHE_DIR" in line


needs_linking = pytest.mark.skipif(
    not compiled.LINKS, reason="this release of Numba compiles in its own way"
)


@compiled.part
def _doubled(x):
    return 2.0 * x


@compiled.part
def _doubled_and_one(x):
    return _doubled(x) + 1.0


@needs_linking
def test_a_part_has_no_machine_code_and_is_linked_into_kernels():
    """Parts may call parts, and a second kernel finds the same instructions again."""

    @compiled.kernel
    def same(x):
        return _doubled_and_one(x)

    @compiled.kernel
    def added(x):
        return _doubled_and_one(x) + _doubled(x)

    assert (same(3.0), added(3.0)) == (7.0, 13.0)
    for function in (_doubled, _doubled_and_one):
        # kernels that come from disk compile no parts
        function.compile((types.float64,))
        (result,) = function.overloads.values()
        assert result.library.get_pointer_to_function(result.fndesc.llvm_func_name) == 0


@needs_linking
def test_options_of_kernels_compare_as_those_of_numba():
    given = Flags()
    given.nrt = True
    for other in (Flags(), given.copy()):
        ours = KernelFlags(other)
        assert (ours == KernelFlags(given)) is (ours == given) is (other == given)
        assert hash(ours) == hash(other)


@needs_linking
def test_a_kernel_that_python_has_not_called_is_a_part_of_others():
    @compiled.kernel
    def tripled(x):
        return 3.0 * x

    @compiled.kernel
    def tripled_and_one(x):
        return tripled(x) + 1.0

    assert tripled_and_one(2.0) == 7.0
    assert not tripled.overloads
    assert tripled(2.0) == 6.0


@pytest.mark.parametrize(
    ("release", "links"),
    [
        ("0.59.0", False),
        ("0.63.1", False),
        ("0.64.0", True),
        ("0.68.1", True),
        ("0.69.0rc1", False),
    ],
)
def test_parts_are_linked_with_the_releases_of_numba_in_which_that_was_tried(release, links):
    assert compiled.links_parts(release) is links


@pytest.mark.parametrize("links", [compiled.LINKS, False])
def test_kernels_and_parts_also_compile_in_the_way_of_numba(links, monkeypatch):
    monkeypatch.setattr(compiled, "LINKS", links)

    @compiled.part
    def square(x):
        return x * x

    @compiled.kernel
    def tripled(x):
        return 3.0 * x

    @compiled.kernel
    def both(x):
        return square(x) + tripled(x)

    assert (both(2.0), tripled(2.0)) == (10.0, 6.0)
