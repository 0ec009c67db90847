"""Short names for the types of numpy arrays, by their dtype: `F64` is an array of float64, and so on.

The type says nothing of shape or unit. These stand in the docstring of whatever takes or returns an array.
"""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T", bound=np.generic)

F64 = NDArray[np.float64]
F32 = NDArray[np.float32]
C128 = NDArray[np.complex128]
I64 = NDArray[np.int64]
I32 = NDArray[np.int32]
I8 = NDArray[np.int8]
U64 = NDArray[np.uint64]
U32 = NDArray[np.uint32]
Bools = NDArray[np.bool_]


def in_rows(values: NDArray[T]) -> NDArray[T]:
    """Return an array in C order that may be written, copied where it is not one; shape and dtype stay.

    A kernel has machine code of its own for each other order, and for arrays that are only read.
    """
    return np.require(values, requirements=("C", "W"))
