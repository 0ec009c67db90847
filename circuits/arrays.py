"""Types of arrays by their dtype; shapes and units stand in the docstrings of what takes and returns them."""

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
F32 = NDArray[np.float32]
C128 = NDArray[np.complex128]
I64 = NDArray[np.int64]
I32 = NDArray[np.int32]
I8 = NDArray[np.int8]
U64 = NDArray[np.uint64]
U32 = NDArray[np.uint32]
Bools = NDArray[np.bool_]
