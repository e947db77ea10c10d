# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A job is done once, and its folder is whole or not there."""

from dataclasses import replace
import os
from pathlib import Path
import subprocess
import sys

from diffcal_ros.batch.body_result import read_result
from diffcal_ros.batch.fingerprint import Fingerprints
from diffcal_ros.batch.job import do_job, Job, LOG, read_account
from diffcal_ros.batch.manifest import Body
import pytest


@pytest.fixture
def job(tmp_path) -> Job:
    return Job('one', ('calibrate', '--scene', 's.yaml'), tmp_path / 'bodies' / 'one', 'abc')


class _Command:
    """Counts its runs, writes a file and says something."""

    def __init__(self, code: int = 0) -> None:
        self.code, self.outs = code, []

    def __call__(self, arguments) -> int:
        out = Path(arguments[arguments.index('--out') + 1])
        self.outs.append(out)
        (out / 'result.json').write_text('{"outcome": "converged"}')
        print(f'first\nresult {out}/result.json')
        return self.code


def test_what_is_done_is_not_done_again(job) -> None:
    command = _Command()
    account = do_job(job, command)
    assert do_job(job, command) == account == read_account(job)
    assert len(command.outs) == 1
    assert sorted(path.name for path in job.folder.iterdir()) == [
        'job.json',
        'log.txt',
        'result.json',
    ]
    assert (job.folder / LOG).read_text() == f'first\nresult {job.folder}/result.json\n'
    assert [path.name for path in job.folder.parent.iterdir() if path != job.folder] == ['.locks']


def test_what_failed_is_told_and_tried_again(job) -> None:
    account = do_job(job, _Command(2))
    assert not account.is_done
    assert account.words == f'result {job.folder}/result.json'
    assert do_job(job, _Command()).is_done


def test_another_job_takes_the_place_of_the_last(job) -> None:
    do_job(job, _Command())
    (job.folder / 'old').touch()
    other = replace(job, fingerprint='def')
    assert read_account(other) is None
    assert do_job(other, _Command()).fingerprint == 'def'
    assert not (job.folder / 'old').exists()


def test_what_raises_leaves_nothing(job) -> None:
    def fail(arguments):
        raise RuntimeError('out of order')

    with pytest.raises(RuntimeError, match='out of order'):
        do_job(job, fail)
    assert [path.name for path in job.folder.parent.iterdir()] == ['.locks']


_TWICE = """
import sys, time
from pathlib import Path
from diffcal_ros.batch.job import do_job, Job
def run(arguments):
    with open(sys.argv[2], 'a') as file:
        file.write('run\\n')
    time.sleep(1.0)
    return 0
do_job(Job('one', ('calibrate',), Path(sys.argv[1]), 'abc'), run)
"""


@pytest.mark.skipif(sys.platform == 'win32', reason='has no flock')
def test_two_processes_with_one_job_do_it_once(tmp_path) -> None:
    paths = [str(tmp_path / 'bodies' / 'one'), str(tmp_path / 'runs')]
    environment = {**os.environ, 'PYTHONPATH': os.getcwd()}
    both = [
        subprocess.Popen([sys.executable, '-c', _TWICE, *paths], env=environment) for _ in range(2)
    ]
    assert [one.wait() for one in both] == [0, 0]
    assert (tmp_path / 'runs').read_text() == 'run\n'


def test_results_rest_on_every_file_that_is_read(tmp_path) -> None:
    for name in ('beam.tet', 'take/bag.mcap', 'other.txt'):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text('before')
    scene = tmp_path / 'scene.yaml'
    scene.write_text('mesh: {file: beam.tet}\nbag: take\n')
    body = Body('one', 'calibrate', scene, (), {}, ('--no-search',))
    first = Fingerprints().of(body)
    assert Fingerprints().of(replace(body, material={'': 'soft'})) == first
    assert Fingerprints().of(replace(body, options=())) != first
    (tmp_path / 'other.txt').write_text('of no matter')
    assert Fingerprints().of(body) == first
    found = {first}
    for name in ('beam.tet', 'take/bag.mcap', 'scene.model.yaml'):
        (tmp_path / name).write_text('changed now')
        found.add(Fingerprints().of(body))
    assert len(found) == 4


def test_a_result_that_cannot_be_read_is_a_fault(job, tmp_path) -> None:
    body = Body('one', 'calibrate', tmp_path / 's.yaml', (), {}, ())
    account = do_job(job, _Command())
    (job.folder / 'result.json').write_text('{')
    result = read_result(body, job, account)
    assert result.ending == 'failed'
    assert 'cannot be read' in result.words
