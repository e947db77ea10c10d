# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The routines that compiled code is told of are those of SciPy."""

import ctypes

from diffcal_ros.fem.linear_solvers.blas_addresses import routine_address
import numpy as np
import pytest


@pytest.mark.parametrize(
    ('number', 'one'), [(np.float64, ctypes.c_double), (np.float32, ctypes.c_float)]
)
def test_a_routine_of_either_precision_does_what_its_name_says(number, one, random) -> None:
    matrix, vector = random.normal(size=(5, 3)).astype(number), np.arange(3, dtype=number)
    found = np.full(5, np.nan, dtype=number)
    whole, step = ctypes.byref(ctypes.c_int(1)), ctypes.byref(ctypes.c_int(1))
    rows, columns = (ctypes.byref(ctypes.c_int(count)) for count in matrix.shape)
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (matrix, vector, found)]
    gemv = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 11)(routine_address('gemv', number))
    scale, nothing = ctypes.byref(one(2.0)), ctypes.byref(one(0.0))
    # By columns a matrix by rows is its transpose.
    arguments = [columns, rows, scale, pointers[0], columns, pointers[1], step, nothing]
    gemv(b'T', *[ctypes.cast(a, ctypes.c_void_p) for a in arguments], pointers[2], whole)
    np.testing.assert_allclose(found, 2.0 * matrix @ vector, rtol=1e-6)


def test_a_routine_that_does_not_exist_is_no_address() -> None:
    with pytest.raises(KeyError, match='dnothing'):
        routine_address('nothing', np.float64)
