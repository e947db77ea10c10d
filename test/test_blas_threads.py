# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Programs keep products of dense matrices to the thread that asks for them."""

import os
import subprocess
import sys

import pytest

# Says how many threads OpenBLAS has before, in and after a fit, and in one within it.
ASK = """
import numpy as np
from threadpoolctl import ThreadpoolController
from diffcal_ros.one_blas_thread import blas_on_one_thread
def count():
    own = ThreadpoolController().select(internal_api='openblas').info()
    return max(one['num_threads'] for one in own)
@blas_on_one_thread()
def fit():
    with blas_on_one_thread():
        inner = count()
    return inner, count()
print(count(), *fit(), count(), *fit())
"""
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


def said(code: str, **given: str) -> list[int]:
    """Return the numbers that a process of its own prints last."""
    environment = {name: value for name, value in os.environ.items() if 'THREADS' not in name}
    ended = subprocess.run(
        [sys.executable, '-c', code],
        env=environment | given,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return [int(word) for word in ended.stdout.splitlines()[-1].split()]


def thread_count(start: str, **given: str) -> int:
    """Return how many threads a process of its own has."""
    return said(COUNT.format(start=start), **given)[0]


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason='one core has one thread')
@pytest.mark.parametrize('start', [COMMAND, NODE], ids=['command', 'node'])
@pytest.mark.slow_but_first
def test_a_program_has_one_thread_for_dense_matrices(start: str) -> None:
    """Unless the user, who may have large bodies and idle cores, asks for more."""
    assert thread_count(start) == thread_count(start, OPENBLAS_NUM_THREADS='1')
    assert thread_count(start, OPENBLAS_NUM_THREADS='2') == thread_count(start) + 1


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason='one core has one thread')
def test_a_fit_in_a_process_of_the_users_has_one_thread_and_leaves_it_as_it_was() -> None:
    before, within, around, after, again, anew = said(ASK)
    assert before == after > 1
    assert {within, around, again, anew} == {1}


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason='one core has one thread')
def test_what_the_user_asks_for_stays_in_a_fit() -> None:
    assert set(said(ASK, OPENBLAS_NUM_THREADS='2')) == {2}
