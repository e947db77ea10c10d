# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The settings file of one experiment of the public data set (`.exp`, key=value lines)."""

from dataclasses import dataclass
from pathlib import Path

from diffcal_ros.errors import RecordingError
from diffcal_ros.rigid_transform import check_rigid
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_CENTIMETRE = 0.01


@dataclass(frozen=True)
class ExpFile:
    """What the importer needs of an experiment's settings.

    Attributes:
        path: the file.
        camera_data_path: folder of the frames, as written; often stale.
        object_data_path: folder of the mesh, relative to the data set.
        depth_intrinsics: fx, fy, cx, cy [px].
        depth_from_color: shape (4, 4) [m].
        stored_rotation: of the object, as stored, shape (3, 3); not yet what it means.
        translation: of the object in the world frame [m], shape (3,).
        held_boxes: lower and upper limits in coordinates about the middle of the mesh's
            bounding box [m], shape (n, 2, 3).
        region_boxes: likewise, shape (m, 2, 3).
    """

    path: Path
    camera_data_path: str
    object_data_path: str
    depth_intrinsics: tuple[float, float, float, float]
    depth_from_color: FloatArray
    stored_rotation: FloatArray
    translation: FloatArray
    held_boxes: FloatArray
    region_boxes: FloatArray


def read_exp_file(path: Path) -> ExpFile:
    """Read an experiment's settings.

    Raises:
        RecordingError: naming the key that is missing or wrong.
    """
    try:
        lines = path.read_text(encoding='utf-8').splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise RecordingError(f'{path} cannot be read ({error}): check the data set') from error
    pairs = (line.split('=', 1) for line in lines if '=' in line)
    fields = _Fields(path, {key.strip(): value.strip() for key, value in pairs})
    K = fields.numbers('camera_intrinsics', 9).reshape(3, 3)
    fields.refuse_distortion()
    object_transform = fields.rigid('object_transform', fields.numbers('object_transform', 16))
    if np.abs(fields.numbers('camera_transform', 16).reshape(4, 4) - np.eye(4)).max() > 0.0:
        raise fields.wrong('camera_transform', 'only the identity is known from the data set')
    return ExpFile(
        path=path,
        camera_data_path=fields.text('camera_data_path'),
        object_data_path=fields.text('object_data_path'),
        depth_intrinsics=(float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2])),
        # Stored column by column.
        depth_from_color=fields.rigid(
            'rgb_to_depth_transform', fields.numbers('rgb_to_depth_transform', 16), by_column=True
        ),
        stored_rotation=object_transform[:3, :3],
        translation=object_transform[:3, 3] * _CENTIMETRE,
        held_boxes=fields.boxes('object_dirichlet_boundary_conditions'),
        region_boxes=fields.boxes('object_parameter_bounding_boxes'),
    )


@dataclass(frozen=True)
class _Fields:
    path: Path
    values: dict[str, str]

    def wrong(self, key: str, reason: str) -> RecordingError:
        given = self.values.get(key)
        told = 'is missing' if given is None else f'is {given[:60]!r}'
        return RecordingError(f'{self.path}: {key} {told}: {reason}')

    def text(self, key: str) -> str:
        if not self.values.get(key):
            raise self.wrong(key, 'a path is needed')
        return self.values[key]

    def numbers(self, key: str, count: int | None = None) -> FloatArray:
        needed = f'{count} numbers are needed' if count else 'a list of numbers is needed'
        items = self.values.get(key, '').strip('[]').split(',')
        try:
            numbers = np.array([float(item) for item in items])
        except ValueError as error:
            raise self.wrong(key, needed) from error
        if count not in (None, len(numbers)) or np.isnan(numbers).any():
            raise self.wrong(key, needed)
        return numbers

    def rigid(self, key: str, numbers: FloatArray, *, by_column: bool = False) -> FloatArray:
        matrix = numbers.reshape(4, 4, order='F' if by_column else 'C')
        try:
            return check_rigid(key, matrix)
        except ValueError as error:
            raise RecordingError(f'{self.path}: {error}') from error

    def boxes(self, key: str) -> FloatArray:
        numbers = self.numbers(key)
        if not numbers.size or numbers.size % 6:
            raise self.wrong(key, 'boxes of six limits each are needed')
        # Stored as x low, x high, y low, ...
        return numbers.reshape(-1, 3, 2).transpose(0, 2, 1) * _CENTIMETRE

    def refuse_distortion(self) -> None:
        if 'camera_distortion' in self.values and self.numbers('camera_distortion').any():
            raise self.wrong('camera_distortion', 'a depth camera without distortion is needed')
