# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Record a body that changes while the camera looks on, and is at rest before and after."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.names import DEPTH_FRAME
from diffcal_ros.scene.model import Scene
from diffcal_ros.synthetic.posed_body import pose_body
from diffcal_ros.synthetic.recorded_scene import scene_text, write_files
from diffcal_ros.synthetic.recorder import RecorderSettings
from diffcal_ros.synthetic.rig import make_rig, Rig
import numpy as np

_FIRST_STAMP_NS = 1_700_000_000_000_000_000
_SECOND = 1_000_000_000  # [ns]


@dataclass(frozen=True)
class BodyState:
    """What became of a body.

    Attributes:
        factor: by which Young's modulus of every region is multiplied.
        payload: mass that hangs on its far end [kg].
    """

    factor: float = 1.0
    payload: float = 0.0

    def __post_init__(self) -> None:
        if not self.factor > 0.0 or not self.payload >= 0.0:
            raise InputError(
                f"the modulus' factor is {self.factor:g} and the payload {self.payload:g} kg: "
                'give a factor above zero, and no negative payload'
            )


def record_changes(
    scene: Scene, out: Path, states: Sequence[BodyState], settings: RecorderSettings
) -> Path:
    """Record the first posture of a scene in several states, one after the other.

    Args:
        scene: read from a file, without motion; its start values are the first truth.
        out: folder to write `bag`, `scene.yaml` with the camera's pose, and the mesh to.
        states: of the body, at least one.
        settings: how to record; the frames of `timing` for each state, no colour.

    Returns:
        The scene file.

    Raises:
        InputError: when a state cannot be simulated or seen, or `out` cannot be written.
    """
    if scene.path is None or not scene.document:
        raise ValueError('the scene was built in memory: only one read from a file is recorded')
    if not states:
        raise InputError('no state of the body was given: give at least one')
    rigs = _rigs(scene, states, settings)
    text = scene_text(
        scene,
        bags={rigs[0].name: 'bag'},
        lidar=settings.lidar,
        start_factor=settings.start_factor,
        poses={rigs[0].name: rigs[0].depth_from_world},
    )
    _write_bag(out / 'bag', rigs, settings)
    write_files(scene, out)
    write_text_atomically(out / 'scene.yaml', text)
    return out / 'scene.yaml'


def with_modulus(scene: Scene, factor: float) -> Scene:
    """Return the scene with every start value of Young's modulus multiplied."""
    regions = tuple(
        replace(
            region,
            youngs_modulus=replace(
                region.youngs_modulus, start=factor * region.youngs_modulus.start
            ),
        )
        for region in scene.regions
    )
    return replace(scene, regions=regions)


def _rigs(scene: Scene, states: Sequence[BodyState], settings: RecorderSettings) -> list[Rig]:
    """Look at every state from where the first one is seen best."""
    true_scene = replace(
        scene,
        element=settings.element,
        depth_camera=scene.depth_camera or settings.depth_camera,
        color_camera=scene.color_camera or settings.color_camera,
    )
    setup = true_scene.observations[0]
    rigs: list[Rig] = []
    for state in states:
        load = {'added_mass': {'mass': state.payload, 'at': 1.0}}
        body = pose_body(with_modulus(true_scene, state.factor), setup, effects=load)
        rig = make_rig(true_scene, setup, body, settings.camera_position if not rigs else None)
        setup = replace(setup, stored_depth_from_world=rig.depth_from_world)
        rigs.append(rig)
    return rigs


def _write_bag(path: Path, rigs: Sequence[Rig], settings: RecorderSettings) -> None:
    period, lidar = round(_SECOND / settings.timing.rate), settings.lidar
    bias_random = np.random.default_rng([settings.seed, 0])
    bias = lidar.bias_field(rigs[0].depth_scan.depth.shape, bias_random)
    with BagWriter(path) as bag:
        for index in range(len(rigs) * settings.timing.frames):
            rig = rigs[index // settings.timing.frames]
            stamp = _FIRST_STAMP_NS + index * period
            random = np.random.default_rng([settings.seed, 1, index])
            depth = lidar.measure(rig.depth_scan, bias, random)
            bag.write_depth_camera(rig.depth_camera, stamp_ns=stamp, frame_id=DEPTH_FRAME)
            bag.write_depth(DepthFrame(depth, stamp, DEPTH_FRAME), encoding=lidar.encoding)
