# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal check` from the outside: output, files and exit codes."""

import subprocess
import sys

from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE, main
import pytest

_PNG = b'\x89PNG\r\n\x1a\n'


def test_a_sound_scene_is_printed_and_drawn_in_the_current_folder(
    write_scene, tmp_path, monkeypatch, capsys
):
    scene = write_scene()
    (tmp_path / 'work').mkdir()
    monkeypatch.chdir(tmp_path / 'work')
    assert main(['check', str(scene)]) == EXIT_DONE
    printed = capsys.readouterr()
    assert 'drawing       scene_check.png' in printed.out
    assert "Young's modulus 60 kPa" in printed.out
    assert printed.err == ''
    assert (tmp_path / 'work' / 'scene_check.png').read_bytes().startswith(_PNG)


def test_the_drawing_goes_where_it_is_told_or_nowhere(write_scene, tmp_path, capsys):
    scene = str(write_scene())
    assert main(['check', scene, '--draw', str(tmp_path / 'new' / 'x.png')]) == EXIT_DONE
    assert (tmp_path / 'new' / 'x.png').read_bytes().startswith(_PNG)
    assert f'drawing       {tmp_path / "new" / "x.png"}' in capsys.readouterr().out
    before = set(tmp_path.rglob('*'))
    assert main(['check', scene, '--no-draw']) == EXIT_DONE
    assert set(tmp_path.rglob('*')) == before
    assert 'drawing  ' not in capsys.readouterr().out


def test_mistakes_are_printed_without_a_stack_trace(write_scene, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scene = write_scene({'gravity': 'down', 'mesh.unit': 'inch'})
    assert main(['check', str(scene)]) == EXIT_BAD_INPUT
    printed = capsys.readouterr()
    assert printed.out == ''
    assert printed.err.startswith(f'diffcal check: {scene}: 2 mistakes\n')
    assert "gravity is 'down'" in printed.err
    assert 'Traceback' not in printed.err
    assert not list(tmp_path.glob('*.png'))


@pytest.mark.parametrize('target', ['.', 'scene.yaml/x.png'])
def test_a_drawing_that_cannot_be_written_is_bad_input(write_scene, tmp_path, capsys, target):
    scene = write_scene()
    assert main(['check', str(scene), '--draw', str(tmp_path / target)]) == EXIT_BAD_INPUT
    assert 'diffcal check: ' in capsys.readouterr().err


@pytest.mark.slow
def test_checking_needs_neither_opencv_nor_warp(write_scene, tmp_path):
    """A fresh interpreter, because others in this run may have imported them."""
    code = (
        'import sys; from diffcal_ros.cli.main import main; '
        f'code = main(["check", {str(write_scene())!r}, "--draw", {str(tmp_path / "x.png")!r}]); '
        'loaded = {"cv2", "warp", "torch", "rclpy", "pytetwild"} & set(sys.modules); '
        'sys.exit(f"{code} {loaded}" if code or loaded else 0)'
    )
    done = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
