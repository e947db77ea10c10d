# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Homes that are missing, odd or not to be written to; and Warp starts without noise."""

import os
from pathlib import Path
import subprocess
import sys

from diffcal_ros import user_folders
from diffcal_ros.errors import InputError
from diffcal_ros.user_folders import cache_home, settle_home
from diffcal_ros.warp_runtime import kernel_cache
from diffcal_ros.warp_runtime.kernel_cache import settle_kernel_cache
import pytest

NAMES = ('HOME', 'XDG_CACHE_HOME', 'XDG_CONFIG_HOME', 'MPLCONFIGDIR', 'WARP_CACHE_PATH')
# Nobody, root neither, can make a folder there.
NOWHERE = '/dev/null/home'


@pytest.fixture
def environment(monkeypatch, tmp_path):
    """Start from a usual one; what a test changes is put back."""
    for name in NAMES:
        monkeypatch.setenv(name, 'put back')
        monkeypatch.delenv(name)
    monkeypatch.setenv('HOME', str(tmp_path / 'home'))
    monkeypatch.chdir(tmp_path)
    return os.environ


def test_tildes_are_expanded_and_what_is_relative_is_left_out(environment, tmp_path, capsys):
    environment.update(XDG_CACHE_HOME='~/caches', XDG_CONFIG_HOME='rel', WARP_CACHE_PATH='~')
    settle_home()
    assert environment['XDG_CACHE_HOME'] == str(tmp_path / 'home' / 'caches')
    assert environment['WARP_CACHE_PATH'] == str(tmp_path / 'home')
    assert 'XDG_CONFIG_HOME' not in environment
    assert cache_home() == tmp_path / 'home' / 'caches'
    assert capsys.readouterr().err == ''


@pytest.mark.parametrize('home', ['', '~', 'relative'])
def test_an_odd_home_is_looked_up_instead(environment, home):
    environment['HOME'] = home
    settle_home()
    assert Path.home().is_absolute()
    assert cache_home().is_absolute()


def test_without_a_home_there_is_a_temporary_one(environment, monkeypatch, capsys):
    del environment['HOME']

    def missing(self):
        raise KeyError('no such user')

    monkeypatch.setattr('pwd.getpwuid', missing)
    settle_home()
    assert 'home' in Path.home().name
    assert Path.home().is_dir()
    assert 'there is no home folder, and a temporary one is used' in capsys.readouterr().err


@pytest.mark.parametrize('name', ['HOME', 'XDG_CACHE_HOME', 'WARP_CACHE_PATH'])
def test_kernels_go_elsewhere_where_they_cannot_be_kept(environment, name, capsys):
    environment[name] = NOWHERE
    settle_kernel_cache()
    assert Path(environment['WARP_CACHE_PATH']).is_dir()
    said = capsys.readouterr().err
    assert said.startswith(f'compiled kernels cannot be kept in {NOWHERE}')
    assert said.count('\n') == 1


def test_kernels_that_are_there_are_used_though_none_can_be_added(
    environment, tmp_path, monkeypatch
):
    module = tmp_path / 'home' / '.cache' / 'warp' / '1.2.3' / 'wp_module'
    module.mkdir(parents=True)
    (module / 'kernel.o').write_text('compiled')
    monkeypatch.setattr(kernel_cache, '_has_room', lambda folder: False)
    settle_kernel_cache()
    fresh = Path(environment['WARP_CACHE_PATH'])
    assert (fresh / '1.2.3' / 'wp_module' / 'kernel.o').read_text() == 'compiled'


def test_a_usual_home_is_left_alone(environment, tmp_path, capsys):
    settle_kernel_cache()
    assert 'WARP_CACHE_PATH' not in environment
    assert not (tmp_path / '~').exists()
    assert capsys.readouterr().err == ''


def test_a_machine_without_any_room_is_told(monkeypatch):
    def full(**_):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(user_folders.tempfile, 'mkdtemp', full)
    with pytest.raises(InputError, match=r'no place for temporary files \(No space left'):
        user_folders.temporary_folder('x')


def test_warp_starts_in_silence_and_other_words_are_kept():
    code = (
        'import os, diffcal_ros.warp_runtime.device_array\n'
        'from diffcal_ros.warp_runtime import start\n'
        'with start._without_expected_lines():\n'
        '    os.write(2, b"Warp: Could not find or load the NVIDIA CUDA driver\\n")\n'
        '    os.write(2, b"Warp CUDA error: real\\n")\n'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ('', 'Warp CUDA error: real\n')


def test_too_little_address_space_is_told_before_a_library_waits_for_it(tmp_path):
    code = (
        'import resource; resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))\n'
        'from diffcal_ros.errors import InputError\n'
        'from diffcal_ros.warp_runtime.start import start_warp\n'
        'try:\n    start_warp()\nexcept InputError as error:\n    print(error)'
    )
    done = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=False
    )
    assert done.stdout == (
        'this process may use 1 GB of address space (ulimit -v), and simulating takes 1.5 GB at '
        'least: raise that limit\n'
    )
    assert done.stderr == ''
