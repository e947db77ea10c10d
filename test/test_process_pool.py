# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Processes of a pool end with the one that made it, however it ends."""

import os
import signal
import subprocess
import sys

import pytest
from support.processes import children_of, wait_until_gone

_FIRST = """
import os, sys, time
sys.path.insert(0, {folder!r})
import tasks
from diffcal_ros.process_pool import process_pool
if __name__ == '__main__':
    pool = process_pool(2)
    print(pool.submit(tasks.number).result(), flush=True)
    pool.submit(time.sleep, 60)
    time.sleep(60)
"""


@pytest.mark.skipif(sys.platform != 'linux', reason='looks into /proc')
@pytest.mark.parametrize('ending', [signal.SIGKILL, signal.SIGTERM])
def test_no_process_outlives_the_first(tmp_path, ending):
    (tmp_path / 'tasks.py').write_text('import os\ndef number(): return os.getpid()\n')
    (tmp_path / 'first.py').write_text(_FIRST.format(folder=str(tmp_path)))
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join([str(tmp_path), os.getcwd()])}
    with subprocess.Popen(
        [sys.executable, tmp_path / 'first.py'],
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
    ) as first:
        child = int(first.stdout.readline())
        assert child in children_of(first.pid)
        first.send_signal(ending)
    wait_until_gone([child])


_THREADS = """
import os, sys
sys.path.insert(0, {folder!r})
import tasks
from diffcal_ros.process_pool import process_pool
if __name__ == '__main__':
    print(process_pool(1).submit(tasks.threads).result())
"""


@pytest.mark.parametrize(('given', 'expected'), [({}, '1'), ({'OPENBLAS_NUM_THREADS': '3'}, '3')])
def test_its_processes_keep_dense_matrices_to_one_thread(tmp_path, given, expected):
    """Whoever makes the pool may have loaded NumPy with more before: a user's own script."""
    (tmp_path / 'tasks.py').write_text(
        "import os\ndef threads(): return os.environ['OPENBLAS_NUM_THREADS']\n"
    )
    (tmp_path / 'first.py').write_text(_THREADS.format(folder=str(tmp_path)))
    environment = {name: value for name, value in os.environ.items() if 'THREADS' not in name}
    environment['PYTHONPATH'] = os.pathsep.join([str(tmp_path), os.getcwd()])
    ended = subprocess.run(
        [sys.executable, tmp_path / 'first.py'],
        env=environment | given,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert ended.stdout.split() == [expected]
