# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Lines while something takes long, and none otherwise."""

from threading import Event, Thread

from diffcal_ros.cli import solve_progress as module
from diffcal_ros.cli.solve_progress import solve_progress
from diffcal_ros.fem import activity
from diffcal_ros.fem.activity import busy_with, during
import pytest
from support.bodies import GRAVITY, hanging_beam, uniform_material

MANY = 1_000_000


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> tuple[list[str], Event]:
    """What is said, and an event when something was."""
    lines: list[str] = []
    was_said = Event()

    def say(text: str) -> None:
        lines.append(text)
        was_said.set()

    monkeypatch.setattr(module, 'say', say)
    return lines, was_said


def test_long_work_is_told_while_it_runs(said) -> None:
    lines, was_said = said
    with solve_progress(0.01), during('equilibrium of many unknowns', MANY):
        assert was_said.wait(60.0)
    assert lines[0] == 'equilibrium of many unknowns: 0 s so far'


def test_nothing_is_told_where_nothing_runs(said) -> None:
    lines, was_said = said
    with during('what has ended', MANY):
        pass
    with solve_progress(0.01):
        assert not was_said.wait(0.3)
    assert lines == []


def test_the_innermost_work_of_the_longest_busy_thread_is_told() -> None:
    is_inside, may_end = Event(), Event()

    def other() -> None:
        with during('later work', MANY):
            is_inside.set()
            may_end.wait(60.0)

    with during('outer', MANY), during('inner', MANY):
        thread = Thread(target=other)
        thread.start()
        assert is_inside.wait(60.0)
        running = busy_with()
        assert running is not None
        assert running[0] == 'inner'
    running = busy_with()
    assert running is not None
    assert running[0] == 'later work'
    may_end.set()
    thread.join()
    assert busy_with() is None


def test_short_work_is_passed_over_for_the_long_work_around_it(monkeypatch) -> None:
    now = [100.0]
    monkeypatch.setattr(activity.time, 'monotonic', lambda: now[0])
    with during('a fit', MANY):
        now[0] += 5.0
        with during('an equilibrium', MANY):
            now[0] += 1.0
            assert busy_with() == ('an equilibrium', 1.0)
            assert busy_with(2.0) == ('a fit', 6.0)
            now[0] += 2.0
            assert busy_with(2.0) == ('an equilibrium', 3.0)
        assert busy_with(9.0) is None


def test_a_failure_ends_what_is_told() -> None:
    with pytest.raises(ValueError, match='broken'), during('work', MANY):
        raise ValueError('broken')
    assert busy_with() is None


@pytest.mark.parametrize('is_large', [True, False])
def test_a_large_body_alone_tells_what_it_does(is_large, monkeypatch) -> None:
    body = hanging_beam()
    monkeypatch.setattr(
        activity, '_TOLD_FROM', body.solver.stiffness.pattern.size + (not is_large)
    )
    told = []
    forces = body.solver.stiffness.forces

    def asked(positions):
        told.append(busy_with())
        return forces(positions)

    monkeypatch.setattr(body.solver.stiffness, 'forces', asked)
    body.solve_equilibrium(uniform_material(body.mesh), GRAVITY)
    works = {running[0] for running in told if running is not None}
    assert works == (
        {f'equilibrium of {body.solver.stiffness.pattern.size:,} unknowns'} if is_large else set()
    )
    assert busy_with() is None
