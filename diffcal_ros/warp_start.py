# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Start Warp without its greeting, with a folder for compiled kernels that can be written to."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
import sys
from typing import Any

from diffcal_ros.kernel_cache import settle_kernel_cache
import warp as wp

# A machine without a GPU is nothing to warn of; who asks for one that is missing is told.
_EXPECTED = b'Could not find or load the NVIDIA CUDA driver'


def start_warp() -> None:
    """Start it, once in a process; errors of its own are still said.

    Raises:
        InputError: when there is no folder for compiled kernels.
    """
    settle_kernel_cache()
    config: Any = wp.config
    if hasattr(config, 'log_level'):
        config.log_level = getattr(wp, 'LOG_ERROR', 40)
    else:
        config.quiet = True
    with _without_expected_lines():
        wp.init()


@contextmanager
def _without_expected_lines() -> Iterator[None]:
    """Hold back what native code says on standard error; say what is not expected afterwards."""
    try:
        kept, held = os.dup(2), os.memfd_create('diffcal-stderr')
    except (AttributeError, OSError):  # Not on this system, or no standard error.
        yield
        return
    with suppress(OSError, ValueError, AttributeError):
        sys.stderr.flush()
    os.dup2(held, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        _say_the_rest(held)


def _say_the_rest(held: int) -> None:
    with os.fdopen(held, 'rb') as said:
        said.seek(0)
        for line in said:
            if _EXPECTED not in line:
                with suppress(OSError):
                    os.write(2, line)
