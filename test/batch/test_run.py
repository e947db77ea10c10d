# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A batch from its bodies to their results, whoever does the work."""

from pathlib import Path
import shutil

from diffcal_ros.batch.job import do_job
from diffcal_ros.batch.manifest import Body
from diffcal_ros.batch.run import plan, run_batch
from diffcal_ros.errors import InputError
from diffcal_ros.workers.ended import Ended
import pytest


class _Here:
    """Does tasks in this process; those of some bodies come to nothing."""

    def __init__(self, faults: tuple[str, ...] = ()) -> None:
        self.faults, self.given = faults, []

    def run(self, work, tasks):
        self.given += [task.name for task in tasks]
        for task in tasks:
            if task.name in self.faults:
                yield Ended(task, None, 'its process died')
            else:
                yield Ended(task, work(task))


def _command(arguments) -> int:
    out = Path(arguments[arguments.index('--out') + 1])
    (out / 'result.json').write_text('{"outcome": "converged"}')
    return 0


def _work(job):
    return do_job(job, _command)


@pytest.fixture
def bodies(tmp_path) -> list[Body]:
    scene = tmp_path / 'scene.yaml'
    scene.write_text('format: 1\n')
    return [Body(name, 'calibrate', scene, (), {}, ()) for name in ('one', 'two', 'three')]


def test_what_is_left_is_done_and_all_is_read(bodies, tmp_path) -> None:
    first = _Here(faults=('two',))
    told = []
    results = run_batch(
        bodies,
        plan(bodies, tmp_path / 'out'),
        _work,
        first,
        lambda number, count, result: told.append((number, count, result.body.name)),
    )
    assert [result.ending for result in results] == ['converged', 'failed', 'converged']
    assert results[1].words == 'its process died'
    assert told == [(1, 3, 'one'), (2, 3, 'two'), (3, 3, 'three')]
    again = _Here()
    results = run_batch(bodies, plan(bodies, tmp_path / 'out'), _work, again)
    assert [result.ending for result in results] == ['converged'] * 3
    assert (first.given, again.given) == (['one', 'two', 'three'], ['two'])


def test_a_change_of_the_scene_makes_all_of_it_anew(bodies, tmp_path) -> None:
    run_batch(bodies, plan(bodies, tmp_path / 'out'), _work, _Here())
    bodies[0].scene.write_text('format: 1\n# changed\n')
    again = _Here()
    run_batch(bodies, plan(bodies, tmp_path / 'out'), _work, again)
    assert again.given == ['one', 'two', 'three']


def test_a_worker_with_another_disk_is_told(bodies, tmp_path) -> None:
    def elsewhere(job):
        account = _work(job)
        shutil.rmtree(job.folder)
        return account

    results = run_batch(bodies, plan(bodies, tmp_path / 'out'), elsewhere, _Here())
    assert all('on a disk that all workers share' in result.words for result in results)


def test_a_folder_that_cannot_be_made_is_told(bodies, tmp_path) -> None:
    (tmp_path / 'file').touch()
    with pytest.raises(InputError, match=r'cannot be made .*: give another folder with --out'):
        plan(bodies, tmp_path / 'file')
