# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The scorer on answers whose score is known."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.blind.answers import Answer
from benchmarks.blind.conventions import true_components
from benchmarks.blind.form_table import row
from benchmarks.blind.rotations import rotation
from benchmarks.blind.scorer import confusion, failures, main, score

MASS = {'identifier': 'added_mass', 'amplitude': {'mass': 4.0, 'at': 0.7}, 'unit': 'g'}
TILT = {'identifier': 'gravity_tilt', 'amplitude': {'x': 3.0, 'z': -4.0}, 'unit': 'deg'}
CLAMP = {
    'identifier': 'clamp_offset',
    'amplitude': {
        **{f'shift_{axis}': value for axis, value in zip('xyz', (0.0, 3.0, 4.0), strict=True)},
        **{f'turn_{axis}': value for axis, value in zip('xyz', (0.0, 0.0, 2.0), strict=True)},
    },
    'unit': 'mm, deg',
}


def _label(kind: str, *effects: dict[str, Any], outside: str | None = None) -> dict[str, Any]:
    return {
        'id': kind,
        'kind': kind,
        'poses': ['level'],
        'family': 'beam',
        'sizes': [0] * len(effects),
        'effects': list(effects),
        'outside_class': outside,
        'parameters': {'youngs_modulus': 1.0e5},
    }


def _verdict(verdict: str = 'disagree', *named: tuple[str, Any, Any], **more: Any) -> dict:
    effects = [
        {
            'identifier': name,
            'amplitude': amplitude,
            'std_error': spread,
            'confidence': 0.9,
            'frame': {'a': [1.0, 0.0, 0.0], 'b': [0.0, 0.0, 1.0]},
        }
        for name, amplitude, spread in named
    ]
    return {'verdict': verdict, 'effects': effects, 'ambiguity_set': [], **more}


def _value(answers: list[Answer], metric: str) -> float:
    return next(row['value'] for row in score(answers) if row['metric'].startswith(metric))


def test_a_row_of_another_form_says_what_was_said_and_how_right_it_is() -> None:
    truth = {**MASS, 'amplitude': {'mass': 4.0, 'form': 'ring'}}
    label = {**_label('form', truth), 'sensor': 'itof'}
    more = {'gap_mm': {'nominal': 0.9, 'added': 0.2}, 'seconds': 20.0}
    right = row(Answer(label, _verdict('disagree', ('added_mass', {'mass': 4.1}, {}), **more)))
    assert right['truth'] == [['added_mass', 'ring']]
    assert right['said'] == [['added_mass', 0.9]]
    assert right['outcome'] == 'right'
    wrong = row(Answer(label, _verdict('disagree', ('gravity_tilt', {}, {}), **more)))
    assert wrong['outcome'] == 'wrong'
    near = {**_verdict('below_margin', **more), 'ambiguity_set': ['added_mass']}
    assert row(Answer(label, near))['outcome'] == 'in the set'


def test_false_alarms_are_counted_among_clean_cases_alone() -> None:
    answers = [
        Answer(_label('clean'), _verdict('agree')),
        Answer(_label('clean'), _verdict('cannot_tell')),
        Answer(
            _label('clean'), _verdict('disagree', ('added_mass', {'mass': 1.0}, {'mass': 0.1}))
        ),
        Answer(_label('clean'), _verdict('below_margin')),
        Answer(
            _label('single', MASS),
            _verdict('disagree', ('added_mass', {'mass': 4.0}, {'mass': 0.1})),
        ),
    ]
    assert _value(answers, 'false alarms') == 25.0
    assert len(failures(answers)) == 1
    matrix = confusion(answers)
    assert matrix['clean'] == {'agree': 1, 'abstain': 2, 'added_mass': 1}
    assert matrix['added_mass'] == {'added_mass': 1}


def test_name_with_an_alternative_is_no_name_but_in_the_set() -> None:
    verdict = _verdict('disagree', ('added_mass', {'mass': 4.0}, {'mass': 0.1}))
    verdict['ambiguity_set'] = ['added_mass', 'gravity_tilt']
    answer = Answer(_label('single', TILT), verdict)
    assert answer.column == 'abstain'
    assert not answer.is_confidently_wrong
    assert _value([answer], 'truth in the reported set, all') == 100.0
    assert _value([answer], 'right name') == 0.0


