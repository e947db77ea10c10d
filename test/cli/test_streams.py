# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Output that nobody reads, that is full, or that lacks a letter costs no result."""

import errno
from io import BytesIO, StringIO, TextIOWrapper
import json
import os
import subprocess
import sys

from diffcal_ros.cli.commands import check
from diffcal_ros.cli.lasting_stream import lasting_streams
from diffcal_ros.cli.main import EXIT_NOT_FITTED, EXIT_NOT_SAID, main
import pytest

FILES = ['report.html', 'result.json']


class Broken(StringIO):
    """A stream that fails after its first letters."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self._error = OSError(number, os.strerror(number))

    def write(self, text: str) -> int:
        if self.tell():
            raise self._error
        return super().write(text[:1])


def _calibrate(recorded_beam, out) -> int:
    arguments = ['calibrate', '--scene', recorded_beam.scene, '--max-iterations', 1, '--out', out]
    return main([*map(str, arguments), '--no-search', '--no-mesh-error'])


@pytest.mark.slow
def test_a_reader_who_goes_away_costs_neither_files_nor_code(
    recorded_beam, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(sys, 'stdout', Broken(errno.EPIPE))
    monkeypatch.setattr(sys, 'stderr', errors := StringIO())
    assert _calibrate(recorded_beam, tmp_path / 'out') == EXIT_NOT_FITTED
    assert sorted(os.listdir(tmp_path / 'out')) == FILES
    assert json.loads((tmp_path / 'out' / 'result.json').read_text())['outcome'] == 'not_converged'
    assert 'standard output' not in errors.getvalue()


@pytest.mark.slow
def test_progress_that_cannot_be_said_does_not_end_the_fit(recorded_beam, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', Broken(errno.EPIPE))
    assert _calibrate(recorded_beam, tmp_path / 'out') == EXIT_NOT_FITTED
    assert sorted(os.listdir(tmp_path / 'out')) == FILES


def test_a_full_output_is_told(monkeypatch, capsys):
    monkeypatch.setattr(check, 'run', lambda args: print('x\n' * 9) or 0)
    monkeypatch.setattr(sys, 'stdout', Broken(errno.ENOSPC))
    assert main(['check', 'scene.yaml']) == EXIT_NOT_SAID
    assert capsys.readouterr().err == (
        'diffcal check: standard output cannot be written (No space left on device): send it '
        'elsewhere. All files are written\n'
    )


@pytest.mark.parametrize(('encoding', 'said'), [('ascii', b'\\xe9'), ('utf-8', b'\xc3\xa9')])
def test_letters_that_a_terminal_lacks_are_escaped(monkeypatch, encoding, said):
    target = BytesIO()
    monkeypatch.setattr(sys, 'stdout', TextIOWrapper(target, encoding=encoding))
    with lasting_streams():
        print('é, and \udcff of a file name')
    assert target.getvalue() == said + b', and \\udcff of a file name\n'


def test_closed_streams_are_no_place_for_files(write_scene):
    """What is opened first takes the number of a closed stream, and would be written to."""
    code = 'import os; from diffcal_ros.cli.main import main; '
    code += 'os.close(1); os.close(2); code = main(["check", {!r}, "--no-draw"]); '
    code += 'os.fstat(1); os.fstat(2); os._exit(code)'
    done = subprocess.run([sys.executable, '-c', code.format(str(write_scene()))], check=False)
    assert done.returncode == 0


@pytest.mark.slow
def test_the_real_pipe_and_the_real_full_device(write_scene):
    code = 'import sys; from diffcal_ros.cli.main import main; sys.exit(main())'
    command = [sys.executable, '-c', code, 'check', str(write_scene()), '--no-draw']
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, 'w') as pipe, open('/dev/full', 'w') as full:
        for output, expected in ((pipe, (0, '')), (full, (EXIT_NOT_SAID, 'No space left'))):
            done = subprocess.run(
                command, stdout=output, stderr=subprocess.PIPE, text=True, check=False
            )
            assert done.returncode == expected[0]
            assert expected[1] in done.stderr
            assert 'Exception ignored' not in done.stderr


@pytest.mark.parametrize('back_end', ['nonsense', 'module://matplotlib_inline.backend_inline'])
@pytest.mark.slow
def test_pictures_need_no_back_end_for_windows(write_scene, tmp_path, back_end):
    code = 'import sys; from diffcal_ros.cli.program import main; sys.exit(main())'
    words = ['check', str(write_scene()), '--draw', str(tmp_path / 'scene.png')]
    done = subprocess.run(
        [sys.executable, '-c', code, *words],
        env={**os.environ, 'MPLBACKEND': back_end},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / 'scene.png').read_bytes()[:4] == b'\x89PNG'
