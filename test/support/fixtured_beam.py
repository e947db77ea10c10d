# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam and a block around its held end, either of which may be elsewhere."""

from dataclasses import replace

from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.rigid_transform import apply, transform
from diffcal_ros.scene.sections.fixture import blocks_fixture
import numpy as np

from support.scenes import (
    beam_scene,
    CAMERA,
    DEPTH_FROM_WORLD,
    noisy,
    observation,
    true_depth,
    WORLD_FROM_OBJECT,
)

# Around the beam's held end, wider than the beam: the camera looks at two of its faces.
BLOCK = blocks_fixture([np.array([[-0.030, -0.011, -0.009], [-0.001, 0.037, 0.026]])])
SHIFT = np.array([0.0025, -0.002, 0.004])
FRAMES = 8


def block_depth(pose=DEPTH_FROM_WORLD, block=BLOCK):
    """Depth [m] of a block; NaN beside it."""
    points = apply(pose, apply(WORLD_FROM_OBJECT, block.positions))
    return DepthTracer(block.triangles, len(points), CAMERA).trace(points).full_depth()


def seen(*, body_shift, block_shift, seed=5):
    """Eight frames at beam and block, each shifted in the camera's frame [m]."""
    poses = [transform(np.eye(3), shift) @ DEPTH_FROM_WORLD for shift in (body_shift, block_shift)]
    exact = np.fmin(true_depth(depth_from_world=poses[0]), block_depth(poses[1]))
    random = np.random.default_rng(seed)
    depth = np.median([noisy(exact, random) for _ in range(FRAMES)], axis=0)
    noise = 0.00014 * np.sqrt(np.pi / (2.0 * FRAMES))
    return replace(observation(depth), frame_count=FRAMES, noise=float(noise))


def scene(*, has_fixture=True):
    """The beam, with its block or without."""
    return replace(beam_scene((8, 2, 2)), fixture=BLOCK if has_fixture else None)
