# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal batch` from the outside: real fits in real processes, some of which are killed."""

from collections.abc import Callable
import csv
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE, main
import pytest
from support.dask_processes import dask_processes
from support.processes import wait_until_gone
import yaml

from benchmarks.batch.kills import CODE, same_figures, workers_of
from benchmarks.batch.recordings import make_recordings

_BODIES = 4
# What a busy machine may take for the first body of a batch [s].
_PATIENCE = 300.0


@pytest.fixture(scope='module')
def manifest(tmp_path_factory) -> Path:
    """Four small recordings."""
    return make_recordings(tmp_path_factory.mktemp('recordings'), _BODIES, 7)


@pytest.fixture(scope='module')
def alone(manifest, tmp_path_factory) -> Path:
    """The same, done one by one."""
    out = tmp_path_factory.mktemp('alone')
    for row in csv.DictReader(manifest.open(newline='')):
        scene, bag = manifest.parent / row['scene'], manifest.parent / row['recordings']
        own = ['--scene', str(scene), '--out', str(out / row['body'])]
        assert main(['calibrate', str(bag), *own, *row['options'].split()]) == EXIT_DONE
    return out


def _marks(out: Path) -> dict[str, tuple[int, int]]:
    """Return inode and time of what is done."""
    found = {mark.parent.name: mark.stat() for mark in (out / 'bodies').glob('[!.]*/job.json')}
    return {name: (state.st_ino, state.st_mtime_ns) for name, state in found.items()}


def _faults(out: Path, alone: Path) -> list[str]:
    """List what is not there, as one by one, and what is left half done."""
    folders = {path.name for path in (out / 'bodies').iterdir()} - {'.locks'}
    wanted = {path.name for path in alone.iterdir()}
    return [
        *(f'{name} is missing' for name in wanted - folders),
        *(f'{name} was left' for name in folders - wanted),
        *(
            f'{name} says something else'
            for name in folders & wanted
            if not same_figures(*(top / name / 'result.json' for top in (out / 'bodies', alone)))
        ),
    ]


def _start(*arguments: object) -> subprocess.Popen:
    """Start a batch in a session of its own."""
    return subprocess.Popen(
        [sys.executable, '-c', CODE, 'batch', *map(str, arguments)],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, 'PYTHONPATH': _paths()},
    )


def _paths() -> str:
    return os.pathsep.join([os.getcwd(), os.environ.get('PYTHONPATH', '')])


def _wait_for(what: Callable[[], bool]) -> None:
    begun = time.monotonic()
    while not what():
        assert time.monotonic() - begun < _PATIENCE
        time.sleep(0.05)


@pytest.mark.slow
def test_a_batch_says_what_one_by_one_says_and_is_done_once(
    manifest, alone, run_cli, tmp_path
) -> None:
    ran = run_cli('batch', manifest, '--out', tmp_path, '--jobs', 2)
    assert ran.code == EXIT_DONE
    assert f'{_BODIES} bodies: {_BODIES} converged (0 were done before)' in ran.out
    assert ran.err.count(f'of {_BODIES}: body_00') == _BODIES
    assert not _faults(tmp_path, alone)
    page = (tmp_path / 'batch.html').read_text()
    assert all(f'bodies/body_00{n}/report.html' in page for n in range(_BODIES))
    with (tmp_path / 'batch.csv').open(newline='') as file:
        assert [row['body'] for row in csv.DictReader(file)] == sorted(os.listdir(alone))
    before = _marks(tmp_path)
    ran = run_cli('batch', manifest, '--out', tmp_path, '--jobs', 2)
    assert f'({_BODIES} were done before)' in ran.out
    assert _marks(tmp_path) == before


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != 'linux', reason='looks into /proc')
def test_a_master_that_is_killed_loses_nothing_and_does_nothing_twice(
    manifest, alone, run_cli, tmp_path
) -> None:
    with _start(manifest, '--out', tmp_path, '--jobs', 2) as master:
        _wait_for(lambda: len(_marks(tmp_path)) > 0)
        workers = workers_of(master.pid)
        master.kill()
        master.communicate()
    assert workers
    wait_until_gone(workers)
    before = _marks(tmp_path)
    assert 0 < len(before) < _BODIES
    assert run_cli('batch', manifest, '--out', tmp_path, '--jobs', 2).code == EXIT_DONE
    assert {name: _marks(tmp_path)[name] for name in before} == before
    assert not _faults(tmp_path, alone)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != 'linux', reason='looks into /proc')
