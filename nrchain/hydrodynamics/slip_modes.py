"""The slip modes: the four of the paper, and those a user registers.

Compiled kernels, Jacobians, lattice sums and tests are all built from the rows below. One call of
:func:`register` adds a mode to all of them.

Source of the four pair laws: Németh, Kobayashi, Adhikari, Eqs. (2s_force), (3a_force), (3t_force)
and (4a_force), with n the unit vector from the acting to the feeling sphere. The strengths V are
the paper's: they differ from slip speeds by the factors in docs/scenes.md.
"""

from __future__ import annotations

from nrchain.errors import SceneError
from nrchain.hydrodynamics.slip_mode import SlipMode
from nrchain.inputs.names import did_you_mean

_MODES: dict[str, SlipMode] = {}


def register(mode: SlipMode) -> SlipMode:
    """Add a mode to those that scenes can name, and return it.

    A trajectory file stores the labels of its modes, not their tables: register a mode again before
    you open or resume a run that uses it. Raises :class:`~nrchain.errors.SceneError` if another
    mode has the label.

    >>> flow = {("n", 4): ("-1/2", 0, "5/2"), ("e", 4): (0, -1)}
    >>> register(SlipMode("5t", "potential quadrupole", 4, False, False, flow)).label
    '5t'
    >>> unregister("5t")
    """
    if not isinstance(mode, SlipMode):
        raise SceneError("slip mode", mode, "must be a SlipMode")
    known = _MODES.get(mode.label)
    if known is not None and known != mode:
        raise SceneError(
            "slip mode label", mode.label, "is taken by another mode; choose a new label"
        )
    _MODES[mode.label] = mode
    return mode


def unregister(label: str) -> None:
    """Remove a registered mode: scenes that name it are refused."""
    del _MODES[find(label).label]


def modes() -> tuple[SlipMode, ...]:
    """All registered modes, in the order of registration."""
    return tuple(_MODES.values())


def find(label: str) -> SlipMode:
    """The mode of a label. Raises SceneError with the nearest known label for an unknown one."""
    if isinstance(label, str) and label in _MODES:
        return _MODES[label]
    hint = did_you_mean(label, _MODES)
    raise SceneError("slip mode", label, f"known modes are {', '.join(_MODES)}{hint}")


register(
    SlipMode(
        label="2s",
        name="stresslet",
        order=2,
        polar=False,
        chiral=False,
        velocity={("n", 2): ("-7/6", 0, "7/2")},
    )
)
register(
    SlipMode(
        label="3a",
        name="torque dipole",
        order=3,
        polar=False,
        chiral=True,
        velocity={("x", 3): (0, "13/12")},
    )
)
register(
    SlipMode(
        label="3t",
        name="source dipole",
        order=3,
        polar=True,
        chiral=False,
        velocity={("e", 3): ("-1/5",), ("n", 3): (0, "3/5")},
    )
)
register(
    SlipMode(
        label="4a",
        name="chiral octupole",
        order=4,
        polar=True,
        chiral=True,
        velocity={("x", 4): ("363/40", 0, "-363/8")},
    )
)
