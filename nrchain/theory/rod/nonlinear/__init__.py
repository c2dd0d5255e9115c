"""The nonlinear rod: the continuum of :class:`~nrchain.Material` at large deflections, in time."""

from nrchain.theory.rod.nonlinear.chain_law import chain_law
from nrchain.theory.rod.nonlinear.of_scene import node_poses, rod_of
from nrchain.theory.rod.nonlinear.rod import CosseratRod, Motion, RodError

__all__ = ["CosseratRod", "Motion", "RodError", "chain_law", "node_poses", "rod_of"]
