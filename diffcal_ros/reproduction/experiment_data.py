# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a row's words to a scene and its recordings: imported, or simulated."""

from collections.abc import Mapping
from dataclasses import replace
import hashlib
import json
from pathlib import Path
import shutil
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.errors import RecordingError, SceneError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.offline.calibrate_recordings import OfflineInputs, open_inputs
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.reproduction.row import merged, Variant
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.reading.yaml_document import read_yaml
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.recorder import record, RecorderSettings
import yaml

# Keys of a recording's scene that say how it was filmed.
_FILMED = ('bag', 'sensor', 'stored_depth_from_world', 'pose')
_TIMING = ('frames', 'rate')
_RECORDER = ('color_frames', 'seed', 'is_refined', 'camera_position')


def open_experiment(variant: Variant, dataset: Path | None, folder: Path) -> OfflineInputs:
    """Import or simulate what a variant needs, and open it; what is there already is used.

    Args:
        variant: of a row.
        dataset: root of the public data set, or None.
        folder: for the scene, its mesh and the recordings.

    Raises:
        InputError: when the data set is needed and not there, or something in it is wrong.
    """
    base = _base_scene(variant, dataset, folder / 'data')
    document = read_yaml(base).content
    if variant.simulate is not None:
        document = _filmed(variant.simulate, document, base.parent, dataset, folder)
    document = merged(document, variant.scene)
    if variant.mesh is not None:
        document['mesh']['file'] = str(_mesh_of(variant.mesh, dataset).resolve())
    path = base.with_name('fit.yaml')
    write_text_atomically(path, yaml.safe_dump(document, sort_keys=False))
    scene = load_scene(path)
    inputs = open_inputs(scene, [], pose_source=variant.pose)
    if variant.pixel_step == 1:
        return inputs
    takes = tuple(
        tuple(every_nth_pixel(seen, variant.pixel_step) for seen in take) for take in inputs.takes
    )
    return replace(inputs, takes=takes)


def open_members(variant: Variant, dataset: Path | None, folder: Path) -> list[OfflineInputs]:
    """Open every body of a variant: its members', or its only one's."""
    if not variant.members:
        return [open_experiment(variant, dataset, folder)]
    return [open_experiment(own, dataset, folder / own.name) for own in variant.members]


def every_nth_pixel(observation: Observation, step: int) -> Observation:
    """Return what a camera with fewer pixels would have seen."""
    camera = observation.camera
    depth = observation.depth[::step, ::step]
    coarser = replace(
        camera,
        width=depth.shape[1],
        height=depth.shape[0],
        fx=camera.fx / step,
        fy=camera.fy / step,
        cx=camera.cx / step,
        cy=camera.cy / step,
    )
    return replace(observation, depth=depth, camera=coarser)


def _base_scene(variant: Variant, dataset: Path | None, folder: Path) -> Path:
    """Return the scene file that the variant changes."""
    path = folder / 'scene.yaml'
    if variant.case is None:
        assert variant.scene_file is not None
        content = read_yaml(variant.scene_file).content
        mesh = variant.scene_file.parent / str(content['mesh']['file'])
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(mesh, folder / mesh.name)
        content = merged(content, {'mesh': {'file': mesh.name}})
        write_text_atomically(path, yaml.safe_dump(content, sort_keys=False))
    elif not path.exists():
        if dataset is None:
            raise RecordingError(
                'the public DiffCal data set is needed: give the root of a clone of it with '
                '--data, or in the environment as DIFFCAL_DATA'
            )
        imported = import_case(dataset, variant.case, folder, overwrite=True)
        if variant.simulate is None and not any(bag.depth_count for bag in imported.bags.values()):
            path.unlink()
            raise RecordingError(
                f'{variant.case} has no depth frame in {dataset}: complete the clone of the data '
                'set, or take an experiment that is simulated'
            )
    return path


def _filmed(
    simulate: Mapping[str, Any],
    document: dict[str, Any],
    base_folder: Path,
    dataset: Path | None,
    folder: Path,
) -> dict[str, Any]:
    """Film the true body, once, and return the scene with how it was filmed."""
    recorded = folder / f'recorded_{_digest(simulate)}'
    if not (recorded / 'scene.yaml').exists():
        truth = merged(document, simulate.get('truth', {}))
        mesh = base_folder / str(document['mesh']['file'])
        if 'mesh' in simulate:
            mesh = _mesh_of(str(simulate['mesh']), dataset)
        truth = merged(truth, {'mesh': {'file': str(mesh.resolve())}, 'bag': None})
        path = folder / 'truth' / 'scene.yaml'
        write_text_atomically(path, yaml.safe_dump(truth, sort_keys=False))
        record(load_scene(path), recorded, _recorder(simulate), overwrite=True)
    seen = read_yaml(recorded / 'scene.yaml').content
    filmed = merged(document, {key: seen[key] for key in _FILMED if key in seen})
    if 'bag' in seen:
        filmed['bag'] = f'../{recorded.name}/{seen["bag"]}'
    for own, other in zip(
        filmed.get('observations', ()), seen.get('observations', ()), strict=True
    ):
        own.update({key: other[key] for key in _FILMED if key in other})
        own['bag'] = f'../{recorded.name}/{other["bag"]}'
    return filmed


def _digest(simulate: Mapping[str, Any]) -> str:
    """Name a recording by how it was made: another truth is another recording."""
    text = json.dumps(simulate, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def _recorder(simulate: Mapping[str, Any]) -> RecorderSettings:
    unknown = sorted(set(simulate) - {'truth', 'mesh', 'element', *_TIMING, *_RECORDER})
    if unknown:
        raise SceneError(
            f'simulate has {unknown[0]!r}, which is not known: use truth, mesh, element, '
            f'{", ".join((*_TIMING, *_RECORDER))}'
        )
    settings = {key: simulate[key] for key in _RECORDER if key in simulate}
    timing = Timing(**{key: simulate[key] for key in _TIMING if key in simulate})
    element = Element(simulate.get('element', Element.QUADRATIC.value))
    return RecorderSettings(**settings, timing=timing, element=element)


def _mesh_of(name: str, dataset: Path | None) -> Path:
    """Return the tetrahedral mesh in a folder of the data set."""
    found = [] if dataset is None else sorted((dataset / name).glob('*.tet'))
    if len(found) != 1:
        raise RecordingError(f'{dataset} has no mesh {name}: complete the clone of the data set')
    return found[0]
