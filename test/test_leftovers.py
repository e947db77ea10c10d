# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a killed process left goes away; what another one is writing stays."""

import os
from pathlib import Path
import subprocess
import sys

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.leftovers import fresh_path
from diffcal_ros.recording.bag_writer import BagWriter
import numpy as np
import pytest

_KILLED = """
import os, sys
from pathlib import Path
from diffcal_ros.atomic_file import replacing
from diffcal_ros.recording.bag_writer import BagWriter
out = Path(sys.argv[1])
with BagWriter(out / 'bag'), replacing(out / 'a.json') as fresh:
    fresh.write_text('half')
    os.kill(os.getpid(), 9)
"""


def _kill_while_writing(folder) -> None:
    done = subprocess.run([sys.executable, '-c', _KILLED, folder], check=False)
    assert done.returncode == -9


def test_leftovers_of_dead_processes_are_removed(tmp_path):
    _kill_while_writing(tmp_path)
    assert sorted(name[:3] for name in os.listdir(tmp_path)) == ['.a.', '.ba']
    write_text_atomically(tmp_path / 'a.json', 'x')
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write_depth_from_color(np.eye(4), depth_frame='d', color_frame='c', stamp_ns=1)
    assert sorted(os.listdir(tmp_path)) == ['a.json', 'bag']


@pytest.mark.skipif(sys.platform != 'linux', reason='looks into /proc')
def test_who_has_ended_and_is_not_buried_yet_writes_no_more(tmp_path):
    with subprocess.Popen([sys.executable, '-c', _KILLED, tmp_path]) as writer:
        # Waits for the end, and leaves the process where it is for whoever asks next.
        os.waitid(os.P_PID, writer.pid, os.WEXITED | os.WNOWAIT)
        assert ') Z ' in Path(f'/proc/{writer.pid}/stat').read_text()
        write_text_atomically(tmp_path / 'a.json', 'x')
        left = [name for name in os.listdir(tmp_path) if name.startswith('.a.')]
    assert left == []


def test_what_is_being_written_or_belongs_to_others_stays(tmp_path):
    path = tmp_path / 'a.json'
    mine = fresh_path(path)
    others = [
        *(mine, fresh_path(tmp_path / 'a.txt'), fresh_path(tmp_path / 'b.json')),
        *(tmp_path / '.a.json', tmp_path / '.a.elsewhere-999999999-0123abcd.json'),
    ]
    for other in others:
        other.write_text('x')
    write_text_atomically(path, 'x')
    assert sorted(tmp_path.iterdir()) == sorted([*others, path])
