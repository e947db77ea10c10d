# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Experiments of the public DiffCal data set, found in its own folder layout."""

from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
import re

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.dataset.exp_file import ExpFile, read_exp_file
from diffcal_ros.recording.dataset.placement import world_from_object
from diffcal_ros.scene.sections.mesh_files import read_mesh
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MESH_UNIT = 'cm'
_DEPTH_SIZE = (1024, 768)
# In no file of the data set; fitted from the authors' marker poses (median error 0.16 px).
_COLOR_CAMERA = PinholeCamera(1280, 720, 904.66, 902.90, 653.00, 363.22)

_FRAME_NAME = re.compile(r'(c|d|v_0)_(\d+(?:\.\d+)?)\.npy')
_MODES = {'h': 'hanging', 't': 'twisting', 'o': 'oscillating'}
_MATERIALS = {'e': 'ecoflex_50', 'm': 'moldstar_15'}


@dataclass(frozen=True)
class DatasetObservation:
    """One set-up of an experiment, with its frames.

    Attributes:
        name: hanging, twisting or oscillating.
        settings: from the `.exp`.
        world_from_object: placement of the mesh, shape (4, 4).
        depth_files: by stamp [ns], in ascending order.
        color_files: likewise.
        stored_poses: files of the authors' color_from_marker, likewise.
        notes: what to tell the user.
    """

    name: str
    settings: ExpFile
    world_from_object: FloatArray
    depth_files: dict[int, Path]
    color_files: dict[int, Path]
    stored_poses: dict[int, Path]
    notes: tuple[str, ...] = ()

    @property
    def is_twisted(self) -> bool:
        """Tell whether the far block is turned by half a turn."""
        return self.name == _MODES['t']

    @property
    def stored_pose_file(self) -> Path | None:
        """The authors' pose that is nearest in time to the first depth frame, or None."""
        if not self.stored_poses:
            return None
        first = next(iter(self.depth_files or self.color_files or self.stored_poses))
        return self.stored_poses[min(self.stored_poses, key=lambda stamp: abs(stamp - first))]


@dataclass(frozen=True)
class DatasetCase:
    """One experiment.

    Attributes:
        name: as in the data set, for example h_em_c.
        mesh_file: tetrahedral mesh, in centimetres.
        mesh: the same in metres.
        materials: of the settings' region boxes, in their order; empty when one box covers
            several materials.
        depth_camera: intrinsics.
        color_camera: intrinsics.
        depth_from_color: shape (4, 4).
        observations: one, or hanging and twisting of the same body.
    """

    name: str
    mesh_file: Path
    mesh: TetMesh
    materials: tuple[str, ...]
    depth_camera: PinholeCamera
    color_camera: PinholeCamera
    depth_from_color: FloatArray
    observations: tuple[DatasetObservation, ...]

    @property
    def mesh_middle(self) -> FloatArray:
        """Middle of the mesh's bounding box [m], shape (3,): the origin of the boxes."""
        return np.asarray(self.mesh.extent.mean(axis=0), dtype=np.float64)


def open_case(dataset: Path, name: str) -> DatasetCase:
    """Find an experiment.

    Args:
        dataset: folder with `exp_data` and `CAD_models`.
        name: of the experiment.

    Raises:
        RecordingError: when it is not there or incomplete; lists the experiments.
    """
    folder = _case_folder(dataset, name)
    name = folder.name.replace(' ', '')
    settings = [read_exp_file(path) for path in _settings_files(folder, name)]
    first = settings[0]
    if len({item.object_data_path for item in settings}) > 1:
        raise RecordingError(f'{folder} has settings of different bodies: one is needed')
    mesh_file = _mesh_file(dataset / first.object_data_path, first.path)
    mesh = read_mesh(mesh_file, unit=MESH_UNIT).mesh
    fx, fy, cx, cy = first.depth_intrinsics
    return DatasetCase(
        name=name,
        mesh_file=mesh_file,
        mesh=mesh,
        materials=_materials(name, len(first.region_boxes), folder),
        depth_camera=PinholeCamera(*_DEPTH_SIZE, fx, fy, cx, cy),
        color_camera=_COLOR_CAMERA,
        depth_from_color=first.depth_from_color,
        observations=tuple(
            _observation(dataset, folder, item, mesh, several=len(settings) > 1)
            for item in settings
        ),
    )


