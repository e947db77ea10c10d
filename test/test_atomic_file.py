# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A file is written completely or stays as it was."""

import errno

from diffcal_ros.atomic_file import replacing, write_text_atomically
from diffcal_ros.errors import InputError
import pytest


def test_text_arrives_and_nothing_else_is_left(tmp_path):
    write_text_atomically(tmp_path / 'new' / 'a.txt', 'änderung')
    assert (tmp_path / 'new' / 'a.txt').read_text(encoding='utf-8') == 'änderung'
    write_text_atomically(tmp_path / 'new' / 'a.txt', 'second')
    assert [path.name for path in (tmp_path / 'new').iterdir()] == ['a.txt']
    assert (tmp_path / 'new' / 'a.txt').read_text() == 'second'


@pytest.mark.parametrize('failure', [RuntimeError('stop'), KeyboardInterrupt()])
def test_an_interrupted_write_leaves_the_old_file(tmp_path, failure):
    path = tmp_path / 'a.txt'
    path.write_text('old')

    def write_half():
        with replacing(path) as fresh:
            fresh.write_text('half')
            raise failure

    with pytest.raises(type(failure)):
        write_half()
    assert path.read_text() == 'old'
    assert [file.name for file in tmp_path.iterdir()] == ['a.txt']


def test_a_full_disk_is_told_and_leaves_the_old_file(tmp_path):
    path = tmp_path / 'a.txt'
    path.write_text('old')

    def write_to_full_disk():
        with replacing(path) as fresh:
            fresh.write_text('half')
            raise OSError(errno.ENOSPC, 'No space left on device')

    with pytest.raises(InputError, match=r'a.txt cannot be written \(No space left on device\)'):
        write_to_full_disk()
    assert path.read_text() == 'old'
    assert [file.name for file in tmp_path.iterdir()] == ['a.txt']


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(InputError, match='is a folder: name the file to write'):
        write_text_atomically(tmp_path, 'text')


def test_a_new_file_has_the_rights_that_the_user_asked_for(tmp_path):
    """A temporary file of 0600 put in its place would hide results from others."""
    usual = tmp_path / 'usual.txt'
    usual.write_text('x')
    write_text_atomically(tmp_path / 'a.txt', 'x')
    assert (tmp_path / 'a.txt').stat().st_mode == usual.stat().st_mode