def test_two_effects_that_are_both_named_are_no_alternatives() -> None:
    verdict = _verdict(
        'disagree',
        ('added_mass', {'mass': 4.0}, {'mass': 0.1}),
        ('gravity_tilt', {'a': 1.0, 'b': 0.0}, {'a': 0.1, 'b': 0.1}),
    )
    verdict['ambiguity_set'] = ['added_mass', 'gravity_tilt']
    answer = Answer(_label('pair', MASS, TILT), verdict)
    assert answer.is_right
    assert _value([answer], 'both of two named') == 100.0
    assert Answer(_label('single', TILT), verdict).is_confidently_wrong


def test_wrong_name_counts_as_confident_only_when_it_is() -> None:
    sure = Answer(
        _label('single', TILT), _verdict('disagree', ('added_mass', {'mass': 4.0}, {'mass': 0.1}))
    )
    unsure = _verdict('disagree', ('added_mass', {'mass': 4.0}, {'mass': 0.1}))
    unsure['effects'][0]['confidence'] = 0.4
    answers = [sure, Answer(_label('single', TILT), unsure)]
    assert _value(answers, 'confident wrong name') == 50.0


def test_cases_that_are_small_or_have_a_twin_are_not_asked_for_a_name() -> None:
    wrong = ('clamp_offset', {'x': 1.0}, {'x': 1.0})
    answers = [
        Answer(
            _label('single', TILT),
            _verdict('disagree', ('gravity_tilt', {'a': 3.0, 'b': -4.0}, {})),
        ),
        Answer(
            _label('single', TILT),
            _verdict('disagree', wrong, times_detectable={'gravity_tilt': 2.0}),
        ),
        Answer(
            _label('single', TILT),
            _verdict('disagree', wrong, largest_cosine={'gravity_tilt': 0.97}),
        ),
    ]
    assert _value(answers, 'right name') == 100.0
    assert len(failures(answers)) == 2


def test_effects_that_can_be_seen_are_counted_by_themselves() -> None:
    right = ('gravity_tilt', {'a': 3.0, 'b': -4.0}, {})
    label = _label('single', TILT)
    answers = [
        Answer(label, _verdict('disagree', right, times_detectable={'gravity_tilt': 1.5})),
        Answer(label, _verdict('agree', times_detectable={'gravity_tilt': 0.9})),
        Answer(label, _verdict('agree', times_detectable={'gravity_tilt': 1.1})),
        # Where a verdict does not say, nobody knows.
        Answer(label, _verdict('agree')),
    ]
    assert _value(answers, 'truth in the reported set, all') == 25.0
    assert _value(answers, 'the same, of single effects that can be seen') == 50.0


def test_outside_effects_must_be_unknown_and_of_their_class() -> None:
    label = _label('outside', {'identifier': 'side_wind', 'amplitude': {}}, outside='load')
    answers = [
        Answer(label, _verdict('disagree', unknown_class='load')),
        Answer(label, _verdict('disagree', unknown_class='shape')),
        Answer(label, _verdict('disagree', ('gravity_tilt', {'a': 1.0}, {'a': 0.1}))),
        Answer(label, _verdict('agree', unknown_class='load')),
    ]
    assert _value(answers, 'outside called unknown') == 50.0
    assert _value(answers, 'class of the unknown') == 50.0
    small = Answer(label, _verdict('below_margin', unknown_class='load'))
    assert _value([*answers, small], 'outside called unknown') == 40.0
    assert _value([*answers, small], 'the same, told below the margin too') == 60.0


