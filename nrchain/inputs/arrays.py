"""Arrays in a scene: immutable, compared and hashed by value."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

from nrchain.errors import SceneError

if TYPE_CHECKING:
    import numpy as np

    from nrchain.inputs.rules import Rule


class GivenArray:
    """An array of finite floats; ``values`` is read-only."""

    __slots__ = ("values",)
    values: np.ndarray

    def __init__(self, values: Any) -> None:
        import numpy as np

        self.values = np.array(values, float, order="C")
        self.values.flags.writeable = False

    def tolist(self) -> list[Any]:
        """The numbers in nested lists, as TOML has them."""
        return self.values.tolist()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        # NumPy functions accept it as an array
        return self.values.astype(dtype or float, copy=bool(copy))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, GivenArray):
            return NotImplemented
        return self.values.shape == other.values.shape and bool((self.values == other.values).all())

    def __hash__(self) -> int:
        # 0.0 equals -0.0 but has different bytes
        return hash((self.values.shape, (self.values + 0.0).tobytes()))

    def __repr__(self) -> str:
        return f"<array of shape {self.values.shape}>"

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: object) -> Self:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.values,)


def array_of(*shape: int) -> Rule:
    """Finite numbers of shape (N, *shape), kept as a :class:`GivenArray`."""

    def read(key: str, value: Any) -> GivenArray:
        if isinstance(value, GivenArray) and value.values.shape[1:] == shape:
            return value
        from nrchain.inputs.arguments import finite_array

        return GivenArray(finite_array(key, value, (None, *shape)))

    return read


def refuse_rows(key: str, given: GivenArray | None, count: int) -> None:
    """Refuse an array without one row for each sphere."""
    if given is not None and len(given.values) != count:
        shape = given.values.shape
        allowed = f"the shape must be {(count, *shape[1:])}, with one row for each sphere"
        raise SceneError(key, shape, allowed)
