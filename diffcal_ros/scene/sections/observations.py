# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The observations of a scene: how the body is placed, held and filmed each time."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from diffcal_ros.scene.model import (
    Cable,
    HeldPart,
    MotionSetup,
    ObservationSetup,
    PoseSetup,
)
from diffcal_ros.scene.reading.problems import listed, suggestion
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.shapes import (
    Constant,
    Interval,
    Keys,
    ListOf,
    OneOf,
    Shape,
    Text,
    vector,
)
from diffcal_ros.scene.sections.cables import PULLS_SHAPE, read_pulls
from diffcal_ros.scene.sections.held_parts import (
    check_hold,
    check_shared_vertices,
    read_turn,
    TURN_SHAPE,
)
from diffcal_ros.scene.sections.motion import MOTION_SHAPE, read_motion
from diffcal_ros.scene.sections.placement import placement_shape, read_placement
from diffcal_ros.scene.sections.pose_section import POSE_SHAPE, read_pose
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_LONGEST_NAME = 80
_NAME = (
    f'it becomes part of file names: leave out / and what cannot be printed, and use at most '
    f'{_LONGEST_NAME} letters'
)
_GRAVITY = 'give the acceleration in m/s^2 in the world frame, for example [0, -9.81, 0]'
_GRAVITIES = Interval(-100.0, 100.0)  # In m/s^2; more is mm/s^2, or a slip.

# What stands in the scene for all observations, or in one of them.
POSTURE_SHAPES: dict[str, Shape] = {
    'placement': placement_shape('world_from_object: where the mesh sits before it is bent'),
    'stored_depth_from_world': placement_shape('a camera pose that is known beforehand'),
    'gravity': vector(3, 'in m/s^2, world frame', _GRAVITIES),
    'bag': Text('a rosbag2 folder or .mcap; the command line may name it'),
    'motion': MOTION_SHAPE,
    'pose': POSE_SHAPE,
}
_HELD_TURNS = Keys(
    about='other turns of held parts; null: not turned',
    named=OneOf((TURN_SHAPE, Constant(None))),
)
_OBSERVATION_SHAPE = Keys(
    {
        'name': Text('unique'),
        'held_parts': ListOf(Text(), 'parts that hold here; default: all', fewest=1),
        'held_turns': _HELD_TURNS,
        'pulls': PULLS_SHAPE,
        **POSTURE_SHAPES,
    },
    ('name',),
    'one way in which the body is filmed; what it does not give is as above',
)
OBSERVATIONS_SHAPE = ListOf(
    _OBSERVATION_SHAPE, 'several ways in which the body is filmed; they share the material', 1
)


def read_observations(
    scene: Section,
    held: Sequence[HeldPart],
    cables: Sequence[Cable],
    folder: Path,
    mesh: TetMesh | None,
) -> tuple[ObservationSetup, ...]:
    """Read `observations`, or make the one that the scene's own keys describe.

    Args:
        scene: the whole file.
        held: clamped parts with the turns that `held` gives them.
        cables: of the body.
        folder: where relative bag paths start.
        mesh: to tell whether the parts that an observation names hold it.
    """
    pose = read_pose(scene, PoseSetup())
    if not scene.has('observations'):
        only = _read_one(scene, scene, tuple(held), folder, mesh, name='observation')
        return () if only is None else (replace(only, pose=pose),)
    items = scene.raw('observations')
    if not isinstance(items, list) or not items:
        scene.wrong('observations', 'give a list, `- name: ..` each')
        return ()
    setups: list[ObservationSetup] = []
    for index, item in enumerate(items):
        key = f'observations[{index}]'
        if not isinstance(item, dict):
            scene.problems.add(key, 'is no mapping: start it with `name: ..`')
            continue
        section = Section(item, key, scene.problems, _OBSERVATION_SHAPE)
        name = section.text('name', needed='give each observation a name')
        if '/' in name or not name.isprintable() or len(name) > _LONGEST_NAME:
            section.wrong('name', _NAME)
        if any(setup.name == name for setup in setups):
            section.wrong('name', 'another observation has that name, choose a new one')
        own = _read_held(section, held, mesh)
        setup = _read_one(section, scene, own, folder, mesh, name=name)
        pulls = read_pulls(section, cables)
        own_pose = read_pose(section, pose)
        section.refuse_unknown()
        if setup is not None:
            setups.append(replace(setup, pulls=pulls, pose=own_pose))
    return tuple(setups)


def _read_one(
    section: Section,
    scene: Section,
    held: tuple[HeldPart, ...],
    folder: Path,
    mesh: TetMesh | None,
    *,
    name: str,
) -> ObservationSetup | None:
    """Read one observation; what it does not give stands in the scene."""
    world_from_object = _placement(section, scene, 'placement')
    if world_from_object is None and not (section.has('placement') or scene.has('placement')):
        scene.problems.add(
            section.at('placement'), 'is missing: give translation and rotation of the mesh'
        )
    stored = _placement(section, scene, 'stored_depth_from_world')
    gravity = _gravity(section if section.has('gravity') else scene)
    bag_owner = section if section.has('bag') else scene
    bag = bag_owner.path('bag', folder) if bag_owner.has('bag') else None
    motion = _motion(section if section.has('motion') else scene, held, mesh)
    if world_from_object is None:
        return None
    return ObservationSetup(
        name=name,
        world_from_object=world_from_object,
        gravity=gravity,
        held=held,
        bag=bag,
        stored_depth_from_world=stored,
        motion=motion,
    )


def _placement(section: Section, scene: Section, name: str) -> FloatArray | None:
    """Read a transform from the observation, or else from the scene."""
    owner = section if section.has(name) else scene
    if scene.problems.touch(owner.at(name)):
        return None  # The scene's own is read for every observation; mistakes are told once.
    child = owner.child(name)
    return None if child is None else read_placement(child)


def _motion(
    owner: Section, held: tuple[HeldPart, ...], mesh: TetMesh | None
) -> MotionSetup | None:
    if owner.problems.touch(owner.at('motion')):
        return None
    child = owner.child('motion')
    return None if child is None else read_motion(child, held, mesh)


def _gravity(owner: Section) -> FloatArray:
    if owner.problems.touch(owner.at('gravity')):
        return np.zeros(3)
    return owner.vector('gravity', needed=_GRAVITY)


def _read_held(
    section: Section, held: Sequence[HeldPart], mesh: TetMesh | None
) -> tuple[HeldPart, ...]:
    """Take the parts that hold in this observation, with its own turns."""
    picked, turns = section.raw('held_parts'), section.child('held_turns')
    if not held:
        return ()  # Wrong as written; an observation that names a part is not to blame.
    names = [part.name for part in held]
    parts = list(held)
    if picked is not None:
        sound = isinstance(picked, list) and picked and all(name in names for name in picked)
        if not sound:
            section.wrong('held_parts', f'give a list of held parts, from {listed(names)}')
            return ()
        parts = [part for part in held if part.name in picked]
    if turns is not None:
        parts = _turned(turns, parts)
        check_shared_vertices(parts, turns)
    if mesh is not None and picked is not None:
        check_hold(section, mesh, parts)
    return tuple(parts)


def _turned(turns: Section, held: list[HeldPart]) -> list[HeldPart]:
    names = [part.name for part in held]
    for name in turns.names:
        if name not in names:
            turns.problems.add(
                turns.at(name),
                f'is no part held here{suggestion(name, names)} (held: {listed(names)})',
            )
    turned = []
    for part in held:
        own = turns.child(part.name)
        turn = None if own is None else read_turn(own)
        turned.append(replace(part, turn=turn) if part.name in turns.names else part)
    return turned
