# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The section `pose`: where the camera's pose comes from, and how well it is known."""

import math

from diffcal_ros.scene.model import POSE_SOURCES, PoseSetup
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.shapes import Choice, Interval, Keys, Number, Text

# Beyond a metre, or a quarter turn, nothing is known.
_POSITIONS = Interval(0.0, 1.0)
_ANGLES = Interval(0.0, 90.0)

POSE_SHAPE = Keys(
    {
        'source': Choice(POSE_SOURCES, 'where the pose comes from; default marker'),
        'world_frame': Text("TF's name of this scene's world"),
        'topic': Text("default: the recording's only one; live marker_pose/pose"),
        'position_std': Number("of the camera's position along each axis, in m", _POSITIONS),
        'rotation_std_deg': Number("of the camera's direction about each axis", _ANGLES),
    },
    about="where the depth camera's pose comes from, and how well it is known",
)


def read_pose(owner: Section, usual: PoseSetup) -> PoseSetup:
    """Read `pose` of a scene or an observation.

    Args:
        owner: the scene, or one of its observations.
        usual: what holds for keys that are not given: for an observation, the scene's.
    """
    section = owner.child('pose')
    if section is None:
        return usual
    source = usual.source
    if section.has('source'):
        source = section.choice('source')
    world_frame = section.text(
        'world_frame', default=usual.world_frame, needed='name a frame of TF'
    )
    topic = section.text('topic', default=usual.topic, needed='name a topic')
    position, rotation = usual.position_std, usual.rotation_std
    if section.has('position_std'):
        position = section.number(
            'position_std',
            needed='give a standard deviation in metres, between 0 and 1',
        )
    if section.has('rotation_std_deg'):
        degrees = section.number(
            'rotation_std_deg',
            needed='give a standard deviation in degrees, between 0 and 90',
        )
        rotation = math.radians(degrees)
    section.refuse_unknown()
    if not section.is_sound:
        return usual
    if source == 'tf' and not world_frame:
        section.problems.add(
            section.at('world_frame'),
            "is missing: name TF's frame that is the world of this scene",
        )
        return usual
    try:
        return PoseSetup(source, world_frame, topic, position, rotation)
    except ValueError:
        section.problems.add(
            section.key,
            'has a standard deviation of 0 beside another: give 0 for both position_std and '
            'rotation_std_deg where the pose is exact, or none',
        )
        return usual
