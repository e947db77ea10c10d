# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recordings that could be made next: the rig turned, or the camera elsewhere."""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.expected_information import Candidate
from diffcal_ros.marker import Marker
from diffcal_ros.rigid_transform import inverse, rotation_matrix, transform
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_TURNS = (-90, -45, 45, 90)  # About the upright axis [deg]; positive: the camera goes right.
_LIFTS = (-40, 40)  # [deg]
_AS_NOW = np.cos(np.deg2rad(20.0))
# A marker that is seen flatter than this from its normal gives no good pose.
_FLAT = np.cos(np.deg2rad(75.0))
_EARTH = 9.81


@dataclass(frozen=True)
class Refused:
    """A candidate that cannot be made.

    Attributes:
        words: what it would have been.
        reason: why not.
    """

    words: str
    reason: str


def make_candidates(
    now: Candidate, middle: FloatArray, marker: Marker | None
) -> tuple[list[Candidate], list[Refused]]:
    """List recordings around one that is there.

    Args:
        now: it, its posture and its camera.
        middle: of the body in the world frame [m], shape (3,); the camera goes around it.
        marker: must stay in sight; None where the camera's pose comes from elsewhere.

    Returns:
        Candidates, the same once more first, and those that the marker rules out.
    """
    again = replace(now, name='again', words='the same once more')
    candidates, refused = [again, *_turned_rigs(now)], []
    for candidate in _other_views(now, middle):
        if marker is None or _sees(candidate.depth_from_world, marker):
            candidates.append(candidate)
        else:
            refused.append(Refused(candidate.words, 'the marker would be turned away'))
    return candidates, refused


def _turned_rigs(now: Candidate) -> list[Candidate]:
    """Let gravity point along each axis of the rig; the camera turns with it."""
    stated = now.setup.gravity
    strength = float(np.linalg.norm(stated)) or _EARTH
    candidates = []
    for axis, name in enumerate('xyz'):
        for sign, word in ((1.0, '+'), (-1.0, '-')):
            direction = sign * np.eye(3)[axis]
            if float(direction @ stated) > _AS_NOW * strength:
                continue
            candidates.append(
                replace(
                    now,
                    name=f'gravity {word}{name}',
                    words=f'turn rig and camera so that gravity points along world {word}{name}',
                    setup=replace(
                        now.setup, name=f'gravity {word}{name}', gravity=strength * direction
                    ),
                )
            )
    return candidates


def _other_views(now: Candidate, middle: FloatArray) -> list[Candidate]:
    """Move the camera around the body at the same distance."""
    world_from_depth = inverse(now.depth_from_world)
    # The camera's own upright axis: y points down.
    up, right = -world_from_depth[:3, 1], world_from_depth[:3, 0]
    moves = [
        (f'view {turn:+d}', turn * up, f'{abs(turn)} degrees to the {_side(turn)}')
        for turn in _TURNS
    ]
    moves += [
        (f'view {"above" if lift > 0 else "below"}', -lift * right, f'{abs(lift)} degrees {word}')
        for lift, word in zip(_LIFTS, ('below', 'above'), strict=True)
    ]
    candidates = []
    for name, degrees, words in moves:
        rotation = rotation_matrix(np.deg2rad(degrees))
        orbit = transform(rotation, middle - rotation @ middle)
        candidates.append(
            replace(
                now,
                name=name,
                words=f'film it from {words}',
                depth_from_world=inverse(orbit @ world_from_depth),
            )
        )
    return candidates


def _side(turn: int) -> str:
    return 'right' if turn > 0 else 'left'


def _sees(depth_from_world: FloatArray, marker: Marker) -> bool:
    placed = depth_from_world @ marker.world_from_marker
    toward = -placed[:3, 3] / np.linalg.norm(placed[:3, 3])
    return bool(float(placed[:3, 2] @ toward) > _FLAT and placed[2, 3] > 0.0)
