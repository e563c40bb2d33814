"""Names of types that many modules share."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

Array = np.ndarray
"""Of floats."""
Index = np.ndarray
"""Of 64-bit integers."""
Arrays = Mapping[str, np.ndarray]
"""Arrays by name, never changed once made."""
History = Callable[[float], float]
"""A number as a function of time [s]."""
VectorHistory = Callable[[float], np.ndarray]
"""A vector, shape [3], as a function of time [s]."""
