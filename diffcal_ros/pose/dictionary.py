# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""OpenCV's predefined marker dictionaries by name."""

import cv2
from diffcal_ros.errors import PoseError
import numpy as np
from numpy.typing import NDArray


def dictionary_names() -> tuple[str, ...]:
    """List the dictionaries of the installed OpenCV."""
    return tuple(sorted(name for name in dir(cv2.aruco) if name.startswith('DICT_')))


def marker_dictionary(name: str) -> cv2.aruco.Dictionary:
    """Return a predefined dictionary.

    Raises:
        PoseError: for another name; lists the known ones.
    """
    if name not in dictionary_names():
        raise PoseError(
            f'marker dictionary is {name!r}, which OpenCV does not know: give one of '
            f'{", ".join(dictionary_names())}'
        )
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))


def marker_cells(name: str, marker_id: int) -> NDArray[np.bool_]:
    """Return a marker's squares, black border included; True is white.

    Args:
        name: the dictionary.
        marker_id: number in it.

    Returns:
        Rows from the top, shape (bits + 2, bits + 2).

    Raises:
        PoseError: for an unknown dictionary or a number beyond it.
    """
    dictionary = marker_dictionary(name)
    check_marker_id(name, marker_id)
    side = dictionary.markerSize + 2
    return np.asarray(dictionary.generateImageMarker(marker_id, side) > 0)


def check_marker_id(name: str, marker_id: int) -> None:
    """Say so when a dictionary has no marker of that number."""
    count = len(marker_dictionary(name).bytesList)
    if not 0 <= marker_id < count:
        raise PoseError(
            f'marker id is {marker_id}, but {name} holds 0 to {count - 1}: read the id off the '
            'print, or give a larger dictionary'
        )
