"""An effect that a user adds: a spring from every sphere to one point."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from nrchain import OneBodyEffect, Section
from nrchain.inputs.rules import number, vector


@dataclass(frozen=True, slots=True, kw_only=True)
class SpringSpec(Section):
    path: ClassVar[str] = "spring"
    stiffness: Annotated[float, number(least=0)] = 0.0
    anchor: Annotated[tuple[float, float, float], vector()] = (0.0, 0.0, 0.0)


class Spring(OneBodyEffect):
    name = "spring"
    summary = "a spring holds every sphere to a point"
    equation = "V = Σ (k/2)|r − r₀|²"
    Section = SpringSpec
    example: ClassVar = {"spring": {"stiffness": 2.0, "anchor": [1.0, 2.0, 3.0]}}
    covariant = False

    @classmethod
    def acts(cls, scene):
        return scene.spring.stiffness > 0.0

    def add_wrenches(self, positions, frames, wrenches):
        spring = self.scene.spring
        wrenches[:, :3] -= spring.stiffness * (positions - spring.anchor)

    def derivative(self, positions, frames):
        own = np.zeros((len(positions), 6, 6))
        own[:, :3, :3] = -self.scene.spring.stiffness * np.eye(3)
        return own

    def energy(self, positions, frames):
        spring = self.scene.spring
        return 0.5 * spring.stiffness * np.sum((positions - np.array(spring.anchor)) ** 2)
