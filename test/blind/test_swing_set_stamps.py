# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of late stamps of the set `swings` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.shutter import averaged, filmed_views, rolled
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.stamping import moments, stamps
from benchmarks.blind.timing import draw_swing, Timing

PERIOD = 1.0 / 30.0


def _timing() -> Timing:
    return draw_swing(np.random.default_rng(1))


@pytest.mark.parametrize('phase', range(5))
def test_a_queue_grows_frame_by_frame_until_one_is_dropped(phase: int) -> None:
    timing = _timing()
    faults = Faults(stamps_form='backlog', stamps_late=6.0, stamps_phase=phase)
    taken, when = np.array(moments(timing, faults)), 1e-9 * np.array(stamps(timing, faults))
    gaps = np.diff(taken) / PERIOD
    np.testing.assert_allclose(gaps, np.round(gaps), atol=1e-6)
    assert set(np.round(gaps)) == {1.0, 2.0}
    # A stamp is when a frame was taken and how long it waited, by the clock of the release.
    waits = when - taken - timing.release
    dropped = np.diff(waits) < 0.0
    assert np.array_equal(dropped, gaps > 1.5)
    np.testing.assert_allclose(np.diff(waits)[~dropped], 0.006 * 1.2 / 4.0, atol=1e-7)
    assert waits.min() == pytest.approx(0.4 * 0.006, abs=1e-7)
    assert waits.max() == pytest.approx(1.6 * 0.006, abs=1e-7)
    assert (np.diff(when) > 0.0).all()


def test_jitter_comes_on_top_of_a_queue() -> None:
    faults = Faults(stamps_form='backlog', stamps_late=6.0, stamps_phase=2)
    off = tuple(np.linspace(0.0, 4e-4, 17))
    timing = _timing()
    jittered = stamps(replace(timing, jitter=off), faults)
    more = 1e-9 * (np.array(jittered) - stamps(timing, faults))
    # The fourth frame and every sixth from there on are dropped.
    left = [number for number in range(17) if number % 6 != 3]
    np.testing.assert_allclose(more, np.array(off)[left], atol=2e-9)


def test_each_node_is_seen_when_its_row_is_read(setup: Setup, plain: Specimen) -> None:
    """Nodes that move evenly through the room: row and moment by a fixed point of each alone."""
    observation = setup.observations[0]
    velocity = np.array([0.02, -0.05, 0.9])
    half, nodes = 0.012, plain.mesh.nodes
    times = np.linspace(-half, half, 9)
    places = nodes + times[:, None, None] * velocity
    seen = rolled(places, setup, observation)
    to_camera = setup.depth_from_world @ observation.world_from_object
    when = (seen - nodes) @ velocity / (velocity @ velocity)
    np.testing.assert_allclose(seen, nodes + when[:, None] * velocity, atol=1e-12)
    rows = setup.camera.project(applied(to_camera, seen))[:, 1]
    np.testing.assert_allclose(
        when, half * (2.0 * rows / (setup.camera.height - 1.0) - 1.0), atol=1e-7
    )
    assert np.ptp(when) > 0.15 * half


def _tossed(setup: Setup, plain: Specimen, times: np.ndarray) -> list[np.ndarray]:
    """Return a body that falls and turns a little, at times [s]."""
    nodes = plain.mesh.nodes
    falls = np.array([0.0, 0.1, -0.5])
    return [nodes + t * falls + t * 3.0 * nodes[:, :1] * np.array([0.0, 0.0, -1.0]) for t in times]


