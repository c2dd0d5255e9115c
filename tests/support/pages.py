"""Pages of README and docs: their blocks, and one run of all of them in a folder of their own.

A block of ``toml`` that is a whole scene is saved as the page says ("Save it as ``mine.toml``").
A block of ``sh`` runs line by line: commands of nrchain in this process, through their entry point
and with :data:`CHEAP` options; other lines in a shell. ``<!-- not run: REASON -->`` above a block
keeps it from running; its syntax and its options are still checked.
"""

import itertools
import re
import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path

import nrchain
from support.command_line import call

CHEAP = {
    "branch": ["--branches", "1", "--set", "chain.particles=6"],
    "cost": ["--budget", "0.1", "--set", "chain.particles=6"],
    "phases": ["--start", "random", "--levels", "0", "--set", "chain.particles=6"],
    "plan": ["--budget", "0.02"],
}
"""Options that make a command of a page fast, after its own."""


@dataclass(frozen=True)
class Block:
    """One fenced block of a page."""

    language: str
    text: str
    reason: str
    """Why it is not run; empty if it is."""


def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def blocks(page: Path) -> list[Block]:
    """The fenced blocks of a page, in order; a cell of a notebook counts as ``python``."""
    found = re.findall(
        r"(?:^<!-- not run: (.*?) -->\n+)?^(`{3,})(\S+)?[^\n]*\n(.*?)^\2$",
        text_of(page),
        re.S | re.M,
    )
    names = {"{code-cell}": "python"}
    return [
        Block(names.get(language, language), text, " ".join(reason.split()))
        for reason, _, language, text in found
    ]


def commands(text: str) -> list[str]:
    """The lines of a shell block, with those that go on joined; a here-document is one of them."""
    found = []
    lines = iter(text.replace("\\\n", " ").splitlines())
    for line in lines:
        document = re.search(r"<<'?(\w+)'?", line)
        while document and not line.endswith(f"\n{document[1]}"):
            line += "\n" + next(lines)
        if line.strip() and not line.startswith("#"):
            found.append(line)
    return found


def run_page(page: Path) -> dict[str, object]:
    """Run the blocks of a page in this folder, one after the other; the names that they leave."""
    names: dict[str, object] = {"__name__": "example"}
    saved = iter(re.findall(r"[Ss]ave it as `([\w-]+\.toml)`", text_of(page)))
    for block in blocks(page):
        if block.reason:
            continue
        if block.language == "python":
            exec(compile(block.text, page.name, "exec"), names)
        elif block.language == "toml" and "[chain]" in block.text:
            Path(next(saved, "mine.toml")).write_text(block.text, encoding="utf-8")
        elif block.language == "sh":
            for command in commands(block.text):
                run_command(command)
    return names


def run_command(command: str) -> None:
    """Run one line of a shell block, which must succeed."""
    words = shlex.split(command, comments=True)
    plain = not {"|", "<", "&&", ";"} & set(words) and "<<" not in command
    if words[0] != "nrchain" or not plain:
        subprocess.run(["bash", "-ec", command], check=True, capture_output=True)
        return
    simulate_named(words)
    words, file = (words[:-2], words[-1]) if words[-2] == ">" else (words, None)
    result = call(*cheap(words[1:]))
    assert result.exit_code == 0, f"{command}\n{result.stderr}{result.exception or ''}"
    if file:
        Path(file).write_text(result.stdout, encoding="utf-8")


def simulate_named(words: list[str]) -> None:
    """A short run for each folder ``runs/SCENE`` that a command reads and that is not there."""
    for before, word in itertools.pairwise(words):
        name = word.removeprefix("runs/").partition(":")[0]
        folder = Path("runs", name)
        if word.startswith("runs/") and before not in ("-o", "--output") and not folder.exists():
            scene = name if name in nrchain.scene_names() else "buckling"
            short = {"chain.particles": 6, "run.end": 20.0, "run.snapshots": 5}
            nrchain.simulate(nrchain.load_scene(scene, **short), output=folder)


def cheap(words: list[str]) -> list[str]:
    """The words of a command with options that make it fast."""
    if words[0] == "figure":
        words = [word.replace("all", "3") for word in words]
    if words[0] == "phases":
        words = [re.sub(r"^([\w.]+=[^:]+:[^:]+)(:\d+)?$", r"\1:2", word) for word in words]
    if words[0] == "sweep":
        words = [re.sub(r"^([\w.]+=[^:]+:[^:]+):\d+", r"\1:2", word) for word in words]
    if any(word.endswith((".gif", ".mp4")) for word in words):
        words = [*words, "--times", "2"]
    options = CHEAP.get(words[0], [])
    return words + (options[2:] if options[:1] == ["--start"] and "--start" in words else options)
