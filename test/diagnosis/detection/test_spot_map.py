# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A texture of a body's surface is found from pixels, whatever is smooth in each view."""

from diffcal_ros.diagnosis.detection.find_spots import _is_there
from diffcal_ros.diagnosis.detection.spot_map import (
    CELLS,
    left_beside,
    left_by_map,
    left_by_smooth,
    middle_of_two,
    nearer_the_second,
    spot_map,
    SpottedView,
    sum_left,
)
from diffcal_ros.effects.spots import cells_of, OF_SIDE, ROUND, ROWS
import numpy as np
import pytest

HEIGHT, NOISE = 0.004, 0.0006
_PIXELS = 20000


def _dots(random, *, edge=6, share=0.35):
    """Return a map of dots that are several cells wide, shape (CELLS,)."""
    coarse = random.random((ROWS // edge + 1, ROUND // edge)) < share
    return np.kron(coarse, np.ones((edge, edge), dtype=bool))[:ROWS].ravel()


def _view(random, read, *, offset, outliers=0.03):
    """Return pixels on two sides of a body that is off by something smooth.

    Args:
        random: draws places and noise.
        read: from places to what is read too far [m].
        offset: of a view [m], with more of it along the body and across.
        outliers: share of pixels that see something else.
    """
    along, aside = random.uniform(size=_PIXELS), random.uniform(-1.0, 1.0, size=_PIXELS)
    is_first = random.random(_PIXELS) < 0.6
    places = np.column_stack(
        [along, np.where(is_first, 1.0, aside), np.where(is_first, aside, 1.0)]
    )
    smooth = offset * (1.0 - 2.0 * along + 1.5 * along**2 + 0.7 * along * aside)
    left = read(places) + smooth + NOISE * random.normal(size=_PIXELS)
    is_other = random.random(_PIXELS) < outliers
    left[is_other] += random.uniform(0.005, 0.02, size=int(is_other.sum()))
    return SpottedView.of(left, places)


def _painted(spots, height=HEIGHT):
    return lambda places: height * spots[cells_of(places)]


OFFSETS = (0.003, -0.005, 0.001)


@pytest.mark.parametrize('height', [HEIGHT, -HEIGHT])
@pytest.mark.parametrize('share', [0.2, 0.5, 0.8])
def test_a_texture_is_found_but_for_which_level_is_which(random, height, share):
    spots = _dots(random, share=share)
    views = [_view(random, _painted(spots, height), offset=own) for own in OFFSETS]
    found = spot_map(views)
    alike = np.mean(found.is_spot[found.is_known] == spots[found.is_known])
    assert max(alike, 1.0 - alike) > 0.97
    assert abs(found.height) == pytest.approx(HEIGHT, rel=0.05)
    # One level too far and the other too near are the same.
    assert np.sign(found.height) == np.sign(height if alike > 0.5 else -height)
    assert _is_taken_for_spots(views, range(3))


def _is_taken_for_spots(views, postures):
    nothing = [np.zeros((len(view.left), 0)) for view in views]
    return _is_there(views, postures, nothing, spot_map(views))


def test_pixels_far_off_at_outlines_hide_no_texture(random):
    spots = _dots(random)
    views = [_view(random, _painted(spots), offset=own, outliers=0.15) for own in OFFSETS]
    found = spot_map(views)
    # They are a tenth of the pixels, and most of what is left.
    whole = sum_left(views, [np.zeros((len(view.left), 0)) for view in views])
    assert left_by_map(views, found.levels) > 0.5 * whole
    assert _is_taken_for_spots(views, range(3))


def test_parts_that_leave_as_little_are_no_spots(random):
    spots = np.arange(ROWS)[:, None] * np.ones((1, ROUND)) > 0.4 * ROWS
    views = [_view(random, _painted(spots.ravel()), offset=own) for own in OFFSETS]
    held = [view.on(spots.ravel().astype(float)) for view in views]
    assert not _is_there(views, range(3), held, spot_map(views))


def test_what_is_elsewhere_on_the_body_in_each_pose_is_no_texture_of_it(random):
    views = [_view(random, _painted(_dots(random)), offset=own) for own in OFFSETS]
    assert not _is_taken_for_spots(views, range(3))
    # Views of one pose do not tell: each of the two poses has a texture of its own.
    views = [v for own in views[:2] for v in (own, own)]
    assert not _is_taken_for_spots(views, [0, 0, 1, 1])


@pytest.mark.parametrize(
    'read',
    [
        pytest.param(lambda places: 0.0 * places[:, 0], id='nothing'),
        pytest.param(lambda places: HEIGHT * np.sin(40.0 * places[:, 0]), id='ribs'),
        pytest.param(lambda places: HEIGHT * places[:, 0] ** 3, id='a bend'),
        pytest.param(
            lambda places: HEIGHT * np.sin(25.0 * places[:, 0]) * np.sin(4.0 * places[:, 2]),
            id='bumps',
        ),
    ],
)
def test_what_is_smooth_or_not_there_is_no_texture(random, read):
    views = [_view(random, read, offset=own) for own in OFFSETS]
    assert not _is_taken_for_spots(views, range(3))


def test_a_camera_that_blurs_steps_a_little_sees_spots_still(random):
    spots = _dots(random, edge=8).reshape(ROWS, ROUND).astype(float)
    # By a third of a cell's neighbours, on each side.
    soft = 0.5 * spots + 0.25 * (np.roll(spots, 1, axis=1) + np.roll(spots, -1, axis=1))
    views = [_view(random, _painted(soft.ravel()), offset=own) for own in OFFSETS]
    assert _is_taken_for_spots(views, range(3))


def test_the_middle_of_two_parts_two_groups_as_all_thresholds_tried_do(random):
    values = np.concatenate([random.normal(-1.0, 0.3, 300), random.normal(2.0, 0.5, 100)])

    def within(threshold):
        parts = values[values <= threshold], values[values > threshold]
        return sum(len(part) * part.var() for part in parts)

    tried = np.linspace(values.min() + 0.01, values.max() - 0.01, 2000)
    best = tried[np.argmin([within(own) for own in tried])]
    assert within(middle_of_two(values)) <= within(best) + 1e-9


def test_sizes_are_found_beside_what_is_smooth_and_outliers(random):
    spots = _dots(random)
    view = _view(random, _painted(spots), offset=0.01, outliers=0.1)
    left, (height,) = left_beside(view, view.on(spots.astype(float)))
    assert height == pytest.approx(HEIGHT, rel=0.02)
    # Half of what is noise is off by less than two thirds of its size.
    assert np.median(np.abs(left)) < 0.8 * NOISE < 0.5 * np.median(np.abs(left_by_smooth(view)))


def test_cells_are_of_the_nearer_level(random):
    spots = _dots(random)
    views = [_view(random, _painted(spots, -HEIGHT), offset=0.0) for _ in OFFSETS]
    found = nearer_the_second(views, -HEIGHT)
    seen = np.bincount(np.concatenate([view.cells for view in views]), minlength=CELLS) > 3
    assert np.mean(found[seen] == spots[seen]) > 0.99
    # Two sides are not seen; those of the other two that no pixel sees are as the nearest.
    assert not found.reshape(ROWS, ROUND)[:, 2 * OF_SIDE + 2 : -2].any()
    hidden = views[0].where(views[0].cells % 2 == 0)
    halved = nearer_the_second([hidden], -HEIGHT)
    odd = np.arange(CELLS) % 2 == 1
    assert np.mean(halved[odd & seen] == spots[odd & seen]) > 0.85


def test_beside_something_large_and_smooth_a_map_by_levels_alone_leaves_more(random):
    spots = _dots(random)
    offsets = (0.02, -0.03, 0.01)
    views = [_view(random, _painted(spots), offset=own, outliers=0.0) for own in offsets]
    by_levels = nearer_the_second(views, HEIGHT).astype(float)
    assert np.mean(by_levels == spots) < 0.8
    assert left_by_map(views, spots.astype(float)) < 0.5 * left_by_map(views, by_levels)
