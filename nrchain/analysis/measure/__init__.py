"""A(t) exp(iqs), Λ, V, Ω, hand: what is measured on a trajectory, with standard errors.

s = i d is the rest position of sphere i along its chain: a material coordinate, in which a wave is
exp(iqs + Λt). Its growth rate is Re Λ, its angular frequency Im Λ, its phase velocity −Im Λ/q.
Kinds of waves:

    "right"  y + iz = A exp(iqs), for q > 0 a right-handed helix (cos qs, sin qs)
    "left"   y − iz = A exp(iqs), a left-handed one
    "y", "z" y or z = Re A exp(iqs): plane sines; their plane turns on a chain that is chiral
    "x"      x − s  = Re A exp(iqs): longitudinal waves

"right" and "left" are the hands + and − of :class:`nrchain.lattice.Branch`.

Positions of an elastic periodic chain may be wrapped: each link takes the image nearest to its rest
length (:func:`nrchain.scene.unwrapping.unwrapped`). Where the image is not clear, a measurement
raises :class:`MeasurementError`.
"""

from nrchain.analysis.handedness import Handedness, handedness
from nrchain.analysis.measure.attractors.classify import attractor
from nrchain.analysis.measure.attractors.kinds import Attracted, Attractor
from nrchain.analysis.measure.attractors.lyapunov import lyapunov
from nrchain.analysis.measure.line_fit import Estimate
from nrchain.analysis.measure.motions import spin, straightness, translation, turned_angle
from nrchain.analysis.measure.rates import Rate, rate
from nrchain.analysis.measure.shape_fit import ShapeFit, fit_shape
from nrchain.analysis.measure.waves import Kind, Wave, wave
from nrchain.analysis.measured_chain import MeasurementError

__all__ = [
    "Attracted",
    "Attractor",
    "Estimate",
    "Handedness",
    "Kind",
    "MeasurementError",
    "Rate",
    "ShapeFit",
    "Wave",
    "attractor",
    "fit_shape",
    "handedness",
    "lyapunov",
    "rate",
    "spin",
    "straightness",
    "translation",
    "turned_angle",
    "wave",
]
