# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A depth camera before a predicted body: where it stands, and what it reads."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.forward.effect_model import EffectModel
from diffcal_ros.calibration.parameters.lens import through_lens
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import DepthTracer, OutOfViewError
from diffcal_ros.effects.camera_offset import stated_lens, stated_offset
from diffcal_ros.errors import SceneError
from diffcal_ros.prediction.predicted_body import PredictedBody
from diffcal_ros.rigid_motion import moved
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import Scene
from diffcal_ros.synthetic.viewpoint import COLOR_CAMERA, default_view, DEPTH_CAMERA, view_from
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
DepthArray = NDArray[np.float32]


@dataclass(frozen=True)
class PredictedView:
    """One body before one camera.

    Attributes:
        scene: states the errors of sensor and camera pose.
        body: what is looked at.
        camera: intrinsics.
        depth_from_world: pose of the camera, shape (4, 4).
        offset_pivot: about which the scene's camera offset turns, camera frame [m], shape (3,).
    """

    scene: Scene
    body: PredictedBody
    camera: PinholeCamera
    depth_from_world: FloatArray
    offset_pivot: FloatArray

    def depths(self) -> Iterator[DepthArray]:
        """Yield what the camera reads in each frame [m], shape (H, W); NaN beside the body.

        The sensor's errors that the scene states are in it, noise and rounding are not.

        Raises:
            SceneError: when the body leaves the view.
        """
        shape, camera = self.body.discretisation, self.camera
        effects = EffectModel(self.scene, ParameterSet())
        sensor = effects.sensor(effects.amplitudes(np.zeros(0)))
        posture = next(
            number
            for number, setup in enumerate(self.scene.observations)
            if setup.name == self.body.setup.name
        )
        surface = effects.surface(posture, shape, shape.surface_triangles)
        tracer = DepthTracer(shape.surface_triangles, shape.node_count, camera)
        for time, positions in zip(self.body.times.tolist(), self.body.positions, strict=True):
            trace = self._trace(tracer, positions, time)
            image = np.full((camera.height, camera.width), np.nan, dtype=np.float32)
            directions = camera.directions(trace.rows, trace.columns)
            seen = surface.seen(trace, directions)
            image[trace.rows, trace.columns] = sensor.reading(seen)
            yield image

    def _trace(self, tracer: DepthTracer, positions: FloatArray, time: float) -> Trace:
        try:
            trace = tracer.trace(self._points(positions))
            if not (trace.faces >= 0).any():
                raise OutOfViewError('the body covers no pixel')
            return trace
        except OutOfViewError as error:
            raise SceneError(
                f'{self.body.setup.name} is out of view {time:.3g} s after the beginning: '
                f'{error}; give another --camera-position'
            ) from error

    def _points(self, positions: FloatArray) -> FloatArray:
        """Return nodes in the camera's frame [m], shape (N, 3), with the scene's offset."""
        offset, lens = stated_offset(self.scene.effects), stated_lens(self.scene.effects)
        points = moved(apply(self.depth_from_world, positions), offset, self.offset_pivot)
        return through_lens(points, lens)


def look_at(
    scene: Scene,
    bodies: Sequence[PredictedBody],
    position: tuple[float, float, float] | None = None,
) -> list[PredictedView]:
    """Put a camera before each body.

    Args:
        scene: gives intrinsics, where it has them.
        bodies: all of their frames are to be seen.
        position: of the camera in the world [m]; None: the pose that the scene stores, else one
            that sees the whole motion.

    Raises:
        InputError: when the camera stands where it cannot look at a body.
    """
    camera = scene.depth_camera or DEPTH_CAMERA
    poses = [_pose(scene, body, camera, position) for body in bodies]
    pivots = [
        apply(pose, body.discretisation.rest_nodes[body.held_nodes].mean(axis=0))
        for body, pose in zip(bodies, poses, strict=True)
    ]
    # As in a fit: a camera that is elsewhere is elsewhere in every view.
    pivot = np.mean(pivots, axis=0)
    return [
        PredictedView(scene, body, camera, pose, pivot)
        for body, pose in zip(bodies, poses, strict=True)
    ]


def _pose(
    scene: Scene,
    body: PredictedBody,
    camera: PinholeCamera,
    position: tuple[float, float, float] | None,
) -> FloatArray:
    """Return `depth_from_world`, shape (4, 4)."""
    setup, points = body.setup, body.positions.reshape(-1, 3)
    if position is not None:
        return view_from(np.array(position), points, setup.gravity)
    if setup.stored_depth_from_world is not None:
        return setup.stored_depth_from_world
    first = body.positions[0]
    outward = first.mean(axis=0) - first[body.held_nodes].mean(axis=0)
    color = scene.color_camera or COLOR_CAMERA
    return default_view(points, outward, setup.gravity, scene.marker, camera, color)
