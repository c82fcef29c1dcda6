"""Types that annotations of all rooms share."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""An array of float64; its shape and unit stand in the docstring."""
