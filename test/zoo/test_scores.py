# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How answers are judged."""

from types import SimpleNamespace

from diffcal_ros.errors import InputError
import numpy as np
import pytest

from benchmarks.coverage import figures
from benchmarks.zoo import fits
from benchmarks.zoo.summary import summarise


def _result(outcome: str, value: float, std_error: float, others=()):
    reach = 1.96 * std_error
    modulus = SimpleNamespace(
        value=value,
        std_error=std_error,
        fine_value=value,
        interval_95=(value - reach, value + reach),
    )

    class Result(dict):
        pass

    result = Result(youngs_modulus=modulus)
    result.outcome = SimpleNamespace(value=outcome)
    result.gap_end = SimpleNamespace(median=1e-3, coverage=0.9)
    result.iterations = 5
    result.alternatives = tuple(others)
    return result


@pytest.mark.parametrize(
    ('outcome', 'value', 'std_error', 'expected'),
    [
        ('converged', 110.0, 6.0, 'right'),
        ('converged', 102.0, 0.1, 'right'),
        ('converged', 110.0, 1.0, 'wrong'),
        ('model_disagrees', 110.0, 6.0, 'refused'),
    ],
)
def test_verdicts(monkeypatch, outcome, value, std_error, expected) -> None:
    monkeypatch.setattr(fits, 'calibrate', lambda *_: _result(outcome, value, std_error))
    assert fits.verdict(fits.fit(None, None, 100.0, None)) == expected


def test_alternatives_are_read_whichever_way_they_are_told(monkeypatch) -> None:
    others = [
        SimpleNamespace(values={'youngs_modulus': 50.0}),
        SimpleNamespace(values=lambda: {'youngs_modulus': 101.0}),
        {'youngs_modulus': SimpleNamespace(value=20.0)},
        object(),
    ]
    monkeypatch.setattr(fits, 'calibrate', lambda *_: _result('ambiguous', 200.0, 1.0, others))
    answer = fits.fit(None, None, 100.0, None)
    assert answer['alternatives'] == [50.0, 101.0, 20.0]
    assert answer['has_truth']


def test_errors_are_refusals_but_crashes_are_not(monkeypatch) -> None:
    for error, expected in ((InputError('no'), 'refused'), (KeyError('x'), 'crashed')):

        def fail(*_, error=error):
            raise error

        monkeypatch.setattr(fits, 'calibrate', fail)
        assert fits.verdict(fits.fit(None, None, 100.0, None)) == expected


def test_the_summary_counts_what_a_person_could_tell() -> None:
    far = {'outcome': 'converged', 'has_truth': True, 'seconds': 1.0}
    cases = [
        {'body': 'beam', 'verdict': verdict, 'is_tellable': told, 'far': far, 'near': {}}
        for verdict, told in (('right', True), ('wrong', True), ('refused', False))
    ]
    row = summarise(cases)['beam']
    assert (row['n'], row['right'], row['wrong'], row['refused']) == (3, 1, 1, 1)
    assert (row['tellable'], row['right of those'], row['wrong of those']) == (2, 1, 1)


def test_coverage_of_honest_errors_is_near_95_percent() -> None:
    z = np.random.default_rng(0).standard_normal(2000)
    rows = [
        {
            'outcome': 'converged',
            'z': float(own),
            'is_covered': abs(float(own)) <= 1.96,
            'value': 1.0,
            'fine_value': 1.0,
            'youngs_modulus': 1.0,
            'std_error': 0.1,
            'mesh_error': 0.05,
            'error': 0.1 * float(own),
            'seconds': 1.0,
        }
        for own in z
    ]
    row = figures(rows)
    low, high = row['coverage_95']
    assert low < 0.95 < high
    assert row['z_std'] == pytest.approx(1.0, abs=0.05)
