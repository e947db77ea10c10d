# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Start Warp without its greeting, with a folder for compiled kernels that can be written to."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
import sys
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.warp_runtime.kernel_cache import settle_kernel_cache
import warp as wp

# A machine without a GPU is nothing to warn of; who asks for one that is missing is told.
_EXPECTED = b'Could not find or load the NVIDIA CUDA driver'
# Of address space the libraries take 1.3 GB before a small body is simulated. With less OpenBLAS
# may ask for its buffers for ever [bytes].
_ADDRESS_SPACE = 1536 << 20


def start_warp() -> None:
    """Start it, once in a process; errors of its own are still said.

    Raises:
        InputError: when there is no folder for compiled kernels, or too little address space.
    """
    _require_address_space()
    settle_kernel_cache()
    config: Any = wp.config
    if hasattr(config, 'log_level'):
        config.log_level = getattr(wp, 'LOG_ERROR', 40)
    else:
        config.quiet = True
    with _without_expected_lines():
        wp.init()


def _require_address_space() -> None:
    try:
        import resource
    except ImportError:  # Not on this system.
        return
    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    if allowed != resource.RLIM_INFINITY and allowed < _ADDRESS_SPACE:
        raise InputError(
            f'this process may use {allowed / 2**30:.2g} GB of address space (ulimit -v), and '
            f'simulating takes {_ADDRESS_SPACE / 2**30:.2g} GB at least: raise that limit'
        )


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
