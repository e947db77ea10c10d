# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Programs keep products of dense matrices to the thread that asks for them."""

import os
import subprocess
import sys

import pytest

# Counts the process's threads after a program's start and a large product.
COUNT = """
import os, sys
{start}
import numpy as np
np.ones((900, 900)) @ np.ones((900, 900))
print(len(os.listdir('/proc/self/task')))
"""
COMMAND = """
from diffcal_ros.cli import program
sys.argv = ['diffcal', '--version']
try:
    program.main()
except SystemExit:
    pass
"""
NODE = """
from diffcal_ros.ros.run_node import run_node
try:
    run_node('no_such_module', 'Node')
except ModuleNotFoundError:
    pass
"""


def thread_count(start: str, **given: str) -> int:
    """Return how many threads a process of its own has."""
    environment = {name: value for name, value in os.environ.items() if 'THREADS' not in name}
    ended = subprocess.run(
        [sys.executable, '-c', COUNT.format(start=start)],
        env=environment | given,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return int(ended.stdout.splitlines()[-1])


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason='one core has one thread')
@pytest.mark.parametrize('start', [COMMAND, NODE], ids=['command', 'node'])
def test_a_program_has_one_thread_for_dense_matrices(start: str) -> None:
    """Unless the user, who may have large bodies and idle cores, asks for more."""
    assert thread_count(start) == thread_count(start, OPENBLAS_NUM_THREADS='1')
    assert thread_count(start, OPENBLAS_NUM_THREADS='2') == thread_count(start) + 1
