# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One thread for products of dense matrices, for a while, in a process of the user's."""

from collections.abc import Iterator
from contextlib import contextmanager
import os

from diffcal_ros.blas_threads import OPENBLAS
from threadpoolctl import ThreadpoolController


@contextmanager
def blas_on_one_thread() -> Iterator[None]:
    """Let OpenBLAS, which is loaded already, work on the thread that calls it.

    A notebook or a program of the user's has its own number of threads before and after, and all
    along where OPENBLAS_NUM_THREADS says so. See `blas_threads` for the reason.
    """
    if OPENBLAS in os.environ:
        yield
        return
    with ThreadpoolController().select(internal_api='openblas').limit(limits=1):
        yield
