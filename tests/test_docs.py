"""README, docs and CONTRIBUTING: blocks run, commands and files exist, keys are the code's."""

import configparser
import itertools
import re
import shlex
import subprocess
import tomllib
import typing
from pathlib import Path

import numpy as np
import pytest
from support.command_line import built
from support.pages import blocks, commands, run_page, text_of
from support.poses import pose_derivative, random_chain

import nrchain
from nrchain import slip_modes
from nrchain.cli.app import app
from nrchain.effects import registry
from nrchain.effects.registry import effects, section_kinds
from nrchain.motion.integrators import INTEGRATORS
from nrchain.motion.model import Model
from nrchain.outcome import Cause
from nrchain.scene.scene import Scene
from nrchain.trajectory.layout import LAYOUT
from validation.__main__ import app as validation_app
from validation.report.studies import STUDIES

ROOT = Path(__file__).parents[1]
DOCS = sorted((ROOT / "docs").rglob("*.md"))
PAGES = {
    str(path.relative_to(ROOT / "docs")) if path in DOCS else path.name: path
    for path in (ROOT / "README.md", *DOCS, ROOT / "CONTRIBUTING.md")
}
SCENES, RUNNING, EFFECTS = (PAGES[f"{name}.md"] for name in ("scenes", "running", "effects"))

SHELL = {">", "|", "&&", ";"}
"""Words that end a command in a line of a shell."""

GENERIC = {
    "[-o": "-o",
    "[--set": "--set",
    "DIR]": "DIR",
    "key=value": "slip.2s=1",
    "SECONDS]": "1",
    "KEY=LOW:HIGH": "slip.2s=0:1",
    "KEY=VALUES": "slip.2s=0:1:3",
    "NAMES": "end.size",
    "PATH[:FRAME]]": "runs/mine:2",
    "TIME]": "40",
    "T]": "1",
    "FILE": "run.gsd",
}
"""What stands in a usage line of a command, and a value for it."""


def blocks_in(page, language):
    return [block.text for block in blocks(page) if block.language == language]


def rows(text):
    """The cells of every table row, without those of heads and rules."""
    lines = re.findall(r"^\| (.*) \|$", text, re.M)
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)] for line in lines]


@pytest.fixture
def registries(monkeypatch):
    """Modes and effects that an example registers are known to it alone."""
    effects()  # all files of the package are read
    monkeypatch.setattr(slip_modes, "_MODES", dict(slip_modes._MODES))
    monkeypatch.setattr(registry, "_EFFECTS", dict(registry._EFFECTS))


RUN = {"python", "sh"}


