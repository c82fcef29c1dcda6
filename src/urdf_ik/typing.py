"""Types that annotations of all rooms share."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""An array of float64; its shape and unit stand in the docstring."""

Threads = int | Literal["auto"]
"""How many threads share a piece of work; 'auto': one for each processor that this process may use."""
