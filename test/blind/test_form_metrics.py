# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The table of other forms on answers whose worth is known."""

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.blind.answers import Answer
from benchmarks.blind.form_metrics import brier_score, form_metrics, grouped, reliability
from benchmarks.blind.form_table import main, row, table
from benchmarks.blind.outcomes import outcome

CLASSES = {'magnet': 'load', 'torn': 'material'}


def _answer(
    kind: str,
    truth: tuple[str, ...],
    said: dict[str, float],
    verdict: str = 'disagree',
    others: tuple[str, ...] = (),
    unknown: str | None = None,
    sensor: str = 'itof',
    law: str | None = None,
) -> Answer:
    effects = [
        {
            'identifier': name,
            'amplitude': {} if kind == 'outside' else {'form': f'odd {name}'},
            'unit': '',
        }
        for name in truth
    ]
    label = {
        'id': f'form_{len(said)}',
        'kind': kind,
        'effects': effects,
        'outside_class': CLASSES.get(truth[0]) if truth else None,
        'parameters': {'youngs_modulus': 1.0e5},
        'sensor': sensor,
        **({} if law is None else {'rubber': {'law': law}}),
    }
    named = [{'identifier': name, 'confidence': chance} for name, chance in said.items()]
    return Answer(
        label,
        {
            'verdict': verdict,
            'effects': named,
            'ambiguity_set': list(others),
            'unknown_class': unknown,
            'gap_mm': {'nominal': 1.0, 'added': 0.2},
            'seconds': 12.0,
        },
    )


BEND, MASS, TILT = 'rest_curvature', 'added_mass', 'gravity_tilt'
OUTCOMES = [
    (_answer('form', (MASS,), {MASS: 0.9}), 'right'),
    (_answer('form', (MASS,), {MASS: 0.9, TILT: 0.7}), 'right, and another'),
    (_answer('form', (MASS,), {TILT: 0.7}), 'wrong'),
    (_answer('form', (MASS,), {MASS: 0.5}), 'in the set'),
    (_answer('form', (MASS,), {TILT: 0.4}, others=(MASS,)), 'in the set'),
    (_answer('form', (MASS,), {}, unknown='load'), 'unknown, right class'),
    (_answer('form', (MASS,), {}, unknown='shape'), 'unknown, other class'),
    (_answer('form', (MASS,), {}, 'agree'), 'not seen'),
    (_answer('pair', (MASS, BEND), {MASS: 0.9, BEND: 0.8}), 'right'),
    (_answer('pair', (MASS, BEND), {MASS: 0.9}), 'one of two'),
    (_answer('pair', (MASS, BEND), {MASS: 0.9, TILT: 0.9}), 'one of two, and another'),
    (_answer('pair', (MASS, BEND), {TILT: 0.9}), 'wrong'),
    (_answer('pair', (MASS, BEND), {}, unknown='shape'), 'unknown, right class'),
    (_answer('outside', ('magnet',), {}, unknown='load'), 'unknown, right class'),
    (_answer('outside', ('magnet',), {}, unknown='shape'), 'unknown, other class'),
    (_answer('outside', ('magnet',), {TILT: 0.7}), 'wrong'),
    (_answer('outside', ('torn',), {}, 'agree'), 'not seen'),
    (_answer('clean', (), {}, 'agree'), 'quiet'),
    (_answer('clean', (), {TILT: 0.7}, 'below_margin'), 'wrong'),
    (_answer('clean', (), {}), 'alarm'),
]


@pytest.mark.parametrize(('answer', 'expected'), OUTCOMES)
def test_an_outcome_says_how_right_an_answer_is(answer: Answer, expected: str) -> None:
    assert outcome(answer) == expected


def test_rows_have_both_truths_of_a_pair_and_what_is_outside() -> None:
    pair = _answer('pair', (MASS, BEND), {MASS: 0.9}, law='plain')
    outside = _answer('outside', ('magnet',), {}, unknown='load')
    text = table([pair, outside])
    assert 'added_mass, odd added_mass and rest_curvature, odd rest_curvature' in text
    assert 'itof, plain' in text
    assert '| magnet (form_0) | itof | **unknown, right class**: disagree load |' in text
    assert row(pair)['truth'] == [[MASS, f'odd {MASS}'], [BEND, f'odd {BEND}']]
    assert row(pair)['law'] == 'plain'
    assert row(outside)['truth'] == [['magnet', None]]


def _of(answers: list[Answer], metric: str, after: str = '') -> tuple[int, int]:
    """Return hits and cases of the first metric of a name, from another one on."""
    rows = form_metrics(answers)
    names = [one['metric'] for one in rows]
    start = next(i for i, name in enumerate(names) if name.startswith(after))
    found = next(one for one in rows[start:] if one['metric'].startswith(metric))
    return found['hits'], found['count']