@pytest.mark.parametrize(
    "name", [n for n, page in PAGES.items() if RUN & {b.language for b in blocks(page)}]
)
def test_blocks_run(name, registries, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    run_page(PAGES[name])


@pytest.mark.parametrize("name", PAGES)
def test_blocks_that_are_not_run_say_why_and_can_be_read(name):
    for block in blocks(PAGES[name]):
        if block.reason and block.language == "sh":
            assert len(block.reason.split()) > 2
            subprocess.run(["bash", "-n", "-c", block.text], check=True)
        elif block.reason:
            assert block.language == "python"
            compile(block.text, name, "exec")


@pytest.mark.parametrize("name", [n for n in PAGES if blocks_in(PAGES[n], "toml")])
def test_toml_examples_are_scenes(name):
    for block in blocks_in(PAGES[name], "toml"):
        table = tomllib.loads(block)
        base = table if "chain" in table else "passive"
        assert isinstance(nrchain.load_scene(base, **table), Scene)


def commands_of(page):
    """Every command that a page names, with or without arguments, as words."""
    shown = [line for block in blocks_in(page, "sh") for line in commands(block)]
    shown += re.findall(r"`([^`]*)`", re.sub(r"```.*?```", "", text_of(page), flags=re.S))
    for line in shown:
        words = shlex.split(line.replace("\\|", "|"), comments=True)
        words = list(itertools.takewhile(lambda word: word not in SHELL, words))
        words = [word for word in words if word not in ("...]", "[--overwrite]", "[--verify]")]
        words = [GENERIC.get(word, word) for word in words]
        if words[:1] == ["nrchain"] and len(words) > 1:
            yield [word.strip("[]") for word in words]
        if words[:3] == ["python", "-m", "validation"]:
            yield words


@pytest.mark.parametrize("name", PAGES)
def test_commands_exist_with_their_options(name, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for words in commands_of(PAGES[name]):
        if words[0] == "python":
            command, arguments = built(validation_app), words[3:]
            studies = command.make_context("validation", arguments).params["names"] or ()
            assert set(studies) <= set(STUDIES)
            continue
        if words[1] == "COMMAND" or words[1].startswith("--"):
            continue
        group = built(app)
        context = group.make_context("nrchain", ["effects"])
        _, command, arguments = group.resolve_command(context, words[1:])
        if arguments:
            command.make_context(words[1], arguments)


@pytest.mark.parametrize("name", PAGES)
def test_links_and_paths_exist(name):
    page = PAGES[name]
    for target in re.findall(r"\]\(([^)\s]+)\)", text_of(page)):
        if target.startswith("http"):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path) if path else page
        assert file.exists(), target
        heads = re.findall(r"^#+ (.*)$", text_of(file), re.M) if file.suffix == ".md" else []
        slugs = {re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-") for head in heads}
        assert not anchor or anchor in slugs, target
    for path in re.findall(r"`((?:nrchain|validation|tests|docs)/[\w/.-]*)`", text_of(page)):
        assert (ROOT / path).exists(), path


def defaults():
    """The default of every key of a scene, by its dotted name; ``...`` where it is required."""
    hints = typing.get_type_hints(Scene)
    kinds = [hints[name] for name in ("chain", "elasticity", "slip", "friction")]
    for kind in (*kinds, *section_kinds().values(), hints["start"], hints["run"]):
        plain = kind(**{n: {"particles": 2, "end": 1.0}[n] for n in required(kind)})
        for key in kind.spellings():
            value = ... if key in required(kind) else getattr(plain, key)
            yield kind.key(key), value
    yield from (("title", ""), ("effects", "named"), ("tolerance", None))


def required(kind):
    return {"chain": ["particles"], "run": ["end"]}.get(kind.path, [])


def test_every_key_of_a_scene_is_listed_with_its_default():
    listed = {}
    for heading, text in re.findall(
        r"^## (\[\w+\]|Keys at the top)$(.*?)(?=^## )", text_of(SCENES), re.S | re.M
    ):
        prefix = heading.strip("[]") + "." if heading.startswith("[") else ""
        for key, _, _, default, *_ in rows(text)[2:]:
            for name in re.findall(r"`(\w+)`", key):
                listed[prefix + name] = default
    slips = {f"slip.{mode.label}": None for mode in slip_modes.modes()}
    known = dict(defaults()) | slips
    assert set(listed) == set(known)
    for key, value in known.items():
        shown = {"required": ..., "–": None}.get(listed[key], listed[key])
        if isinstance(shown, str):
            shown = tomllib.loads(f"value = {shown.strip('`')}")["value"]
        given = np.array(value).tolist() if isinstance(value, tuple) else value
        assert shown == given, key


def test_what_the_keys_are_for_is_what_comments_in_scenes_say():
    kinds = [Scene, *(typing.get_type_hints(Scene)[n] for n in ("chain", "elasticity", "slip"))]
    kinds += [typing.get_type_hints(Scene)[name] for name in ("friction", "start", "run")]
    known = {
        kind.key(name): about
        for kind in (*kinds, *section_kinds().values())
        for name, about in kind.about.items()
    }
    for heading, text in re.findall(
        r"^## (\[\w+\]|Keys at the top)$(.*?)(?=^## )", text_of(SCENES), re.S | re.M
    ):
        prefix = heading.strip("[]") + "." if heading.startswith("[") else ""
        for keys, symbol, unit, _, *words in rows(text)[2:]:
            for name in re.findall(r"`(\w+)`", keys):
                if not name[0].isdigit():
                    allowed, meaning = (w.replace("`", "").split(": see [")[0] for w in words)
                    assert known.pop(prefix + name) == (symbol, unit, allowed, meaning)
    assert not known


def test_what_nearest_neighbours_leave_out_is_what_the_closed_forms_give():
    line = next(x for x in text_of(PAGES["accuracy.md"]).splitlines() if "nearest neighbours" in x)
    stated = {mode: float(part) for part, mode in re.findall(r"(\d+) % \((\w+)\)", line)}
    assert sorted(stated) == ["2s", "3a", "3t", "4a"]
    for mode, percent in stated.items():
        left_out = 1.0 - 1.0 / nrchain.rod.reach_ratio(mode, 0.1)
        assert percent == pytest.approx(100.0 * left_out, abs=0.5)


def test_every_effect_mode_integrator_and_study_is_listed():
    def first_cells(name):
        return {cell.strip("`") for row in rows(text_of(PAGES[name])) for cell in row[:1]}

    named = {(row[0], row[1].strip("`")) for row in rows(text_of(EFFECTS)) if len(row) == 3}
    assert {(effect.name, effect.key) for effect in effects()} <= named
    assert set(INTEGRATORS) <= first_cells("accuracy.md")
    assert set(STUDIES) <= first_cells("validation.md")
    rooms = {path.parent.name for path in (ROOT / "nrchain").glob("*/__init__.py")}
    assert rooms <= first_cells("house.md")
    shown = re.findall(r"`([\w-]+)`", text_of(PAGES["README.md"]))
    assert set(nrchain.scene_names()) <= set(shown)


def test_every_cause_of_a_stop_is_listed_with_a_remedy():
    remedies = {row[0].strip("`"): row[2] for row in rows(text_of(RUNNING)) if len(row) == 3}
    assert set(Cause) <= set(remedies)
    assert all(remedies[cause] for cause in Cause)


def test_the_layout_of_files_is_named():
    assert f"The attribute `layout` of `/nrchain` is {LAYOUT}." in text_of(PAGES["files.md"])


def test_both_installation_lines_build_pystokes_fast_and_performance_names_the_flags():
    """The build leaves out debug information and compiles modules side by side."""
    study = text_of(ROOT / "validation" / "performance" / "run.py")
    shell = "".join(blocks_in(PAGES["README.md"], "sh"))
    lines = [line for line in shell.splitlines() if "pip install" in line]
    assert len(lines) == 2
    for line in lines:
        flags = re.search(r"CFLAGS='([^']*)'", line)[1].split()
        assert "-g0" in flags
        (level,) = [flag for flag in flags if flag.startswith("-O")]
        assert f"PyStokes is compiled with {level}," in study
        settings = configparser.ConfigParser()
        settings.read(ROOT / re.search(r'DIST_EXTRA_CONFIG="\$PWD/(\S+)"', line)[1])
        assert settings.getint("build_ext", "parallel") > 1


def test_the_readme_is_short():
    assert len(text_of(PAGES["README.md"]).splitlines()) < 200


def test_the_parts_of_a_motion_add_up(registries, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    found = run_page(EFFECTS)["found"]
    total = sum(part.twist for part in found.values())
    assert total == pytest.approx(found.total.twist, abs=1e-12 * np.abs(found["bend"].twist).max())


def test_the_tether_pulls_to_its_point(registries, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    names = run_page(EFFECTS)
    changes = {"chain.particles": 5, "chain.ends": "free", "run.end": 10.0}
    scene = nrchain.load_scene(names["scene"], **changes)
    tether, poses = names["Tether"](scene), random_chain(5)
    x = poses[0] - np.array([60.0, 0.0, 50.0])

    def force(positions, frames):
        wrenches = np.zeros((5, 6))
        tether.add_wrenches(positions, frames, wrenches)
        return wrenches

    assert np.linalg.norm(force(*poses)[:, :3], axis=1) == pytest.approx(2.0)
    assert ((force(*poses)[:, :3] * x).sum(axis=1) < 0.0).all()
    numeric = pose_derivative(force, *poses)
    own = tether.derivative(*poses)
    assert own == pytest.approx(numeric[range(5), :, range(5)], abs=1e-8)
    assert Model(scene).is_banded
    trajectory = nrchain.simulate(scene)
    # the point is off the chain along z, and the mean force too
    assert trajectory.positions[-1][:, 2].mean() > trajectory.positions[0][:, 2].mean() + 0.1
