# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the thirty-first set that change what is seen do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_faults, draw_sealed, SEALED
from support.blind_rests import COARSE
from support.blind_views import with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.wiping import BLUR


@pytest.mark.parametrize(('size', 'most'), [(1, 4.0), (2, 10.0)])
def test_a_wiper_leaves_grease_beyond_its_reach(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults, parts = draw_faults('depth_affine/wiped', setup, size), []
    assert abs(faults.depth_bias) == pytest.approx(most, rel=0.16)
    # The hinge is outside the picture's middle.
    assert np.hypot(*faults.depth_spot) > 0.5 * setup.camera.width
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, _ = np.nonzero(there)
        ways = columns + right.column - setup.camera.cx - faults.depth_spot[0] + 0j
        ways += 1j * (rows + right.row - setup.camera.cy - faults.depth_spot[1])
        beyond = (np.abs(ways) - faults.depth_width) / BLUR
        errors = 1e3 * (view.depth[there] - right.depth[there])
        expected = faults.depth_bias / (1.0 + np.exp(-2.0 * np.clip(beyond, -300.0, 300.0)))
        assert errors == pytest.approx(expected, abs=1e-6)
        parts.append((beyond[right.labels[there] != FIXTURE] > 0.0).mean())
    # The edge crosses the body of the first pose.
    assert 0.1 < parts[0] < 0.9


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_wipers_edge_crosses_each_body(family: str) -> None:
    drawn = draw_sealed(family)
    shape, camera = drawn.shape, drawn.camera
    faults = draw_faults('depth_affine/wiped', drawn)
    ends = shape.place(np.array([[shape.clamp, 0.0, 0.0], [shape.length, 0.0, 0.0]]))
    world = drawn.depth_from_world @ drawn.observations[0].world_from_object
    hinge = np.array([camera.cx, camera.cy]) + faults.depth_spot
    ways = camera.project(ends @ world[:3, :3].T + world[:3, 3]) - hinge
    one, other = np.sort(np.linalg.norm(ways, axis=1))
    assert one < faults.depth_width < other


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_tripod_turns_about_two_of_its_feet(family: str) -> None:
    drawn = draw_sealed(family)
    plain, stored = make_specimen(drawn, Faults(), COARSE), drawn.depth_from_world
    standing = -stored[:3, :3].T @ stored[:3, 3]
    for size, most in ((1, 0.004), (2, 0.010)):
        faults, turns, seen = draw_faults('camera_offset/carpet', drawn, size), [], []
        foot = stored[:3, :3].T @ (np.array(faults.camera_foot) - stored[:3, 3])
        assert 0.34 < standing[1] - foot[1] < 0.61
        for pose in range(4):
            off = jostled(drawn, drawn.observations[pose], faults)
            found = true_camera(plain, drawn, off)
            # Where what is fixed to the camera goes, world.
            moved = np.linalg.inv(found) @ stored
            assert moved[:3, :3] @ foot + moved[:3, 3] == pytest.approx(foot, abs=1e-6)
            skew = 0.5 * (moved[:3, :3] - moved[:3, :3].T)
            turns.append(np.array([skew[2, 1], skew[0, 2], skew[1, 0]]))
            seen.append(float(np.linalg.norm(moved[:3, 3])))
        # About one level line, farther in each pose, and less and less.
        assert np.abs(np.array(turns)[:, 1]).max() < 1e-5
        sizes = np.linalg.norm(turns, axis=1)
        assert np.linalg.norm(np.cross(turns[1], turns[3])) < 1e-3 * sizes[1] * sizes[3] + 1e-9
        assert sizes[0] == pytest.approx(0.0, abs=1e-9)
        steps = np.diff(sizes)
        assert steps[0] > steps[1] > steps[2] > 0.0
        # What is at the world's origin, where bodies are.
        assert seen[3] == pytest.approx(most, rel=0.16)
        # A third foot, at the camera's other side of that line, sinks.
        ahead = np.cross([0.0, 1.0, 0.0], turns[3])
        beside = (standing - foot) @ ahead / np.linalg.norm(ahead)
        third = foot + 3.0 * beside * ahead / np.linalg.norm(ahead)
        assert np.cross(turns[3], third - foot)[1] < 0.0
