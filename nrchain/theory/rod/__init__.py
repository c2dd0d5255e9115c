"""The continuum theory of the active chain: a Cosserat rod with nonreciprocal constitutive laws.

Moduli, linearised equations and dispersion laws in the notation of Németh, Kobayashi and Adhikari,
written from their text and checked against :mod:`nrchain.lattice`, which is built from the code of
the simulation. :func:`nrchain.moduli` and :class:`Material` are for any chain, from that code.
"""

from nrchain.theory.rod.coarse_graining import Moduli
from nrchain.theory.rod.constants import SYMBOLS, Constants
from nrchain.theory.rod.dispersion import longitudinal, optical, steady_motion, transverse, twisting
from nrchain.theory.rod.instability import Instability, instability, rod_instability
from nrchain.theory.rod.linear import MISPRINTS, beam_rates, continuum_operator, discrete_operator
from nrchain.theory.rod.material import Material, Work, cycle_work, strain_cycle
from nrchain.theory.rod.measured_symmetry import measured_symmetry
from nrchain.theory.rod.moduli import TABLE, Modulus, moduli
from nrchain.theory.rod.nonlinear import CosseratRod, Motion, RodError, node_poses, rod_of
from nrchain.theory.rod.parameters import MODES, Rod
from nrchain.theory.rod.reach import neighbours_needed, reach_limit, reach_ratio, reach_sum
from nrchain.theory.rod.slip_symmetry import slip_symmetry, symmetry_of_modes
from nrchain.theory.rod.symbol import Symbol, base_motion, beam_symbol, rod_symbol
from nrchain.theory.rod.symmetry import Class, Symmetry, classes
from nrchain.theory.rod.uniform import Response, uniform_response
from nrchain.theory.rod.waves import Waves, rod_waves

__all__ = [
    "MISPRINTS",
    "MODES",
    "SYMBOLS",
    "TABLE",
    "Class",
    "Constants",
    "CosseratRod",
    "Instability",
    "Material",
    "Moduli",
    "Modulus",
    "Motion",
    "Response",
    "Rod",
    "RodError",
    "Symbol",
    "Symmetry",
    "Waves",
    "Work",
    "base_motion",
    "beam_rates",
    "beam_symbol",
    "classes",
    "continuum_operator",
    "cycle_work",
    "discrete_operator",
    "instability",
    "longitudinal",
    "measured_symmetry",
    "moduli",
    "neighbours_needed",
    "node_poses",
    "optical",
    "reach_limit",
    "reach_ratio",
    "reach_sum",
    "rod_instability",
    "rod_of",
    "rod_symbol",
    "rod_waves",
    "slip_symmetry",
    "steady_motion",
    "strain_cycle",
    "symmetry_of_modes",
    "transverse",
    "twisting",
    "uniform_response",
]
