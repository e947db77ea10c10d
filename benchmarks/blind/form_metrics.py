# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What answers about effects in other forms are worth, all together."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.blind.answers import Answer
from benchmarks.blind.metric_rows import median, row, share
from benchmarks.blind.outcomes import (
    is_of_class,
    may_be_of_class,
    outcome,
    said_names,
    wrong_names,
)

_CLEAR = 3.0  # Times the smallest amplitude that can be detected.
_BINS = (0.0, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)


def form_metrics(answers: Sequence[Answer]) -> list[dict[str, Any]]:
    """Return the rows of the table: name, value, count, and what ships and is reached for."""
    clean, single, pair, outside = (
        [answer for answer in answers if answer.label['kind'] == kind]
        for kind in ('clean', 'form', 'pair', 'outside')
    )
    faulty = [*single, *pair, *outside]
    seen = [answer for answer in single if answer.is_alarm]
    clear = [answer for answer in single if (answer.times_detectable() or 0.0) >= _CLEAR]
    gaps = [answer for answer in outside if answer.is_alarm]
    unknown = [answer for answer in outside if answer.is_told_unknown]
    return [
        share('false alarms on clean worlds', clean, lambda a: a.is_alarm, '<= 1 %', '0'),
        share('a wrong name', faulty, _has_wrong_name, '<= 3 %', '0.5 %'),
        share('truth in the set', single, _holds_truth, '', ''),
        share('the same, at 3 x detectable', clear, _holds_truth, '95 %', '99 %'),
        share('the same, of those that disagree', seen, _holds_truth, '', ''),
        share('truth or its class in the answer, of those', seen, _holds_class, '', ''),
        share('right single name', single, _is_right, '', ''),
        share('the same, at 3 x detectable', clear, _is_right, '80 %', '95 %'),
        share('the same, of those that disagree', seen, _is_right, '', ''),
        share('spurious second names', [*single, *pair], _has_another, '<= 2 %', '0'),
        share('outside: unknown or class', outside, lambda a: a.is_told_unknown, '80 %', '95 %'),
        share('the same, of those that disagree', gaps, lambda a: a.is_unknown, '', ''),
        share('class of the unknown right', unknown, is_of_class, '', ''),
        share('the same, of one or two classes', unknown, may_be_of_class, '', ''),
        share('pairs: both named', pair, _names_all, '70 %', '90 %'),
        share('pairs: one named, and no other', pair, _names_one, '', ''),
        _healing(single),
        median('time [s]', [float(a.verdict['seconds']) for a in answers], '20', '8'),
    ]


def _healing(single: Sequence[Answer]) -> dict[str, Any]:
    found = [e for a in single if _is_right(a) and (e := a.modulus_errors()) is not None]
    before, after = (float(np.median([e[i] for e in found] or [np.nan])) for i in range(2))
    return row('error of E, after over before', after / before, len(found), '1/5', '1/20')


def reliability(answers: Sequence[Answer]) -> list[dict[str, Any]]:
    """Return how often names are right, by bins of the confidence that they are given with.

    Every name counts, of clean worlds too; empty bins are left out. A bin holds its lower end,
    the last one both.
    """
    names = _confidences(answers)
    rows = []
    for low, high in pairwise(_BINS):
        inside = [
            (said, right)
            for said, right in names
            if low <= said and (said < high or high == _BINS[-1])
        ]
        if inside:
            said, right = np.mean(inside, axis=0)
            rows.append(
                {
                    'from': low,
                    'to': high,
                    'names': len(inside),
                    'said': float(said),
                    'right': float(right),
                }
            )
    return rows


def brier_score(answers: Sequence[Answer]) -> tuple[float, int]:
    """Return the mean square of confidence less truth over all names, and their number."""
    squares = [(said - right) ** 2 for said, right in _confidences(answers)]
    return (float(np.mean(squares)) if squares else float('nan')), len(squares)


def _confidences(answers: Sequence[Answer]) -> list[tuple[float, bool]]:
    """Return the confidence of every name, and whether it is right."""
    return [
        (float(effect['confidence']), effect['identifier'] in answer.truth)
        for answer in answers
        for effect in answer.verdict.get('effects') or ()
    ]


def law_of(answer: Answer) -> str | None:
    """Return the law of a case's body, where its set has several."""
    rubber = answer.label.get('rubber')
    return None if rubber is None else str(rubber['law'])


def grouped(answers: Sequence[Answer], by: str) -> list[tuple[str, list[dict[str, Any]]]]:
    """Return the metrics that are counts, for each sensor or each law.

    Args:
        answers: of all.
        by: `sensor` or `law`.
    """
    groups: dict[str, list[Answer]] = {}
    for answer in answers:
        name = law_of(answer) if by == 'law' else answer.label[by]
        if name is not None:
            groups.setdefault(name, []).append(answer)
    return [
        (name, [one for one in form_metrics(group) if 'hits' in one])
        for name, group in sorted(groups.items())
    ]


def _has_wrong_name(answer: Answer) -> bool:
    return bool(wrong_names(answer))


def _has_another(answer: Answer) -> bool:
    """Tell whether a name that is not there is given beside one that is."""
    return bool(wrong_names(answer)) and bool(said_names(answer) & set(answer.truth))


def _is_right(answer: Answer) -> bool:
    return outcome(answer) == 'right'


def _names_all(answer: Answer) -> bool:
    return set(answer.truth) <= said_names(answer)


def _names_one(answer: Answer) -> bool:
    return outcome(answer) == 'one of two'


def _holds_truth(answer: Answer) -> bool:
    return set(answer.truth) <= answer.reported


def _holds_class(answer: Answer) -> bool:
    """Tell whether the truth is in the set, or what is missing is called unknown of its class."""
    return _holds_truth(answer) or is_of_class(answer)
