# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Turn an experiment of the public data set into a scene and a recording."""

from dataclasses import dataclass
import os
from pathlib import Path
import shutil

from diffcal_ros.atomic_file import replacing, write_text_atomically
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.dataset.experiments import DatasetCase, DatasetObservation, open_case
from diffcal_ros.recording.dataset.frames import load_color, load_depth
from diffcal_ros.recording.dataset.scene import scene_text
from diffcal_ros.recording.topics.names import COLOR_FRAME, DEPTH_FRAME


@dataclass(frozen=True)
class ImportedBag:
    """A recording that was written.

    Attributes:
        path: rosbag2 directory.
        depth_count: depth images in it.
        color_count: colour images in it.
    """

    path: Path
    depth_count: int
    color_count: int


@dataclass(frozen=True)
class ImportedCase:
    """What an import wrote.

    Attributes:
        scene: the scene file.
        bags: recordings, by observation; none without frames.
        warnings: what the user should know.
    """

    scene: Path
    bags: dict[str, ImportedBag]
    warnings: tuple[str, ...]


def import_case(
    dataset: str | os.PathLike[str],
    name: str,
    out: str | os.PathLike[str],
    *,
    overwrite: bool = False,
) -> ImportedCase:
    """Write `out`/scene.yaml, the mesh beside it, and `out`/bag where there are frames.

    Args:
        dataset: folder with `exp_data` and `CAD_models`.
        name: of the experiment.
        out: folder to write to.
        overwrite: replace a scene and a bag that are there.

    Raises:
        RecordingError: when the experiment is not there or incomplete, or `out` has a scene.
    """
    case = open_case(Path(dataset), name)
    folder = Path(out)
    scene = folder / 'scene.yaml'
    if scene.exists() and not overwrite:
        raise RecordingError(f'{scene} exists already: choose another folder, or add --overwrite')
    bags: dict[str, ImportedBag] = {}
    for item in case.observations:
        if item.depth_files or item.color_files:
            label = 'bag' if len(case.observations) == 1 else f'bag_{item.name}'
            bags[item.name] = _write_bag(case, item, folder / label, overwrite=overwrite)
    mesh_file = folder / case.mesh_file.name
    with replacing(mesh_file) as fresh:
        shutil.copyfile(case.mesh_file, fresh)
    with_depth = {key: bag.path.name for key, bag in bags.items() if bag.depth_count}
    write_text_atomically(scene, scene_text(case, mesh_file=mesh_file.name, bags=with_depth))
    return ImportedCase(scene, bags, _warnings(case))


def _write_bag(
    case: DatasetCase, item: DatasetObservation, path: Path, *, overwrite: bool
) -> ImportedBag:
    stamps = sorted({*item.depth_files, *item.color_files})
    with BagWriter(path, overwrite=overwrite) as bag:
        bag.write_depth_from_color(
            case.depth_from_color,
            depth_frame=DEPTH_FRAME,
            color_frame=COLOR_FRAME,
            stamp_ns=stamps[0],
        )
        for stamp in stamps:
            if stamp in item.depth_files:
                bag.write_depth_camera(case.depth_camera, stamp_ns=stamp, frame_id=DEPTH_FRAME)
                bag.write_depth(load_depth(item.depth_files[stamp], stamp, case.depth_camera))
            if stamp in item.color_files:
                bag.write_color_camera(case.color_camera, stamp_ns=stamp, frame_id=COLOR_FRAME)
                bag.write_color(load_color(item.color_files[stamp], stamp, case.color_camera))
    return ImportedBag(path, len(item.depth_files), len(item.color_files))


def _warnings(case: DatasetCase) -> tuple[str, ...]:
    warnings: list[str] = []
    for item in case.observations:
        warnings += item.notes
        if item.depth_files:
            continue
        written = (
            f'the bag holds {len(item.color_files)} colour frames only'
            if item.color_files
            else 'no bag was written'
        )
        warnings.append(
            f'{case.name} ({item.name}) has no depth frame in this copy of the data set: '
            f'{written}, and there is nothing to calibrate on'
        )
    return tuple(warnings)
