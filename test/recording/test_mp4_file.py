# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""MP4 files, decoded again."""

import os
import subprocess
import sys

import cv2
from diffcal_ros.errors import InputError
from diffcal_ros.recording.mp4_file import check_mp4, write_mp4
import numpy as np
import pytest

RATE = 7.5
# Of 255, in the mean: OpenCV's way to the film's colours and back alone takes 4 off blue.
CODED = 5.0


@pytest.fixture
def pictures():
    """Smooth pictures of odd size, another in every channel, that change from one to the next."""
    rows, columns = np.mgrid[:91, :121]
    found = []
    for k in range(6):
        red, green, blue = 40 * k + 0 * rows, 2 * rows, 255 - 2 * columns
        found.append(np.stack([red, green, blue], axis=-1).astype(np.uint8))
    return found


def _decoded(path):
    film = cv2.VideoCapture(str(path))
    frames = []
    while True:
        read, frame = film.read()
        if not read:
            return frames, film.get(cv2.CAP_PROP_FPS)
        frames.append(cv2.cvtColor(frame, cv2.COLOR_BGR2RGB))


def test_every_picture_is_there_in_its_colours_and_at_its_rate(pictures, tmp_path):
    path = tmp_path / 'new' / 'film.mp4'
    write_mp4(path, iter(pictures), RATE)
    frames, rate = _decoded(path)
    assert rate == pytest.approx(RATE)
    assert len(frames) == len(pictures)
    for frame, picture in zip(frames, pictures, strict=True):
        # The last row and column are repeated: there is an even number of both.
        assert frame.shape == (92, 122, 3)
        wrong = np.abs(frame[:91, :121].astype(np.int64) - picture).mean(axis=(0, 1))
        assert wrong.max() < CODED
    assert [child.name for child in path.parent.iterdir()] == ['film.mp4']


def test_the_film_before_stays_when_a_picture_fails(pictures, tmp_path):
    path = tmp_path / 'film.mp4'
    path.write_bytes(b'before')

    def spoilt():
        yield pictures[0]
        raise RuntimeError('the second cannot be drawn')

    with pytest.raises(RuntimeError, match='the second'):
        write_mp4(path, spoilt(), RATE)
    assert path.read_bytes() == b'before'
    assert list(tmp_path.iterdir()) == [path]


def test_pictures_that_are_lost_are_told(pictures, tmp_path):
    # OpenCV leaves out a picture of another size without a word, as it does on a full disk.
    with pytest.raises(InputError, match='not all of 2 pictures were written'):
        write_mp4(tmp_path / 'film.mp4', [pictures[0], pictures[1][:-9]], RATE)
    assert not list(tmp_path.iterdir())


def test_a_film_that_hardly_moves_is_refused(pictures, tmp_path):
    with pytest.raises(InputError, match=r'play at 0.05 pictures a second .* slow it down less'):
        write_mp4(tmp_path / 'film.mp4', pictures, 0.05)


def test_an_opencv_without_encoder_is_refused_with_the_remedy():
    check_mp4()
    code = 'from diffcal_ros.recording.mp4_file import check_mp4; check_mp4()'
    # OpenCV reads it once, when it is imported.
    without = {**os.environ, 'OPENCV_VIDEOIO_PRIORITY_FFMPEG': '0'}
    ran = subprocess.run(
        [sys.executable, '-c', code], env=without, capture_output=True, text=True, check=False
    )
    assert ran.returncode != 0
    assert 'pip install opencv-contrib-python-headless, whose wheels can, or write a GIF' in (
        ran.stderr
    )
