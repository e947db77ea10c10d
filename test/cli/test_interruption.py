# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C ends a command soon, whatever it is doing."""

import signal
import subprocess
import sys
import time

import pytest

# The grace that work is given, and what a busy machine needs beside it [s].
_SOON = 8.0
# From its word to its deed [s].
_BEGUN = 1.0
_COMMAND = """
import ctypes, signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)
from diffcal_ros.cli import main
from diffcal_ros.cli.commands import check

def work(args):
    print('busy', flush=True)
    {work}
    return 0

check.run = work
sys.exit(main.main(['check', 'scene.yaml']))
"""
_BUSY = {
    'between steps': '\n    try:\n        while True: time.sleep(0.01)\n'
    "    finally:\n        print('in order', flush=True)",
    'native code': 'ctypes.CDLL(None).sleep(60)',
    # As a library's parser that is struck in its constructor: it has no end without a beginning.
    'an object half made': '\n    class Parser:\n        def __init__(self):\n'
    '            while not time.sleep(0.01): pass\n'
    '            self.rule = None\n'
    '        def __del__(self): self.rule\n    Parser()',
    # It holds Python's lock, and looks at no signal.
    'native code that keeps Python waiting': 'sum(range(10**11))',
}


def _start(work: str) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, '-c', _COMMAND.format(work=_BUSY[work])],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == 'busy\n'
    time.sleep(_BEGUN)
    return process


def _interrupt(process: subprocess.Popen[str]) -> None:
    process.send_signal(signal.SIGINT)


@pytest.mark.parametrize(
    ('work', 'rest'),
    [('between steps', 'in order\n'), ('native code', ''), ('an object half made', '')],
)
@pytest.mark.slow_but_first
def test_the_first_interrupt_ends_the_command_soon(work, rest):
    process = _start(work)
    begun = time.monotonic()
    _interrupt(process)
    out, err = process.communicate(timeout=60.0)
    assert time.monotonic() - begun < _SOON
    assert process.returncode == 130
    assert (out, err) == (rest, 'diffcal check: interrupted\n')


def test_the_second_interrupt_ends_it_at_once():
    process = _start('native code that keeps Python waiting')
    begun = time.monotonic()
    _interrupt(process)
    time.sleep(0.5)
    assert process.poll() is None
    _interrupt(process)
    _, err = process.communicate(timeout=60.0)
    assert time.monotonic() - begun < _SOON
    assert process.returncode == -signal.SIGINT
    assert err == ''


_INTERRUPTED_AT = {
    'a module': 'import signal; signal.raise_signal(signal.SIGINT)',
    'an object half made': """
import signal
class Parser:
    def __init__(self):
        signal.raise_signal(signal.SIGINT)
        self.rule = None
    def __del__(self):
        self.rule
Parser()
""",
}


@pytest.mark.parametrize('slow', _INTERRUPTED_AT.values(), ids=list(_INTERRUPTED_AT))
def test_while_modules_load_it_is_no_fault_either(tmp_path, slow):
    """What is imported last interrupts, as Ctrl-C does."""
    code = (
        'import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n'
        'sys.modules.pop("argparse", None)\n'
        f'sys.path.insert(0, {str(tmp_path)!r})\n'
        'from diffcal_ros.cli.program import main\n'
        'sys.exit(main())'
    )
    (tmp_path / 'argparse.py').write_text(slow)
    done = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 130
    assert done.stderr == 'diffcal: interrupted before it began\n'
