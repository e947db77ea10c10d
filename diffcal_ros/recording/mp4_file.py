# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pictures as an MP4 file, encoded as VP9: browsers and players show it, and it is free."""

from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
from diffcal_ros.atomic_file import replacing
from diffcal_ros.errors import InputError
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]

_FOURCC = 'vp09'
# OpenCV keeps rates to a thousandth of a picture a second.
_SLOWEST = 0.1


def check_mp4() -> None:
    """Refuse early where films cannot be encoded.

    Raises:
        InputError: saying what to install.
    """
    with TemporaryDirectory() as folder:
        _open(Path(folder) / 'film.mp4', (16, 16), 1.0).release()


def write_mp4(path: Path, pictures: Iterable[Picture], rate: float) -> None:
    """Write pictures as a film; none but the present one is kept in memory.

    Args:
        path: MP4 file.
        pictures: red, green and blue, shape (h, w, 3), all of one shape; at least one. An
            odd number of rows or columns becomes even.
        rate: pictures a second [Hz].

    Raises:
        InputError: when the file cannot be written, or this OpenCV has no encoder.
    """
    if rate < _SLOWEST:
        raise InputError(
            f'the film would play at {rate:.2g} pictures a second and MP4 holds {_SLOWEST:g} or '
            'more: slow it down less, or write a GIF'
        )
    with replacing(path) as fresh:
        count = _encode(fresh, pictures, rate)
        # OpenCV says nothing when the disk is full: the index at the file's end tells.
        if _count(fresh) != count:
            raise OSError(f'not all of {count} pictures were written')


def _encode(path: Path, pictures: Iterable[Picture], rate: float) -> int:
    writer: cv2.VideoWriter | None = None
    count = 0
    try:
        for picture in pictures:
            even = _even(picture)
            if writer is None:
                writer = _open(path, (even.shape[1], even.shape[0]), rate)
            writer.write(cv2.cvtColor(even, cv2.COLOR_RGB2BGR))
            count += 1
    finally:
        if writer is not None:
            writer.release()
    return count


def _even(picture: Picture) -> Picture:
    """Repeat the last row or column where its number is odd: OpenCV would cut it off."""
    rows, columns = picture.shape[0] % 2, picture.shape[1] % 2
    return np.pad(picture, ((0, rows), (0, columns), (0, 0)), mode='edge')


def _open(path: Path, size: tuple[int, int], rate: float) -> cv2.VideoWriter:
    code = cv2.VideoWriter.fourcc(*_FOURCC)
    writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, code, rate, size)
    if not writer.isOpened():
        raise InputError(
            f'this OpenCV ({cv2.__version__}) cannot encode an MP4 film (VP9): pip install '
            'opencv-contrib-python-headless, whose wheels can, or write a GIF'
        )
    return writer


def _count(path: Path) -> int:
    return int(cv2.VideoCapture(str(path), cv2.CAP_FFMPEG).get(cv2.CAP_PROP_FRAME_COUNT))
