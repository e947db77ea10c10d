# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Other worlds for one recording: how each is made, and what must stay as it was.

Of the same data stated in another way (an origin, axes, the frame of a mesh, the order of poses,
a camera on its side) the verdict must be the same. Another size or density is another body with
the same picture in other units: what is measured in shares must stay. With less data a name may
be withheld; another one may not be given.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
import zlib

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.rigid_transform import inverse, transform
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
import yaml

from benchmarks.other_worlds.case_files import (
    Bag,
    Case,
    each_image,
    FloatArray,
    matrix_of,
    placement_of,
)

AS_IT_IS = 'as_it_is'
_ORIGIN = np.array([2.3, -3.1, 1.7])  # Of the other world [m].
_MESH_ORIGIN = np.array([1.0, -0.7, 0.4])  # Of the mesh's other frame [m].
_MESH_AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
_QUARTER_TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


class NotOfThisWorldError(Exception):
    """A case cannot be stated in a world; says why."""


@dataclass(frozen=True)
class World:
    """One way to state a recording.

    Attributes:
        change: a case, in place.
        modulus: by how much Young's modulus is another one.
        is_same: all data are there, in other words or units; else there are fewer.
    """

    change: Callable[[Case], None]
    modulus: float = 1.0
    is_same: bool = True


def as_it_is(case: Case) -> None:
    """Change nothing: what the others are compared with."""


def moved(case: Case) -> None:
    """Put the world's origin 4 m away and turn its axes."""
    rotation, _ = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
    world = transform(rotation * np.sign(np.linalg.det(rotation)), _ORIGIN)
    for stated in (case.scene, *case.scene['observations']):
        if 'gravity' in stated:
            stated['gravity'] = (world[:3, :3] @ np.array(stated['gravity'])).tolist()
        if 'stored_depth_from_world' in stated:
            camera = matrix_of(stated['stored_depth_from_world']) @ inverse(world)
            stated['stored_depth_from_world'] = placement_of(camera)
    for seen in case.scene['observations']:
        seen['placement'] = placement_of(world @ matrix_of(seen['placement']))


def in_reverse(case: Case) -> None:
    """Name the poses in the other order."""
    case.scene['observations'].reverse()


def mesh_elsewhere(case: Case) -> None:
    """Draw the mesh in another frame: x becomes y, y becomes z, the origin is 1.3 m away."""
    frame = transform(_MESH_AXES, _MESH_ORIGIN)
    for box in case.boxes():
        old = {axis: box.pop(axis) for axis in 'xyz' if axis in box}
        for axis, row, shift in zip('xyz', _MESH_AXES, _MESH_ORIGIN, strict=True):
            before = 'xyz'[int(np.argmax(row))]
            if before in old:
                box[axis] = [float(end + shift) for end in old[before]]
    for seen in case.scene['observations']:
        seen['placement'] = placement_of(matrix_of(seen['placement']) @ inverse(frame))
    case.points = case.points @ _MESH_AXES.T + 1e3 * _MESH_ORIGIN


def camera_on_its_side(case: Case) -> None:
    """Turn the camera by 90 degrees about its axis: rows become columns."""
    turn = transform(_QUARTER_TURN, np.zeros(3))
    for stated in (case.scene, *case.scene['observations']):
        if 'stored_depth_from_world' in stated:
            camera = turn @ matrix_of(stated['stored_depth_from_world'])
            stated['stored_depth_from_world'] = placement_of(camera)

    def turned(bag: Bag) -> Bag:
        old = bag.camera
        if any(old.distortion):
            raise NotOfThisWorldError('its camera has distortion, which no side turns')
        camera = PinholeCamera(
            old.height, old.width, old.fy, old.fx, old.cy, old.width - 1 - old.cx
        )
        return replace(each_image(bag, np.rot90), camera=camera)

    case.each_bag(turned)


def of_size(factor: float) -> Callable[[Case], None]:
    """Return how to make all lengths larger, under the same gravity, noise with them.

    Times grow with the root of it, a viscosity [Pa s] by its power of 1.5.
    """
    slower = factor**0.5

    def change(case: Case) -> None:
        scene = case.scene
        case.points = case.points * factor
        for box in case.boxes():
            box.update({axis: [factor * end for end in ends] for axis, ends in box.items()})
        placed = [seen['placement'] for seen in scene['observations']]
        for placement in (scene['stored_depth_from_world'], *placed):
            placement['translation'] = [factor * value for value in placement['translation']]
        for part, name in (
            ('pose', 'position_std'),
            ('sensor', 'noise'),
            ('sensor', 'quantization'),
            ('masks', 'held_margin'),
        ):
            scene[part][name] *= factor
        _stiffen(scene['regions']['body'], factor, slower)
        for seen in scene['observations']:
            if 'motion' in seen:
                seen['motion']['at'] *= slower
        case.each_bag(lambda bag: _larger(bag, factor))

    return change


def _stiffen(body: dict[str, object], factor: float, slower: float) -> None:
    """Change what a scene expects of a material to that of a larger body."""
    for name, by in (('youngs_modulus', factor), ('damping', factor * slower)):
        stated = body.get(name)
        if isinstance(stated, dict):
            for part in (stated, stated.get('prior', {})):
                part.update({key: value * by for key, value in part.items() if key != 'prior'})


