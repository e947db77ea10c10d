# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""OpenCV's predefined marker dictionaries as data, so that a scene is read without OpenCV."""

MARKER_COUNTS = {
    **{
        f'DICT_{bits}X{bits}_{count}': count
        for bits in (4, 5, 6, 7)
        for count in (50, 100, 250, 1000)
    },
    'DICT_ARUCO_ORIGINAL': 1024,
    'DICT_APRILTAG_16h5': 30,
    'DICT_APRILTAG_25h9': 35,
    'DICT_APRILTAG_36h10': 2320,
    'DICT_APRILTAG_36h11': 587,
}
