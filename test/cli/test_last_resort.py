# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What nobody foresaw ends in a sentence and a log file, never in a traceback."""

import errno
import os
import re

from diffcal_ros.cli import last_resort
from diffcal_ros.cli.commands import check, simulate
from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_FAULT
import pytest


def _raise(error: Exception):
    def run(args):
        raise error

    return run


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_fault_is_told_with_its_log(run_cli, in_folder, monkeypatch):
    monkeypatch.setattr(check, 'run', _raise(RuntimeError('first line\nsecond')))
    ran = run_cli('check', 'a scene.yaml')
    assert ran.code == EXIT_FAULT
    (log,) = in_folder.glob('diffcal-fault-*.log')
    assert ran.err == (
        'diffcal check: stopped by a fault in diffcal itself (RuntimeError: first line); please '
        f'report it, with the file {log.name}\n'
    )
    text = log.read_text()
    for part in ("['check', 'a scene.yaml']", 'Traceback', 'second', 'numpy ', 'Python 3.'):
        assert part in text


@pytest.mark.parametrize(
    ('error', 'words'),
    [
        (MemoryError(), 'MemoryError'),
        (ImportError('libx.so: failed to map segment from shared object'), 'ImportError: libx'),
        (RuntimeError("Failed to allocate 22 bytes on device 'cpu'"), 'RuntimeError: Failed'),
    ],
)
def test_too_little_memory_is_no_fault(run_cli, in_folder, monkeypatch, error, words):
    monkeypatch.setattr(check, 'run', _raise(error))
    ran = run_cli('check', 'scene.yaml')
    assert ran.code == EXIT_FAULT
    assert f'there was not enough memory ({words}' in ran.err
    assert '): use a coarser mesh' in ran.err
    (log,) = in_folder.glob('diffcal-fault-*.log')
    assert ran.err.endswith(f'or a machine with more; where stands in {log.name}\n')


def test_a_log_goes_where_results_go(run_cli, in_folder, monkeypatch):

    (in_folder / 'out').mkdir()
    monkeypatch.setattr(simulate, 'run', _raise(IndexError('x')))
    ran = run_cli('simulate', 'scene.yaml', '--out', in_folder / 'out')
    assert re.search(r'file .*out/diffcal-fault-.*\.log', ran.err)


def test_without_any_place_the_log_is_said(run_cli, monkeypatch):
    monkeypatch.setattr(check, 'run', _raise(IndexError('x')))
    monkeypatch.setattr(last_resort, '_folders', lambda args: [])
    ran = run_cli('check', 'scene.yaml')
    assert 'Traceback' in ran.err
    assert ran.err.splitlines()[-1].endswith('please report it with the lines above')


@pytest.mark.parametrize('number', [errno.EACCES, errno.ENOSPC])
def test_what_the_machine_refuses_is_no_fault(run_cli, in_folder, monkeypatch, number):
    error = OSError(number, os.strerror(number), 'a.tet')
    monkeypatch.setattr(check, 'run', _raise(error))
    ran = run_cli('check', 'scene.yaml')
    assert ran.code == EXIT_BAD_INPUT
    assert ran.err.startswith(f'diffcal check: a.tet: {os.strerror(number)}: see that files')
    assert not list(in_folder.iterdir())


def test_a_name_that_grows_too_long_is_no_fault(run_cli, write_scene, in_folder):
    scene = in_folder / f'{"x" * 250}.yaml'
    write_scene().rename(scene)
    ran = run_cli('check', scene)
    assert ran.code == EXIT_BAD_INPUT
    assert 'File name too long' in ran.err