def test_a_worker_that_is_killed_costs_nothing_but_time(manifest, alone, tmp_path) -> None:
    with _start(manifest, '--out', tmp_path, '--jobs', 2) as master:
        _wait_for(lambda: len(_marks(tmp_path)) > 0)
        before = _marks(tmp_path)
        os.kill(workers_of(master.pid)[0], signal.SIGKILL)
        master.communicate()
    assert master.returncode == EXIT_DONE
    assert {name: _marks(tmp_path)[name] for name in before} == before
    assert not _faults(tmp_path, alone)


@pytest.mark.slow
def test_a_cluster_of_three_workers_of_which_one_is_killed(manifest, alone, tmp_path) -> None:
    pytest.importorskip('distributed', reason='Dask is not installed')
    out = tmp_path / 'out'
    with (
        dask_processes(tmp_path, 3) as running,
        _start(manifest, '--out', out, '--cluster', running.address) as master,
    ):
        _wait_for(lambda: len(_marks(out)) > 0)
        before = _marks(out)
        # One that is at work: its folder has its number.
        at_work = [path.name for path in (out / 'bodies').glob('.body*')]
        victims = [one for one in running.workers if any(f'-{one.pid}-' in n for n in at_work)]
        (victims or running.workers)[0].kill()
        master.communicate()
        assert sum(worker.poll() is not None for worker in running.workers) == 1
    assert master.returncode == EXIT_DONE
    assert {name: _marks(out)[name] for name in before} == before
    folders = {path.name for path in (out / 'bodies').iterdir()} - {'.locks'}
    finished = {name for name in folders if not name.startswith('.')}
    assert finished == set(os.listdir(alone))
    assert all(
        same_figures(out / 'bodies' / name / 'result.json', alone / name / 'result.json')
        for name in finished
    )


def test_a_body_that_fails_is_told_and_the_others_go_on(manifest, run_cli, tmp_path) -> None:
    (tmp_path / 'empty').mkdir()
    scene, bag = manifest.parent / 'body_000/scene.yaml', manifest.parent / 'body_000/bag'
    document = {
        'format': 1,
        'scene': str(scene),
        'options': '--no-search --no-mesh-error --max-iterations 2',
        'bodies': [
            {'body': 'bad', 'recordings': [str(tmp_path / 'empty')]},
            {'body': 'unfinished', 'recordings': [str(bag)]},
        ],
    }
    path = tmp_path / 'batch.yaml'
    path.write_text(yaml.safe_dump(document))
    ran = run_cli('batch', path, '--out', tmp_path / 'out', '--jobs', 1)
    assert ran.code == EXIT_BAD_INPUT
    assert f'failed    bad: diffcal calibrate: {tmp_path / "empty"}' in ran.out
    content = json.loads((tmp_path / 'out' / 'batch.json').read_text())
    assert [body['account']['exit_code'] for body in content['bodies']] == [EXIT_BAD_INPUT, 3]
    document['bodies'] = document['bodies'][1:]
    path.write_text(yaml.safe_dump(document))
    assert run_cli('batch', path, '--out', tmp_path / 'out', '--jobs', 1).code == 3


@pytest.mark.parametrize(
    ('options', 'sentence'),
    [
        ('--lore all', 'unrecognized arguments: --lore'),
        ('--loss huber', "argument --loss: invalid choice: 'huber'"),
        ('--out elsewhere', '--scene and --out have keys of their own'),
        ('other_take', 'recordings have a key of their own'),
    ],
)
def test_options_that_the_command_refuses_are_told_with_their_line(
    manifest, run_cli, tmp_path, options, sentence
) -> None:
    scene = manifest.parent / 'body_000/scene.yaml'
    (tmp_path / 'batch.csv').write_text(f'body,scene,options\none,{scene},{options}\n')
    ran = run_cli('batch', tmp_path / 'batch.csv', '--out', tmp_path / 'out')
    assert ran.code == EXIT_BAD_INPUT
    assert 'batch.csv, line 2: bodies[0].options are' in ran.err
    assert sentence in ran.err
    assert not (tmp_path / 'out').exists()


@pytest.mark.parametrize(
    ('options', 'sentence'),
    [
        (('--jobs', 0), '--jobs is 0: give how many processes may work at once'),
        (('--jobs', 2, '--cluster', 'tcp://a:1'), 'leave one of them out'),
    ],
)
def test_what_is_asked_for_must_make_sense(manifest, run_cli, tmp_path, options, sentence) -> None:
    ran = run_cli('batch', manifest, '--out', tmp_path, *options)
    assert ran.code == EXIT_BAD_INPUT
    assert sentence in ran.err
