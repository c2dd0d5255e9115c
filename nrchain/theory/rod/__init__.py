"""The continuum theory of the active chain: a Cosserat rod with nonreciprocal constitutive laws.

Moduli, linearised equations and dispersion laws in the notation of Németh, Kobayashi and Adhikari,
written from their text and checked against :mod:`nrchain.lattice`, which is built from the code of
the simulation.
"""

from nrchain.theory.rod.dispersion import longitudinal, optical, steady_motion, transverse, twisting
from nrchain.theory.rod.linear import MISPRINTS, beam_rates, continuum_operator, discrete_operator
from nrchain.theory.rod.moduli import TABLE, Modulus, moduli
from nrchain.theory.rod.parameters import MODES, Rod
from nrchain.theory.rod.reach import neighbours_needed, reach_limit, reach_ratio, reach_sum

__all__ = [
    "MISPRINTS",
    "MODES",
    "TABLE",
    "Modulus",
    "Rod",
    "beam_rates",
    "continuum_operator",
    "discrete_operator",
    "longitudinal",
    "moduli",
    "neighbours_needed",
    "optical",
    "reach_limit",
    "reach_ratio",
    "reach_sum",
    "steady_motion",
    "transverse",
    "twisting",
]
