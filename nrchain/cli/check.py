"""``nrchain check``: all mistakes of a scene at once, and what is likely to go wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer

from nrchain.cli.arguments import Changes, Json, Quiet, SceneName, Style
from nrchain.cli.examples import examples
from nrchain.cli.exits import REFUSED, one_line_errors, show
from nrchain.cli.records import show_json
from nrchain.cli.terminal import list_item

if TYPE_CHECKING:
    from nrchain.scene.scene import Scene


@examples(
    "nrchain check mine.toml",
    "nrchain check buckling --set slip.2s=1e6",
)
@one_line_errors()
def check(
    scene: SceneName,
    changes: Changes = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """List all mistakes of a scene at once, its keys without effect and its risks."""
    from nrchain.errors import NrchainError

    style = Style.of(as_json=as_json, quiet=quiet)
    mistakes = _mistakes(scene, changes or [])
    warnings: list[str] = []
    unused: list[tuple[str, str]] = []
    if not mistakes:
        from nrchain.scene.loading import load_scene
        from nrchain.scene.toml import parse_assignment

        loaded = load_scene(scene, **dict(map(parse_assignment, changes or [])))
        try:
            warnings, unused = _risks(loaded)
        except NrchainError as error:
            mistakes = [error]
    if style is Style.JSON:
        show_json(
            {
                "mistakes": [_record(error) for error in mistakes],
                "warnings": warnings,
                "without_effect": [{"key": key, "why": why} for key, why in unused],
            }
        )
    elif style.is_text:
        count = f"{len(mistakes)} mistake{'s' if len(mistakes) > 1 else ''}"
        show(f"{scene}: {count if mistakes else 'no mistakes'}", soft_wrap=True)
        lines = [str(error) for error in mistakes]
        lines += [f"{key} has no effect: {why}" for key, why in unused]
        lines += [f"warning: {text}" for text in warnings]
        show(*map(list_item, lines), soft_wrap=True)
    if mistakes:
        raise typer.Exit(REFUSED)


def _mistakes(name: str, changes: list[str]) -> list[Any]:
    """The errors of a scene and of its changes; a file that cannot be read is one."""
    from nrchain.errors import SceneError
    from nrchain.scene.mistakes import mistakes_in
    from nrchain.scene.toml import change, parse_assignment, read_source

    try:
        table = change(read_source(name), dict(map(parse_assignment, changes)))
    except SceneError as error:
        return [error]
    return list(mistakes_in(table))


def _risks(scene: Scene) -> tuple[list[str], list[tuple[str, str]]]:
    """Warnings and keys without effect; raises for a start or an integrator that is refused."""
    from nrchain.motion.integrators import find_integrator
    from nrchain.planning.checked_start import starting_poses
    from nrchain.planning.description import without_effect
    from nrchain.planning.integrator import integrator_of
    from nrchain.planning.regime import warnings

    starting_poses(scene)
    find_integrator(integrator_of(scene))
    return warnings(scene), without_effect(scene)


def _record(error: Any) -> dict[str, Any]:
    """A mistake as JSON: key and allowed values are empty where it has none."""
    key, allowed = getattr(error, "key", ""), getattr(error, "allowed", "")
    return {"key": key, "allowed": allowed, "message": str(error)}
