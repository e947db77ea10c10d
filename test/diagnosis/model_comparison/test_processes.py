# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is set aside while models are refitted is there again afterwards, no less than before."""

import gc
import weakref

from diffcal_ros.diagnosis.model_comparison.processes import all_set_aside
import pytest


@pytest.fixture(autouse=True)
def _nothing_set_aside():
    """Begin as a program does: the tests themselves are set aside by whoever runs them."""
    gc.unfreeze()
    yield
    gc.freeze()


class _Ring:
    """Something that only the collector frees."""

    def __init__(self) -> None:
        self.itself = self


def test_what_was_there_is_set_aside_and_what_comes_later_is_collected():
    before = gc.get_freeze_count()
    with all_set_aside():
        assert gc.get_freeze_count() > before
        later = weakref.ref(_Ring())
        gc.collect()
        assert later() is None
    assert gc.get_freeze_count() == before


def _fail_with(rings):
    """Let go of rings while all is set aside, and fail."""
    with all_set_aside():
        rings.clear()
        gc.collect()
        raise ZeroDivisionError


def test_garbage_that_was_set_aside_is_collected_afterwards_whatever_happened():
    gc.collect()
    rings = [_Ring()]
    seen = weakref.ref(rings[0])
    with pytest.raises(ZeroDivisionError):
        _fail_with(rings)
    assert seen() is not None
    gc.collect()
    assert seen() is None


def test_what_a_caller_has_set_aside_stays_there():
    gc.freeze()
    try:
        # What another thread lets go of is none of it any more.
        most = 0.9 * gc.get_freeze_count()
        with all_set_aside():
            assert gc.get_freeze_count() > most > 0.0
        assert gc.get_freeze_count() > most
    finally:
        gc.unfreeze()