def test_metrics_count_what_they_say() -> None:
    answers = [answer for answer, _ in OUTCOMES]
    assert _of(answers, 'false alarms') == (1, 3)
    # Of a mass two, of a pair two, of a magnet one.
    assert _of(answers, 'a wrong name') == (5, 17)
    assert _of(answers, 'truth in the set') == (4, 8)
    assert _of(answers, 'truth or its class') == (5, 7)
    assert _of(answers, 'right single name') == (1, 8)
    assert _of(answers, 'the same, of those that disagree', 'right single name') == (1, 7)
    assert _of(answers, 'spurious second names') == (2, 13)
    assert _of(answers, 'outside: unknown or class') == (2, 4)
    assert _of(answers, 'class of the unknown right') == (1, 2)
    assert _of(answers, 'the same, of one or two', 'class of the unknown') == (1, 2)
    for answer in answers:
        # Two classes of which the second is the cause's, wherever there was one.
        told = answer.verdict['unknown_class']
        answer.verdict['unknown_classes'] = [told, 'load'] if told else []
    assert _of(answers, 'class of the unknown right') == (1, 2)
    assert _of(answers, 'the same, of one or two', 'class of the unknown') == (2, 2)
    assert _of(answers, 'pairs: both named') == (1, 5)
    assert _of(answers, 'pairs: one named') == (1, 5)


def test_confidence_is_relied_on_as_often_as_it_is_right() -> None:
    answers = [
        _answer('form', (MASS,), {MASS: 0.9, TILT: 0.7}),
        _answer('form', (MASS,), {MASS: 1.0}),
        _answer('clean', (), {TILT: 0.95}),
        _answer('form', (MASS,), {}),
    ]
    found = reliability(answers)
    assert [(one['from'], one['names']) for one in found] == [(0.7, 1), (0.9, 3)]
    assert found[0]['right'] == 0.0
    assert found[1]['right'] == pytest.approx(2.0 / 3.0)
    assert found[1]['said'] == pytest.approx(0.95)
    score, names = brier_score(answers)
    assert names == 4
    assert score == pytest.approx((0.1**2 + 0.7**2 + 0.0 + 0.95**2) / 4.0)


def test_metrics_go_by_sensor_and_by_law() -> None:
    answers = [
        _answer('form', (MASS,), {MASS: 0.9}, sensor='l515', law='plain'),
        _answer('form', (MASS,), {TILT: 0.9}, sensor='itof', law='plain'),
        _answer('form', (MASS,), {MASS: 0.9}, sensor='itof', law='fibres'),
    ]

    def right(by: str) -> dict[str, tuple[int, int]]:
        found = {}
        for name, rows in grouped(answers, by):
            one = next(one for one in rows if one['metric'].startswith('right single'))
            found[name] = (one['hits'], one['count'])
        return found

    assert right('sensor') == {'itof': (1, 2), 'l515': (1, 1)}
    assert right('law') == {'fibres': (1, 1), 'plain': (1, 2)}
    assert grouped([_answer('clean', (), {}, 'agree')], 'law') == []


def test_program_writes_all_of_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cases: list[Any] = [
        _answer('form', (MASS,), {MASS: 0.9}, law='plain'),
        _answer('pair', (MASS, BEND), {MASS: 0.9, BEND: 0.8}, law='fibres'),
        _answer('clean', (), {}, 'agree', law='plain'),
    ]
    (tmp_path / 'labels').mkdir()
    for number, case in enumerate(cases):
        label = {**case.label, 'id': f'form_{number}'}
        (tmp_path / 'labels' / f'form_{number}.json').write_text(json.dumps(label))
        folder = tmp_path / 'run' / f'form_{number}'
        folder.mkdir(parents=True)
        (folder / 'verdict.json').write_text(json.dumps(case.verdict))
    out = tmp_path / 'found.json'
    given = ['--verdicts', str(tmp_path / 'run'), '--labels', str(tmp_path / 'labels')]
    assert main([*given, '--out', str(out), '--salt', 'abc']) == 0
    found = json.loads(out.read_text())
    assert found['salt'] == 'abc'
    assert len(found['cases']) == 3
    assert set(found['groups']['law']) == {'fibres', 'plain'}
    printed = capsys.readouterr().out
    assert '| pairs: both named [%] | 100 (1) | 1 | 70 % | 90 % |' in printed
    assert '| 0.9 to 1.0 | 2 | 0.90 | 1.00 |' in printed
    assert 'Brier score' in printed
