# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Several bodies at once: the same results in the same order, and the first error."""

from threading import Barrier, get_ident

from diffcal_ros.calibration.forward.side_by_side import core_count, side_by_side
import pytest


@pytest.mark.parametrize('threads', ['1', '3'])
def test_results_go_by_key_in_the_order_given(monkeypatch, threads) -> None:
    monkeypatch.setenv('OMP_NUM_THREADS', threads)
    found = side_by_side(lambda key: key * key, (5, 3, 4), 'cpu')
    assert list(found.items()) == [(5, 25), (3, 9), (4, 16)]


def test_they_run_at_the_same_time_on_cores_and_in_turn_on_a_gpu(monkeypatch) -> None:
    monkeypatch.setenv('OMP_NUM_THREADS', '2')
    meeting = Barrier(2)  # Neither gets past it alone.
    side_by_side(lambda _: meeting.wait(timeout=10.0), (0, 1), 'cpu')
    assert set(side_by_side(lambda _: get_ident(), (0, 1), 'cuda:0').values()) == {get_ident()}


def test_the_first_error_by_the_order_of_keys_is_raised_when_all_have_ended(monkeypatch) -> None:
    monkeypatch.setenv('OMP_NUM_THREADS', '3')
    ended = []

    def work(key: int) -> None:
        ended.append(key)
        if key != 1:
            raise ValueError(f'body {key}')

    with pytest.raises(ValueError, match='body 0'):
        side_by_side(work, (0, 1, 2), 'cpu')
    assert sorted(ended) == [0, 1, 2]


@pytest.mark.parametrize(('given', 'least'), [('2', 2), ('', 1), ('many', 1), ('0', 1)])
def test_cores_are_counted_where_nothing_sensible_is_said(monkeypatch, given, least) -> None:
    monkeypatch.setenv('OMP_NUM_THREADS', given)
    assert core_count() >= least
