# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The section about the marker on the rig."""

from diffcal_ros.marker import Marker
from diffcal_ros.scene.marker_dictionaries import MARKER_COUNTS
from diffcal_ros.scene.placement import read_placement
from diffcal_ros.scene.problems import suggestion
from diffcal_ros.scene.section import Interval, Section
import numpy as np

_MARKER_SIDES = Interval(0.002, 2.0)


def read_marker(scene: Section) -> Marker | None:
    """Read `marker`; None when there is none or it is wrong."""
    section = scene.child('marker')
    if section is None:
        return None
    dictionary = section.text('dictionary', needed='give a name such as DICT_6X6_250')
    if dictionary and dictionary not in MARKER_COUNTS:
        near = suggestion(dictionary, MARKER_COUNTS)
        section.wrong(
            'dictionary',
            'give one of OpenCV, DICT_<bits>X<bits>_<count> with 4 to 7 bits and 50, 100, 250 '
            f'or 1000 markers, DICT_ARUCO_ORIGINAL or DICT_APRILTAG_36h11{near}',
        )
    count = MARKER_COUNTS.get(dictionary)
    number = section.integer('id', low=0, high=None if count is None else count - 1)
    side = section.number(
        'side',
        allowed=_MARKER_SIDES,
        needed=f'give the edge of the black square in metres, {_MARKER_SIDES}',
    )
    placement = section.child('placement')
    world_from_marker = np.eye(4) if placement is None else read_placement(placement)
    section.refuse_unknown()
    if world_from_marker is None or not section.is_sound:
        return None
    return Marker(dictionary, number, side, world_from_marker)