def test_a_rolling_image_has_each_row_of_the_moment_at_which_it_was_read(
    setup: Setup, plain: Specimen
) -> None:
    observation, half = setup.observations[0], 0.012
    places = np.array(_tossed(setup, plain, np.linspace(-half, half, 9)))
    seen = rolled(places, setup, observation)
    view = true_rendering(plain, setup, observation, Faults(), seen)
    middle = view.row + view.depth.shape[0] // 2
    errors, wrong = [], []
    for row in range(middle - 20, middle + 21, 8):
        when = half * (2.0 * row / (setup.camera.height - 1.0) - 1.0)
        (place,) = _tossed(setup, plain, np.array([when]))
        still = true_rendering(plain, setup, observation, Faults(), place)
        (standing,) = _tossed(setup, plain, np.zeros(1))
        late = true_rendering(plain, setup, observation, Faults(), standing)
        for found, other in ((errors, still), (wrong, late)):
            one, two = _row(view, row), _row(other, row)
            both = np.isfinite(one) & np.isfinite(two)
            assert both.sum() > 50
            found.append(np.abs(one[both] - two[both]).mean())
    assert max(errors) < 2e-5
    assert max(wrong) > 2e-4


def _row(view: Rendering, row: int) -> np.ndarray:
    """Return a row of the whole image, from the samples in the middle of its pixels."""
    whole = np.full(640, np.inf)
    part = view.depth[row - view.row, :, 4]
    whole[view.column : view.column + len(part)] = part
    return whole


def test_an_exposure_is_the_mean_of_what_most_of_its_moments_see() -> None:
    random = np.random.default_rng(2)
    views = []
    for row, column in ((3, 5), (4, 4), (2, 6), (3, 3)):
        depth = random.uniform(0.2, 0.4, (6, 7, 9))
        depth[random.random(depth.shape) < 0.3] = np.inf
        views.append(
            Rendering(column, row, depth, np.zeros(depth.shape, int), np.ones(depth.shape))
        )
    mean, count = averaged(views), 0
    for row in range(12):
        for column in range(14):
            for sample in range(9):
                there = [_sample(view, row, column, sample) for view in views]
                hits = [value for value in there if np.isfinite(value)]
                expected = np.mean(hits) if len(hits) > 2 else np.inf
                assert _sample(mean, row, column, sample) == pytest.approx(expected)
                count += len(hits) > 2
    assert count > 50
    assert averaged(views[:1]) is views[0]


def _sample(view: Rendering, row: int, column: int, sample: int) -> float:
    down, across = row - view.row, column - view.column
    height, width = view.depth.shape[:2]
    is_inside = 0 <= down < height and 0 <= across < width
    return float(view.depth[down, across, sample]) if is_inside else np.inf


@pytest.mark.slow
@pytest.mark.parametrize('late', [6.0, -6.0])
def test_frames_that_take_their_time_are_late_by_half_of_it(setup: Setup, late: float) -> None:
    """A short exposure is an image of its middle; before the release all is as it lies."""
    fast = replace(setup, youngs_modulus=6.0e5)
    plain = make_specimen(fast, Faults(), refinement=0.5)
    timing = replace(_timing(), frame_count=8)
    one, observation = Faults(stamps_late=late), fast.observations[0]
    instant = filmed_views(plain, fast, observation, one, timing)
    for form in ('exposed', 'rolling'):
        faults = replace(one, stamps_form=form)
        np.testing.assert_allclose(moments(timing, faults), moments(timing, one))
        views = filmed_views(plain, fast, observation, faults, timing)
        still, moved = (
            _difference(views[number], instant[number]) for number in (0, len(views) - 1)
        )
        assert still < 1e-9
        assert 1e-5 < moved < 1e-3
        # And far nearer to that than to what is there at the stamp.
        stamped = filmed_views(plain, fast, observation, Faults(), timing)
        assert moved < 0.35 * _difference(views[-1], stamped[-1])


def _difference(one: Rendering, two: Rendering) -> float:
    """Return the mean difference of depth where both see something [m]."""
    whole = []
    for view in (one, two):
        image = np.full((480, 640, 9), np.inf)
        height, width = view.depth.shape[:2]
        image[view.row : view.row + height, view.column : view.column + width] = view.depth
        whole.append(image)
    both = np.isfinite(whole[0]) & np.isfinite(whole[1])
    return float(np.abs(whole[0][both] - whole[1][both]).mean())
