# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How many threads a program gives to products of dense matrices."""

import os

OPENBLAS = 'OPENBLAS_NUM_THREADS'


def keep_blas_to_one_thread() -> None:
    """Let OpenBLAS work on the thread that calls it, unless the user said otherwise.

    To be called before NumPy is loaded: OpenBLAS makes its threads then. Its matrices are small
    here, and threads that wait for the next one spin: they slow down what else the machine does,
    and are slowed down by it (docs/decisions/sparse-solvers.md has the figures). Other processes
    that this one starts do likewise. MKL's threads pay, and keep to OMP_NUM_THREADS.
    """
    os.environ.setdefault(OPENBLAS, '1')
