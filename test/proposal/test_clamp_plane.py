# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clamp begins where something hides the body, not where the body is looked through."""

from types import SimpleNamespace

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.proposal.clamp_plane import find_clamp_plane
from diffcal_ros.proposal.hold import Hold
import numpy as np
import pytest

CAMERA = PinholeCamera(200, 60, 400.0, 400.0, 100.0, 30.0)
AWAY = 0.4  # Of the bar from the camera [m].
CLAMP = 0.03  # Where it begins on the camera's x [m].
ROWS = slice(20, 40)


@pytest.fixture
def seen(make_beam):
    """A bar along the camera's x that is hidden from x = 30 mm on, drawn where it is."""
    mesh = make_beam((14, 1, 2), (0.14, 0.02, 0.01))
    world_from_object = np.eye(4)
    world_from_object[2, 3] = AWAY
    across = (np.arange(CAMERA.width) - CAMERA.cx) / CAMERA.fx * AWAY
    rows, columns = np.nonzero(
        np.isin(np.arange(CAMERA.height), np.arange(CAMERA.height)[ROWS])[:, None]
        & (np.abs(across) < 0.07)[None]
    )
    trace = SimpleNamespace(rows=rows, columns=columns, depth=np.full(len(rows), AWAY))
    depth = np.full((CAMERA.height, CAMERA.width), AWAY)
    depth[:, across > CLAMP] = AWAY - 0.05
    return mesh, world_from_object, trace, depth, across


def plane_of(seen, depth):
    mesh, world_from_object, trace, _, _ = seen
    observation = SimpleNamespace(depth=depth, camera=CAMERA, depth_from_world=np.eye(4))
    hold = Hold(np.array([1.0, 0.0, 0.0]), 0.05)
    view = SimpleNamespace(trace=trace)
    return find_clamp_plane(view, observation, world_from_object, hold, mesh, 1e-4)


def test_the_clamp_begins_where_the_bar_disappears(seen):
    found = plane_of(seen, seen[3])
    assert found.is_seen
    assert found.plane == pytest.approx(CLAMP, abs=0.002)


def test_what_is_looked_through_is_not_in_the_clamp(seen):
    """A quarter of it behind something, the wall in sight where the rest should be."""
    depth, across = seen[3].copy(), seen[4]
    wrong = (across > 0.0) & (across <= CLAMP)
    depth[:, wrong] = AWAY + 0.3
    depth[20:25, wrong] = AWAY - 0.05
    found = plane_of(seen, depth)
    assert found.plane == pytest.approx(CLAMP, abs=0.002)
