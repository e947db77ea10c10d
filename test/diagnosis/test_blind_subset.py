# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Eighteen cases of the independent generator's development set, diagnosed without their labels.

The whole set takes an hour: `make blind`.
"""

from pathlib import Path

import pytest

from benchmarks.blind.answers import Answer
from benchmarks.blind.generator import main as generate
from benchmarks.blind.scorer import read_answers
from benchmarks.diagnosis import judge

pytestmark = pytest.mark.slow
CLEAN = ('clean_000', 'clean_001', 'clean_002', 'clean_012', 'clean_013')
FAULTY = (1, 2, 7, 12, 14, 30, 33, 46, 85, 86, 116, 123, 135)


@pytest.fixture(scope='module')
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Answer]:
    folder = tmp_path_factory.mktemp('blind')
    names = [*CLEAN, *(f'case_{number:03d}' for number in FAULTY)]
    found = {}
    for name in names:
        generate(['--set', 'development', '--out', str(folder), '--only', name, '--jobs', '1'])
        judge(folder / 'cases' / name, folder / 'run' / name)
    for answer in read_answers(Path(folder / 'run'), folder / 'labels')[0]:
        found[answer.label['id']] = answer
    assert len(found) == len(names)
    return found


def test_clean_data_raise_no_alarm(answers):
    assert [name for name in CLEAN if answers[name].is_alarm] == []


def test_the_truth_is_in_the_reported_set(answers):
    faulty = [answer for name, answer in answers.items() if name not in CLEAN]
    missed = [a.label['id'] for a in faulty if not set(a.truth) <= a.reported]
    assert len(missed) <= 1, missed
    assert [a.label['id'] for a in faulty if a.is_confidently_wrong] == []


def test_the_modulus_heals(answers):
    """Over all cases that were named, E is nearer to the truth with the effect than without."""
    named = [a for name, a in answers.items() if name not in CLEAN and a.named]
    errors = [error for a in named if (error := a.modulus_errors()) is not None]
    assert len(errors) >= 4
    before, after = (sorted(pair[place] for pair in errors) for place in range(2))
    assert after[len(after) // 2] < 0.02
    assert sum(after) < sum(before)
