"""Cycles: shapes that return after a period, up to a motion of the chain as a whole.

- ``charts``: u and θ of poses about a base, and their derivatives
- ``orbit``: the poses of a chain over a period, and interpolation between them
- ``interval``: one step of Radau IIA, and its derivative
- ``system``: all steps of an orbit, with period and drift, condensed to one matrix
- ``newton``: the orbit itself
- ``mesh``: where the intervals begin, and the error of the orbit
- ``multipliers``: growth over a period
- ``carrying``: motions of a chain as a whole, and the one that fits best
- ``recurrence``: a guess from a run
- ``cycle``: what a user gets
- ``curve``: cycles along a number of a scene, as a curve that branches can follow
- ``hopf``: the first cycles that leave a Hopf point
- ``continuation``: follows cycles along a number
- ``branch``, ``file``: what a user gets of them, and the file of a branch
"""
