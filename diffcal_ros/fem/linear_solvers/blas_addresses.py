# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the routines of SciPy's BLAS and LAPACK are in memory, for compiled code to call.

SciPy offers them to others by its modules `cython_blas` and `cython_lapack`, whose tables name
each routine with its arguments; integers have 32 bits there.
"""

import ctypes
from functools import cache

import numpy as np
from scipy.linalg import cython_blas, cython_lapack

_LETTERS = {np.dtype(np.float64): 'd', np.dtype(np.float32): 's'}
_of_capsule = ctypes.pythonapi.PyCapsule_GetPointer
_of_capsule.restype, _of_capsule.argtypes = ctypes.c_void_p, (ctypes.py_object, ctypes.c_char_p)
_name_of_capsule = ctypes.pythonapi.PyCapsule_GetName
_name_of_capsule.restype, _name_of_capsule.argtypes = ctypes.c_char_p, (ctypes.py_object,)


@cache
def routine_address(name: str, number: type[np.floating]) -> int:
    """Return the address of a routine for numbers of one precision.

    Args:
        name: without the letter of the precision, such as `potrf`.
        number: `numpy.float64` or `numpy.float32`.
    """
    own = _LETTERS[np.dtype(number)] + name
    table = cython_lapack.__pyx_capi__ if own in cython_lapack.__pyx_capi__ else None
    capsule = (table or cython_blas.__pyx_capi__)[own]
    return int(_of_capsule(capsule, _name_of_capsule(capsule)))
