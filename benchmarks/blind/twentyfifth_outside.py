# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-fifth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm, where the mechanics
allow it.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup

_MOVES = (0.002, 0.004, 0.010)  # Of what is seen of a body [m].
_RIBBED = (0.1, 0.2, 0.31)  # Share by which a section is larger or smaller.
_MOST_MIRRORED = 0.5  # Of a depth, that is another place's.


def ribbed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw the waves of a bellows, out of which a mould was made in place of a plain tube."""
    changes = {
        'ribbed': number(_RIBBED[size], random),
        'ribbed_waves': round(float(random.uniform(1.6, 2.6)), 4),
        'ribbed_phase': round(float(random.uniform(0.0, 2.0 * np.pi)), 4),
    }
    amplitude: dict[str, float | str] = {
        'share': changes['ribbed'],
        'waves': changes['ribbed_waves'],
        'phase': changes['ribbed_phase'],
    }
    return Effect('ribbed', amplitude, 'of the section, -, rad', changes)


def mirrored(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much light a lens reflects across a place amid what it sees of a body."""
    shape, camera, views = setup.shape, setup.camera, []
    ends = shape.place(np.array([[shape.clamp, 0.0, 0.0], [shape.length, 0.0, 0.0]]))
    for pose in setup.observations:
        places = applied(setup.depth_from_world @ pose.world_from_object, ends)
        views.append((abs(float(places[1, 2] - places[0, 2])), camera.project(places)))
    # Of the pose in which one end is farthest behind the other.
    step, seen = max(views, key=lambda view: view[0])
    at = seen.mean(axis=0) - [camera.cx, camera.cy] + random.uniform(-4.0, 4.0, 2)
    most = min(_MOVES[2] / step, _MOST_MIRRORED)
    changes = {
        'mirrored': number(most * _MOVES[size] / _MOVES[2], random),
        'mirrored_at': tuple(round(float(place), 3) for place in at),
    }
    amplitude: dict[str, float | str] = {
        'share': changes['mirrored'],
        'across': changes['mirrored_at'][0],
        'down': changes['mirrored_at'][1],
    }
    return Effect('mirrored', amplitude, '-, px', changes)


TWENTYFIFTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (ribbed, mirrored)}
