# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Paths that stand for no file, or for none that could be read, are refused with a sentence."""

import os
import re
import sys

import pytest

LONG = 'x' * 256


@pytest.mark.parametrize(
    ('path', 'sentence'),
    [
        ('~nosuchuser/scene.yaml', "'~nosuchuser/scene.yaml' starts with the home folder of a"),
        (f'{LONG}/scene.yaml', 'is too long for a path: a name has at most 255 bytes'),
        ('a/' * 3000, 'is too long for a path'),
    ],
)
def test_an_argument_that_is_no_path(run_cli, path, sentence, capsys):
    with pytest.raises(SystemExit, match='2'):
        run_cli('check', path)
    assert sentence in capsys.readouterr().err


def test_the_home_folder_is_meant_where_a_shell_does_not_say_so(
    run_cli, write_scene, tmp_path, monkeypatch
):
    monkeypatch.setenv('HOME', str(tmp_path / 'home'))
    monkeypatch.chdir(tmp_path)
    assert run_cli('check', write_scene(), '--draw=~/scene.png').code == 0
    assert (tmp_path / 'home' / 'scene.png').is_file()
    assert not (tmp_path / '~').exists()


@pytest.mark.parametrize('key', ['mesh.file', 'bag'])
@pytest.mark.parametrize(
    ('path', 'sentence'),
    [
        ('~nosuchuser/x.tet', 'is no path: .* home folder of a user who is not known'),
        (f'{LONG}.tet', 'is no path: x.* is too long for a path'),
        ('\ud800.tet', 'is no path: .* a character that no file name can have'),
        ('a\0b.tet', 'is no path: .* a character that no file name can have'),
    ],
)
def test_a_scene_that_names_no_path(run_cli, write_scene, key, path, sentence):
    ran = run_cli('check', write_scene({key: path}), '--no-draw')
    assert ran.code == 2

    assert re.search(rf'line \d+: {key} {sentence}', ran.err), ran.err


def test_what_is_no_plain_file_is_not_waited_for(run_cli, tmp_path):
    os.mkfifo(tmp_path / 'pipe.yaml')
    for path in (tmp_path / 'pipe.yaml', '/dev/zero'):
        ran = run_cli('check', path)
        assert ran.code == 2
        assert f'{path} is a pipe or a device: save what it gives to a file' in ran.err
    with (tmp_path / 'large.yaml').open('wb') as file:
        file.truncate(10**11)
    ran = run_cli('check', tmp_path / 'large.yaml')
    assert ran.code == 2
    assert 'has 100000 MB, and 10 are read at most' in ran.err


@pytest.mark.skipif(sys.platform != 'linux', reason='other systems allow no such name')
def test_a_name_that_is_no_utf_8_simply_works(run_cli, write_scene, tmp_path):
    folder = tmp_path / os.fsdecode(b'caf\xe9')
    folder.mkdir()
    scene = folder / os.fsdecode(b'sc\xffne.yaml')
    write_scene().rename(scene)
    (tmp_path / 'beam.tet').rename(folder / 'beam.tet')
    ran = run_cli('check', scene, '--draw', folder / 'x.png')
    assert (ran.code, ran.err) == (0, '')
    assert 'sc\\udcffne.yaml' in ran.out
    assert (folder / 'x.png').is_file()
