# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Films of depth images: window, scale, pace."""

import cv2
from diffcal_ros.report.figures.film import film_frame, write_film, write_still
import numpy as np
from PIL import Image
import pytest

# What codec and palette change a picture by, in the mean of 255; white loses 4 of them.
CODED = 5.0


@pytest.fixture
def images():
    """A square that goes to the right and away."""
    found = []
    for k in range(3):
        image = np.full((60, 80), np.nan, dtype=np.float32)
        image[20:30, 10 + 15 * k : 20 + 15 * k] = 0.30 + 0.02 * k
        found.append(image)
    return found


def test_window_and_scale_hold_every_image(images):
    frame = film_frame(images)
    assert (frame.rows.start, frame.rows.stop) == (17, 33)
    assert (frame.columns.start, frame.columns.stop) == (7, 53)
    assert frame.limits == pytest.approx((297.0, 343.0), abs=0.01)


def test_the_window_stays_in_the_image(images):
    full = [np.ones((6, 8), dtype=np.float32)]
    frame = film_frame(full)
    assert (frame.rows, frame.columns) == (slice(0, 6), slice(0, 8))
    with pytest.raises(ValueError, match='no image of the film shows anything'):
        film_frame([np.full_like(images[0], np.nan)])


def test_a_film_has_every_image_at_its_pace(images, tmp_path):
    path = tmp_path / 'film.gif'
    write_film(path, lambda: images, [0.0, 0.04, 0.1], title='square', slowdown=5.0)
    film = Image.open(path)
    assert film.n_frames == 3
    pauses, pictures = [], []
    for number in range(3):
        film.seek(number)
        pauses.append(film.info['duration'])
        pictures.append(np.asarray(film.convert('RGB'), dtype=np.int64))
    assert pauses == [200, 300, 300]
    assert film.info['loop'] == 0
    _assert_moves_right(pictures)


def test_an_mp4_shows_what_the_gif_shows(images, tmp_path):
    for name in ('film.gif', 'film.mp4'):
        write_film(tmp_path / name, lambda: images, [0.0, 0.04, 0.08], title='a', slowdown=5.0)
    film = cv2.VideoCapture(str(tmp_path / 'film.mp4'))
    assert film.get(cv2.CAP_PROP_FPS) == pytest.approx(5.0)
    shown = [film.read()[1][..., ::-1].astype(np.int64) for _ in images]
    assert not film.read()[0]
    _assert_moves_right(shown)
    gif = Image.open(tmp_path / 'film.gif')
    for number, picture in enumerate(shown):
        gif.seek(number)
        wrong = np.abs(np.asarray(gif.convert('RGB'), dtype=np.int64) - picture)
        assert wrong.mean() < CODED


def test_a_film_of_uneven_times_or_unknown_kind_is_refused(images, tmp_path):
    with pytest.raises(ValueError, match='MP4 has one rate: write a GIF'):
        write_film(
            tmp_path / 'a.mp4', lambda: images, [0.0, 0.04, 0.1], title='square', slowdown=5.0
        )
    with pytest.raises(ValueError, match=r'a\.avi is no film: end it in one of gif, mp4'):
        write_film(tmp_path / 'a.avi', lambda: images, [0.0, 0.1, 0.2], title='', slowdown=1.0)


def _assert_moves_right(pictures):
    """The square is seen to move: its colour is on the left at first, on the right at last."""
    width = pictures[0].shape[1]
    colored = [np.ptp(p[60:-10, : int(0.8 * width)], axis=2) > 40 for p in pictures]
    middles = [float(np.nonzero(mask)[1].mean()) for mask in colored]
    assert middles[0] < middles[1] - 0.1 * width
    assert middles[1] < middles[2] - 0.1 * width


def test_a_still_is_a_png(images, tmp_path):
    write_still(tmp_path / 'depth.png', images[1], title='square')
    assert Image.open(tmp_path / 'depth.png').format == 'PNG'