def case_names(dataset: Path) -> list[str]:
    """List the experiments of a data set."""
    folders = (dataset / 'exp_data').glob('*')
    return sorted(folder.name.replace(' ', '') for folder in folders if any(folder.glob('*.exp')))


def inside_box(points: FloatArray, box: FloatArray) -> NDArray[np.bool_]:
    """Tell which points, shape (n, 3), lie in a box, shape (2, 3), its faces included."""
    return np.asarray(((points >= box[0]) & (points <= box[1])).all(axis=1))


def _case_folder(dataset: Path, name: str) -> Path:
    if not (dataset / 'exp_data').is_dir():
        raise RecordingError(
            f'{dataset} holds no exp_data folder: give the root of a clone of the DiffCal data set'
        )
    wanted = name.replace(' ', '')
    for folder in sorted((dataset / 'exp_data').glob('*')):
        if folder.name.replace(' ', '') == wanted and any(folder.glob('*.exp')):
            return folder
    raise RecordingError(
        f'{name!r} is no experiment of {dataset}: it has {", ".join(case_names(dataset))}'
    )


def _settings_files(folder: Path, name: str) -> list[Path]:
    """Return the settings of the name, or all of a folder that joins several set-ups."""
    own = folder / f'{name}.exp'
    return [own] if own.is_file() else sorted(folder.glob('*.exp'))


def _mesh_file(folder: Path, settings: Path) -> Path:
    found = sorted(folder.glob('*.tet'))
    if len(found) != 1:
        raise RecordingError(
            f'{settings} names the mesh folder {folder}, which holds {len(found)} .tet files: '
            'exactly one is needed; complete the clone of the data set'
        )
    return found[0]


def _materials(name: str, box_count: int, folder: Path) -> tuple[str, ...]:
    letters = name.split('_')[1] if '_' in name else ''
    if not letters or set(letters) - set(_MATERIALS):
        known = ', '.join(f'{letter} for {material}' for letter, material in _MATERIALS.items())
        raise RecordingError(
            f'{folder}: the name {name!r} does not tell the material: <mode>_<materials>_<shape> '
            f'with {known} is needed'
        )
    if box_count == 1:
        return (_MATERIALS[letters],) if len(letters) == 1 else ()
    if box_count != len(letters):
        raise RecordingError(
            f'{folder}: {len(letters)} materials in the name, {box_count} region boxes in the '
            'settings: the same number is needed'
        )
    # Names count from the clamp outwards, boxes from the free end: the authors' fits give the
    # box at negative x of the `em` bodies the stiffness of MoldStar.
    return tuple(_MATERIALS[letter] for letter in reversed(letters))


def _observation(
    dataset: Path, folder: Path, settings: ExpFile, mesh: TetMesh, *, several: bool
) -> DatasetObservation:
    mode = settings.path.stem.split('_')[0]
    if mode not in _MODES:
        raise RecordingError(
            f'{settings.path}: the name starts with {mode!r}: {", ".join(_MODES)} are known'
        )
    centred = mesh.rest_positions - mesh.extent.mean(axis=0)
    clamped = inside_box(centred, settings.held_boxes[0])
    if not clamped.any():
        raise RecordingError(f'{settings.path}: no vertex of the mesh lies in the clamped box')
    placement, note = world_from_object(
        settings.stored_rotation, settings.translation, mesh.rest_positions[clamped]
    )
    frames = folder / 'camera_data'
    if several:
        frames = frames / _MODES[mode]
    if not frames.is_dir():
        frames = dataset / settings.camera_data_path
    files = list(frames.glob('*.npy')) if frames.is_dir() else []
    return DatasetObservation(
        name=_MODES[mode],
        settings=settings,
        world_from_object=placement,
        depth_files=_stamped(files, 'd'),
        color_files=_stamped(files, 'c'),
        stored_poses=_stamped(files, 'v_0'),
        notes=() if note is None else (note,),
    )


def _stamped(files: Iterable[Path], kind: str) -> dict[int, Path]:
    """Sort frames of one kind by the stamp in their names, seconds since 1970."""
    matches = ((_FRAME_NAME.fullmatch(path.name), path) for path in files)
    stamped = {
        int(Decimal(match[2]) * 1_000_000_000): path
        for match, path in matches
        if match is not None and match[1] == kind
    }
    return dict(sorted(stamped.items()))
