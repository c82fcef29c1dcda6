"""Read-only arrays, and objects whose arrays stay read-only when pickled or copied (NumPy's copies are writeable)."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

_Number = TypeVar("_Number", bound=np.generic)


def frozen(array: NDArray[_Number]) -> NDArray[_Number]:
    """``array``, read-only: a view or a fresh array, never one that somebody else writes to."""
    array.setflags(write=False)
    return array


class Frozen:
    """An object whose arrays are all read-only, and stay so in its copies."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