def _larger(bag: Bag, factor: float) -> Bag:
    """Return a recording of larger depth and longer time."""
    begun = bag.frames[0].stamp_ns
    frames = (
        replace(
            frame,
            depth=frame.depth * np.float32(factor),
            stamp_ns=begun + round((frame.stamp_ns - begun) * factor**0.5),
        )
        for frame in bag.frames
    )
    return replace(bag, frames=tuple(frames))


def of_density(factor: float) -> Callable[[Case], None]:
    """Return how to state another density."""

    def change(case: Case) -> None:
        case.scene['regions']['body']['density'] *= factor

    return change


def begun_at(factor: float) -> Callable[[Case], None]:
    """Return how to begin from another modulus."""

    def change(case: Case) -> None:
        case.scene['regions']['body']['youngs_modulus']['start'] *= factor

    return change


def half_of_the_poses(case: Case) -> None:
    """Keep the first half of the poses."""
    seen = case.scene['observations']
    if len(seen) < 2:
        raise NotOfThisWorldError('the case holds one pose')
    del seen[(len(seen) + 1) // 2 :]


def first_frame(case: Case) -> None:
    """Keep one frame of each pose of a body at rest."""
    _require_rest(case)
    case.each_bag(lambda bag: replace(bag, frames=bag.frames[:1]))


def every_second_frame(case: Case) -> None:
    """Keep every second frame of a motion."""
    if not _is_moving(case):
        raise NotOfThisWorldError('it is one of motions, and the case holds bodies at rest')
    case.each_bag(lambda bag: replace(bag, frames=bag.frames[::2]))


def fewer_pixels(case: Case) -> None:
    """Keep every second pixel of every second row."""

    def coarser(image: NDArray[np.float32]) -> NDArray[np.float32]:
        return image[: image.shape[0] // 2 * 2 : 2, : image.shape[1] // 2 * 2 : 2]

    def change(bag: Bag) -> Bag:
        old = bag.camera
        camera = PinholeCamera(
            old.width // 2, old.height // 2, old.fx / 2, old.fy / 2, old.cx / 2, old.cy / 2
        )
        return replace(each_image(bag, coarser), camera=camera)

    case.each_bag(change)


def whole_millimetres(case: Case) -> None:
    """Round depth to millimetres, as most cameras' 16 bits do."""
    step = np.float32(1e-3)
    case.scene['sensor']['quantization'] = 1e-3
    case.each_bag(lambda bag: each_image(bag, lambda image: np.round(image / step) * step))


def with_smooth_error(size: float) -> Callable[[Case], None]:
    """Return how to read depth with a smooth error [m] that is partly the same in all poses.

    Over what it changes and how much of it stands are drawn by the scene.
    """

    def change(case: Case) -> None:
        random = np.random.default_rng(zlib.crc32(yaml.safe_dump(case.scene).encode()))
        length, standing = random.uniform(50.0, 150.0), random.uniform(0.2, 0.9)
        cameras = [bag.camera for bag in case.bags.values()]
        if len({(camera.height, camera.width) for camera in cameras}) > 1:
            raise NotOfThisWorldError('its images are of several sizes')
        common, *own = (_smooth(cameras[0], length, random) for _ in [None, *cameras])
        for (name, bag), alone in zip(list(case.bags.items()), own, strict=True):
            error = np.sqrt(standing) * common + np.sqrt(1.0 - standing) * alone
            case.bags[name] = each_image(bag, partial(_added, size * error))

    return change


def _smooth(camera: PinholeCamera, length: float, random: np.random.Generator) -> FloatArray:
    """Draw a field of mean square 1 that changes over a length [px], shape (h, w)."""
    edge = int(2 * length)  # What is smoothed knows nothing of the border.
    drawn = random.normal(size=(camera.height + 2 * edge, camera.width + 2 * edge))
    field = ndimage.gaussian_filter(drawn, length / np.sqrt(2.0))[edge:-edge, edge:-edge]
    return np.asarray(field / np.sqrt(np.mean(field**2)))


def _added(error: FloatArray, image: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.where(image > 0.0, image + error, image).astype(np.float32)


def _is_moving(case: Case) -> bool:
    return any('motion' in seen for seen in case.scene['observations'])


def _require_rest(case: Case) -> None:
    if _is_moving(case):
        raise NotOfThisWorldError('it is one of bodies at rest, and the case holds a motion')


WORLDS: dict[str, World] = {
    AS_IT_IS: World(as_it_is),
    'moved': World(moved),
    'in_reverse': World(in_reverse),
    'mesh_elsewhere': World(mesh_elsewhere),
    'camera_on_its_side': World(camera_on_its_side),
    'larger': World(of_size(2.5), modulus=2.5),
    'smaller': World(of_size(0.4), modulus=0.4),
    'denser': World(of_density(2.0), modulus=2.0),
    'begun_stiff': World(begun_at(3.0)),
    'begun_soft': World(begun_at(0.3)),
    'half_of_the_poses': World(half_of_the_poses, is_same=False),
    'first_frame': World(first_frame, is_same=False),
    'every_second_frame': World(every_second_frame, is_same=False),
    'fewer_pixels': World(fewer_pixels, is_same=False),
    'worse_sensor': World(with_smooth_error(1e-3), is_same=False),
    'whole_millimetres': World(whole_millimetres, is_same=False),
}
