"""F = f + Σ_a f_a e_a, T = t + Σ_a t_a e_a: one force and one torque on every sphere.

f and t are vectors in the lab (gravity, a magnetic torque on aligned spheres); f_a and t_a are
components along the axes e_a of each sphere, and rotate with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from nrchain._addresses import (
    ROW,
    Term,
    carray,
    compile_term,
    floats_at,
    integers_at,
    matrix_in,
    table_of,
    vector_in,
)
from nrchain._compile import kernel
from nrchain.effects.base import OneBodyEffect, cross_matrix
from nrchain.effects.registry import register_effect
from nrchain.inputs.about import About
from nrchain.inputs.rules import Section, vector
from nrchain.scene.scene import Scene

Vector = tuple[float, float, float]
_NONE = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldSpec(Section):
    """A force and a torque on every sphere: vectors of the lab, and along e₁, e₂, e₃ of each."""

    path: ClassVar[str] = "field"
    force: Annotated[Vector, vector()] = _NONE
    torque: Annotated[Vector, vector()] = _NONE
    body_force: Annotated[Vector, vector()] = _NONE
    body_torque: Annotated[Vector, vector()] = _NONE
    about: ClassVar[Mapping[str, About]] = {
        "force": About("f", "F", "three numbers", "force in lab components, such as gravity"),
        "torque": About("t", "F L", "three numbers", "torque in lab components"),
        "body_force": About("f_a", "F", "three numbers", "force along e₁, e₂, e₃ of each sphere"),
        "body_torque": About(
            "t_a", "F L", "three numbers", "torque about e₁, e₂, e₃ of each sphere"
        ),
    }


@kernel
def _add_field(frames: np.ndarray, lab: np.ndarray, body: np.ndarray, wrenches: np.ndarray) -> None:
    """wrenches += (f, t) + Σ_a (f_a, t_a) e_a."""
    for i in range(wrenches.shape[0]):
        for half in range(2):
            for k in range(3):
                wrenches[i, 3 * half + k] += (
                    lab[3 * half + k]
                    + body[half, 0] * frames[i, 0, k]
                    + body[half, 1] * frames[i, 1, k]
                    + body[half, 2] * frames[i, 2, k]
                )


def _add_at(context: int, positions: int, frames: int, out: int, width: int) -> int:
    """The term of :func:`_add_field`; its table: f and t, f_a and t_a, and N."""
    t = carray(integers_at(context), (3, ROW))
    n = vector_in(t, 2, integers_at)[0]
    lab, body = vector_in(t, 0, floats_at), matrix_in(t, 1, floats_at)
    _add_field(carray(floats_at(frames), (n, 3, 3)), lab, body, carray(floats_at(out), (n, 6)))
    return 0


def _add_blocks_at(context: int, positions: int, frames: int, out: int, width: int) -> int:
    """The derivative of the same: blocks[i, w] −= b × for the body vectors b."""
    t = carray(integers_at(context), (3, ROW))
    n, body = vector_in(t, 2, integers_at)[0], matrix_in(t, 1, floats_at)
    e, blocks = (
        carray(floats_at(frames), (n, 3, 3)),
        carray(floats_at(out), (n, 2 * width + 1, 6, 6)),
    )
    for i in range(n):
        for half in range(2):
            for k in range(3):
                b = (
                    body[half, 0] * e[i, 0, k]
                    + body[half, 1] * e[i, 1, k]
                    + body[half, 2] * e[i, 2, k]
                )
                p, q = (k + 1) % 3, (k + 2) % 3
                blocks[i, width, 3 * half + p, 3 + q] += b
                blocks[i, width, 3 * half + q, 3 + p] -= b
    return 0


@register_effect
class Field(OneBodyEffect):
    """The uniform force and torque of a scene."""

    name = "field"
    summary = "a uniform force and torque on every sphere, in the lab or along its axes"
    absence = "no force or torque from outside"
    equation = "F = f + Σ_a f_a e_a, T = t + Σ_a t_a e_a"
    Section = FieldSpec
    example = {  # noqa: RUF012
        "field": {
            "force": [1.0, -2.0, 3.0],
            "torque": [-3.0, 1.0, 2.0],
            "body_force": [2.0, 1.0, -1.0],
            "body_torque": [1.0, 3.0, -2.0],
        }
    }
    covariant = False
    placed = False
    carries = True

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        section = self.section(scene)
        self._lab = np.array([*section.force, *section.torque])
        self._body = np.array([section.body_force, section.body_torque])

    @classmethod
    def balanced(cls, scene: Scene) -> bool:
        """True for torques alone: their flow decays as 1/r², and opposite images cancel."""
        section = cls.section(scene)
        return not any(section.force) and not any(section.body_force)

    @classmethod
    def scale(cls, scene: Scene) -> float:
        section, radius = cls.section(scene), scene.chain.radius
        force = np.linalg.norm(section.force) + np.linalg.norm(section.body_force)
        torque = np.linalg.norm(section.torque) + np.linalg.norm(section.body_torque)
        translation, rotation = scene.drag
        return float(max(force / translation, radius * torque / rotation))

    @classmethod
    def straight(cls, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """(F, T) on a sphere with its frame along the lab, and its derivative."""
        field, wrench, frames = cls(scene), np.zeros((1, 6)), np.eye(3)[None]
        field.add_wrenches(np.zeros((1, 3)), frames, wrench)
        return wrench[0], field.derivative(np.zeros((1, 3)), frames)[0]

    def add_wrenches(self, positions: np.ndarray, frames: np.ndarray, wrenches: np.ndarray) -> None:
        _add_field(frames, self._lab, self._body, wrenches)

    def term(self) -> Term:
        entries = compile_term(_add_at), compile_term(_add_blocks_at)
        arrays = self._lab, self._body, np.array([self.scene.chain.particles])
        return Term(entries[0].address, entries[1].address, table_of(arrays), (*arrays, *entries))

    def derivative(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """∂(F, T)/∂φ: a body vector changes by φ × b."""
        body = self._body @ frames
        own = np.zeros((len(frames), 6, 6))
        for half in range(2):
            own[:, 3 * half : 3 * half + 3, 3:] = -cross_matrix(body[:, half])
        return own
