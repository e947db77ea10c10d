# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What stands around the body: the clamp's blocks, the marker's plate and a wall behind."""

from dataclasses import dataclass

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.facing import facing_cosines
from diffcal_ros.depth.tracer import DepthTracer, OutOfViewError
from diffcal_ros.marker import Marker
from diffcal_ros.rigid_transform import apply, inverse, rotation_matrix
from diffcal_ros.scene.model import HeldPart, ObservationSetup, Scene
from diffcal_ros.scene.posing import turn_motion, world_positions
from diffcal_ros.synthetic.posed_body import PosedBody
from diffcal_ros.synthetic.scan import Scan, Thing
from diffcal_ros.synthetic.solids import Box, Wall
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_BLOCK_MARGIN = 0.020  # How far a clamp's block reaches beyond what it holds [m].
_REACHES_OUT = 1e-4  # A body that ends this close to the held part's end does not come out [m].
_PLATE_RIM = 0.3  # Around the print, over the edge of the marker or of a board's squares.
_PLATE_THICKNESS = 0.003
_WALL_GAP = 0.25  # Between the farthest thing and the wall [m].
_WALL_TILT = np.deg2rad([7.0, -11.0, 0.0])


@dataclass(frozen=True)
class Stage:
    """Everything but the body.

    Attributes:
        blocks: that hide the held parts.
        plate: under the marker, or None.
    """

    blocks: tuple[Box, ...]
    plate: Box | None

    def points(self) -> FloatArray:
        """Return the marker plate's corners in the world frame [m], shape (n, 3)."""
        return np.zeros((0, 3)) if self.plate is None else self.plate.corners()

    def scan(self, rays: FloatArray, camera_from_world: FloatArray, wall: Wall | None) -> Scan:
        """See everything but the body.

        Args:
            rays: with z = 1 in the camera's frame, shape (H, W, 3).
            camera_from_world: pose of the camera, shape (4, 4).
            wall: what is behind, or None.
        """
        view = Scan.empty(*rays.shape[:2])
        if wall is not None:
            view = wall.scan(rays, camera_from_world)
        for block in self.blocks:
            view = block.scan(rays, camera_from_world).in_front_of(view)
        if self.plate is None:
            return view
        # A block that would hide the marker has an opening for it.
        return self.plate.scan(rays, camera_from_world).painted_over(view)


def make_stage(scene: Scene, setup: ObservationSetup) -> Stage:
    """Put up what a scene implies for one posture."""
    rest = world_positions(scene.mesh, setup)
    # A support that lets go is below the body, and hides nothing.
    blocks = tuple(_block(scene, setup, part, rest) for part in setup.staying)
    return Stage(blocks, None if scene.marker is None else _plate(scene.marker))


def wall_behind(points_world: FloatArray, depth_from_world: FloatArray) -> Wall:
    """Put a wall behind some points, not quite square to the camera."""
    points = apply(depth_from_world, points_world)
    world_from_depth = inverse(depth_from_world)
    middle = np.array([0.0, 0.0, points[:, 2].max() + _WALL_GAP])
    normal = rotation_matrix(_WALL_TILT) @ np.array([0.0, 0.0, -1.0])
    return Wall(apply(world_from_depth, middle), world_from_depth[:3, :3] @ normal)


def scan_body(body: PosedBody, camera: PinholeCamera, camera_from_world: FloatArray) -> Scan:
    """See the body alone.

    Raises:
        OutOfViewError: when the camera does not see it.
    """
    points = apply(camera_from_world, body.positions)
    tracer = DepthTracer(body.triangles, len(points), camera)
    trace = tracer.trace(points)
    if not (trace.faces >= 0).any():
        raise OutOfViewError('the body covers no pixel')
    view = Scan.empty(camera.height, camera.width)
    is_seen = trace.faces >= 0
    cosines = facing_cosines(points, body.triangles)
    window = (trace.rows, trace.columns)
    view.depth[window] = trace.depth
    view.cosine[window] = np.where(is_seen, cosines[np.maximum(trace.faces, 0)], 1.0)
    view.things[window] = np.where(is_seen, int(Thing.BODY), int(Thing.NOTHING))
    return view


def _block(scene: Scene, setup: ObservationSetup, part: HeldPart, rest_world: FloatArray) -> Box:
    """Put a block around a held part, open where the body comes out of it."""
    own = scene.mesh.rest_positions[part.vertices]
    low, high = own.min(axis=0), own.max(axis=0)
    body_low, body_high = scene.mesh.extent
    low = low - np.where(body_low < low - _REACHES_OUT, 0.0, _BLOCK_MARGIN)
    high = high + np.where(body_high > high + _REACHES_OUT, 0.0, _BLOCK_MARGIN)
    world_from_block = setup.world_from_object
    if part.turn is not None:
        world_from_block = turn_motion(part.turn, rest_world[part.vertices]) @ world_from_block
    return Box(world_from_block, low, high, Thing.BLOCK)


def _plate(marker: Marker) -> Box:
    across, up = 0.5 * marker.size + _PLATE_RIM * marker.square
    return Box(
        marker.world_from_marker,
        np.array([-across, -up, -_PLATE_THICKNESS]),
        np.array([across, up, 0.0]),
        Thing.PLATE,
    )