@pytest.mark.parametrize(
    ('effect', 'amplitude', 'spread', 'error', 'covered'),
    [
        (MASS, {'mass': 4.4}, {'mass': 0.3}, 0.1, [True]),
        (MASS, {'mass': 4.4}, {'mass': 0.1}, 0.1, [False]),
        (TILT, {'a': 3.0, 'b': -3.5}, {'a': 0.1, 'b': 0.1}, 0.1, [True, False]),
        (CLAMP, {'y': 3.0, 'z': 3.0, 'rz': 2.0}, {}, 0.1, []),
        (CLAMP, {'y': 3.0, 'z': 4.0}, {'y': 0.1, 'z': 0.1}, 0.5, [True] * 5 + [False]),
    ],
)
def test_amplitudes_are_compared_by_vector(
    effect: dict, amplitude: dict, spread: dict, error: float, covered: list[bool]
) -> None:
    verdict = _verdict('disagree', (effect['identifier'], amplitude, spread))
    found = Answer(_label('single', effect), verdict).amplitude_score()
    assert found is not None
    assert found[0] == pytest.approx(error)
    assert found[1] == covered


def test_bends_are_read_along_the_axes_of_the_verdict() -> None:
    bend = {'identifier': 'rest_curvature', 'amplitude': {'y': 0.3, 'z': -0.1}, 'unit': '1/m'}
    verdict = _verdict('disagree', ('rest_curvature', {'a': -0.1, 'b': -0.3}, {'a': 1, 'b': 1}))
    verdict['effects'][0]['frame'] = {'a': [0.0, 0.0, 1.0], 'b': [0.0, -1.0, 0.0]}
    found = Answer(_label('single', bend), verdict).amplitude_score()
    assert found is not None
    assert found[0] == pytest.approx(0.0)


def test_camera_that_moves_sees_the_body_move_back() -> None:
    """Both motions take any point of the body to the same place."""
    center, about = np.array([0.01, -0.02, 0.3]), np.array([-0.03, 0.0, 0.35])
    names = [f'{kind}_{axis}' for kind in ('shift', 'turn') for axis in 'xyz']
    amplitude = dict(zip(names, (2.0, -5.0, 3.0, 1.0, -4.0, 2.0), strict=True))
    offset = {'identifier': 'camera_offset', 'amplitude': amplitude}
    label = {**_label('single', offset), 'camera_center': center.tolist()}
    said = true_components(label, {'frame': {'about': about.tolist()}})
    point = np.array([0.05, 0.03, 0.32])
    turn = rotation(np.deg2rad([1.0, -4.0, 2.0]))
    by_camera = turn.T @ (point - center - 1e-3 * np.array([2.0, -5.0, 3.0])) + center
    back = rotation(np.deg2rad([said[name] for name in ('rx', 'ry', 'rz')]))
    shift = 1e-3 * np.array([said[name] for name in 'xyz'])
    np.testing.assert_allclose(back @ (point - about) + about + shift, by_camera, atol=1e-12)


def test_modulus_heals() -> None:
    parameters = {'before': {'youngs_modulus': 8.0e4}, 'after': {'youngs_modulus': 1.02e5}}
    verdict = _verdict(
        'disagree',
        ('added_mass', {'mass': 4.0}, {'mass': 0.1}),
        parameters=parameters,
        closure=0.9,
    )
    answers = [Answer(_label('single', MASS), verdict)]
    assert _value(answers, 'error of E, added over nominal') == pytest.approx(0.1)
    assert _value(answers, 'held-out closure, median') == pytest.approx(90.0)


def test_program_writes_table_and_refuses_changed_labels(tmp_path: Path) -> None:
    labels, verdicts = tmp_path / 'labels', tmp_path / 'verdicts' / 'one'
    labels.mkdir()
    verdicts.mkdir(parents=True)
    (labels / 'one.json').write_text(json.dumps(_label('single', MASS)))
    (verdicts / 'verdict.json').write_text(
        json.dumps(_verdict('disagree', ('added_mass', {'mass': 4.0}, {'mass': 0.1})))
    )
    given = ['--verdicts', str(verdicts.parent), '--labels', str(labels)]
    assert main([*given, '--out', str(tmp_path / 'out')]) == 0
    assert '| added_mass | ' in (tmp_path / 'out' / 'score.md').read_text()
    assert json.loads((tmp_path / 'out' / 'score.json').read_text())['missing'] == []
    (tmp_path / 'seal').write_text(f'{"0" * 64}  one.json\n')
    assert main([*given, '--out', str(tmp_path / 'out'), '--seal', str(tmp_path / 'seal')]) == 2
