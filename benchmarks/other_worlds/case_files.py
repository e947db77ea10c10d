# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A case of the independent generator in memory, to be changed and written elsewhere."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.rigid_transform import transform
import numpy as np
from numpy.typing import NDArray
import yaml

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Bag:
    """One recording.

    Attributes:
        camera: that took it.
        frames: depth images [m], in order.
    """

    camera: PinholeCamera
    frames: tuple[DepthFrame, ...]


@dataclass
class Case:
    """A recorded body, and the scene that is stated of it.

    Attributes:
        scene: content of scene.yaml.
        extra: content of extra.yaml.
        points: nodes of the mesh [mm], shape (n, 3).
        mesh_text: lines of mesh.vtk before and after its nodes.
        bags: by the name that the scene gives.
    """

    scene: dict[str, Any]
    extra: dict[str, Any]
    points: FloatArray
    mesh_text: tuple[list[str], list[str]]
    bags: dict[str, Bag]

    def boxes(self) -> list[dict[str, list[float]]]:
        """Return all boxes in the frame of the mesh, to be changed in place [m]."""
        held = [part['box'] for part in self.scene['held'].values()]
        fixture = self.extra['fixture']
        return [*held, *(fixture.get('boxes') or [fixture['box']])]

    def each_bag(self, change: Callable[[Bag], Bag]) -> None:
        """Change every recording."""
        self.bags = {name: change(bag) for name, bag in self.bags.items()}


def each_image(bag: Bag, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Bag:
    """Return a recording with every depth image changed."""
    frames = (replace(f, depth=np.ascontiguousarray(change(f.depth))) for f in bag.frames)
    return replace(bag, frames=tuple(frames))


def read_case(folder: Path) -> Case:
    """Read a case.

    Args:
        folder: with scene.yaml, extra.yaml, mesh.vtk (of the generator) and bags.
    """
    scene = yaml.safe_load((folder / 'scene.yaml').read_text())
    extra = yaml.safe_load((folder / 'extra.yaml').read_text())
    lines = (folder / scene['mesh']['file']).read_text().splitlines()
    first = next(n for n, line in enumerate(lines) if line.startswith('POINTS')) + 1
    end = first + int(lines[first - 1].split()[1])
    points = np.array([line.split() for line in lines[first:end]], dtype=np.float64)
    bags = {}
    for seen in scene['observations']:
        recording = open_recording(folder / seen['bag'])
        bags[seen['bag']] = Bag(recording.depth_camera, tuple(recording.depth_frames()))
    return Case(scene, extra, points, (lines[:first], lines[end:]), bags)


def write_case(case: Case, folder: Path) -> None:
    """Write a case into a folder that is not there yet."""
    folder.mkdir(parents=True)
    for name, content in (('scene', case.scene), ('extra', case.extra)):
        (folder / f'{name}.yaml').write_text(yaml.safe_dump(content, sort_keys=False))
    before, after = case.mesh_text
    nodes = [' '.join(repr(float(value)) for value in point) for point in case.points]
    (folder / case.scene['mesh']['file']).write_text('\n'.join([*before, *nodes, *after]) + '\n')
    for name in {seen['bag'] for seen in case.scene['observations']}:
        bag = case.bags[name]
        first = bag.frames[0]
        with BagWriter(folder / name) as writer:
            writer.write_depth_camera(bag.camera, stamp_ns=first.stamp_ns, frame_id=first.frame_id)
            for frame in bag.frames:
                writer.write_depth(frame)


def matrix_of(placement: dict[str, Any]) -> FloatArray:
    """Return the matrix of a scene's placement, shape (4, 4)."""
    rotation, translation = placement['rotation_matrix'], placement['translation']
    return transform(np.array(rotation), np.array(translation))


def placement_of(matrix: FloatArray) -> dict[str, Any]:
    """Return how a scene writes a matrix, shape (4, 4)."""
    return {
        'translation': matrix[:3, 3].tolist(),
        'rotation_matrix': matrix[:3, :3].tolist(),
    }
