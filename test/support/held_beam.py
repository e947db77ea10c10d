# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The filmed beam with a rigid bracket around its clamp, and no marker."""

from dataclasses import dataclass, replace
from pathlib import Path

from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.names import DEPTH_FRAME
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Fixture, Scene
from diffcal_ros.synthetic.posed_body import pose_body
from diffcal_ros.synthetic.recorder import SyntheticRecording
import numpy as np

from benchmarks import rigid_parts
from support.posed_bags import posed, true_pose
from support.recorded_beam import MODULUS

# Where the beam's free part ends, along x in its frame [m].
FRONT = 0.105
# Depth of the wall behind [m].
WALL = 0.9


@dataclass(frozen=True)
class HeldBeam:
    """A recording of depth alone, and what is known of it.

    Attributes:
        bag: with the bracket in every image.
        scene: states the bracket, and no marker.
        truth: depth_from_world, shape (4, 4).
    """

    bag: Path
    scene: Scene
    truth: np.ndarray


def bracket(scene: Scene) -> Fixture:
    """Return an L that holds the beam's end, from where its clamp begins."""
    part = rigid_parts.bracket(np.array([0.024, 0.022]), 0.035)
    # It runs to -x from its front, and the beam is held towards +x.
    positions = part.positions * [-1.0, 1.0, 1.0]
    beam = scene.mesh.rest_positions
    middle = 0.5 * (beam.min(axis=0) + beam.max(axis=0))
    return Fixture(positions + np.array([FRONT, *middle[1:]]), part.triangles[:, ::-1])


def film_in_bracket(recorded: SyntheticRecording, path: Path) -> HeldBeam:
    """Film the beam with its true modulus in the bracket, from the recorder's camera."""
    scene = load_scene(recorded.scene)
    scene = replace(posed(scene, source='fixture'), fixture=bracket(scene), marker=None)
    (setup,) = scene.observations
    truth = true_pose(recorded)
    source = open_recording(recorded.bags['observation'])
    camera, part = source.depth_camera, bracket(scene)
    (region,) = scene.regions
    true_region = replace(region, youngs_modulus=replace(region.youngs_modulus, start=MODULUS))
    body = pose_body(replace(scene, regions=(true_region,)), setup)
    shown = np.full((camera.height, camera.width), WALL)
    for points, triangles in (
        (body.positions, body.triangles),
        (apply(setup.world_from_object, part.positions), part.triangles),
    ):
        trace = DepthTracer(triangles, len(points), camera).trace(apply(truth, points))
        shown = np.fmin(shown, trace.full_depth())
    random = np.random.default_rng(3)
    with BagWriter(path) as bag:
        for frame in source.depth_frames():
            depth = (shown + random.normal(0.0, 1.5e-4, shown.shape)).astype(np.float32)
            bag.write_depth_camera(camera, stamp_ns=frame.stamp_ns, frame_id=DEPTH_FRAME)
            bag.write_depth(replace(frame, depth=depth))
    return HeldBeam(path, scene, truth)


def write_surface(part: Fixture, path: Path) -> None:
    """Write a part as an .obj file in millimetres."""
    lines = [f'v {x} {y} {z}' for x, y, z in (1e3 * part.positions).tolist()]
    lines += [f'f {a} {b} {c}' for a, b, c in (part.triangles + 1).tolist()]
    path.write_text('\n'.join(lines) + '\n')
