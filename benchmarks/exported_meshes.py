# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numbers that MuJoCo and Newton need on meshes of two sizes, and the gap that they leave.

    python -m benchmarks.exported_meshes --out DIR [--data DATASET] [--only 'sample*']

The bundled sample on its own mesh and on the same solid with more cells, and the public
cantilever h_e_c on two of the data set's meshes. Each is calibrated as `diffcal calibrate --for
mujoco newton` does it, with both simulators installed. Resumes where it stopped; writes
benchmarks/results/exported_meshes.json.
"""

import argparse
from fnmatch import fnmatch
import importlib.metadata
import json
from pathlib import Path
import runpy
import sys
import time
from typing import Any
from unittest.mock import patch

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.export.effective.fit import fit_effective
from diffcal_ros.export.effective.simulators import find_simulator
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.save import save_fitted_scene
import yaml

from benchmarks.measuring import write

_SAMPLE = Path(__file__).parents[1] / 'bags'
# Cells through the strip, through a rib, and across, in place of the sample's 2, 2, 3.
_CELLS = {'sample': None, 'sample_finer': (3, 3, 5)}
# Folders of the data set's meshes.
_CANTILEVERS = {'h_e_c': None, 'h_e_c_finer': 'cantilever'}
SIMULATORS = ('mujoco', 'newton')


def main() -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--out', type=Path, required=True)
    parser.add_argument('--data', type=Path, help='public data set')
    parser.add_argument('--only', default='*', help='pattern of names')
    given = parser.parse_args()
    names = (*_CELLS, *(_CANTILEVERS if given.data else ()))
    for name in names:
        for simulator in SIMULATORS:
            file = given.out / name / f'{simulator}.json'
            if fnmatch(name, given.only) and not file.is_file():
                print(name, simulator, flush=True)
                found = study(_scene(name, given.data, file.parent), simulator, file.parent)
                write_text_atomically(file, json.dumps(found, indent=1) + '\n')
    found = {
        name: {
            simulator: json.loads(file.read_text())
            for simulator in SIMULATORS
            if (file := given.out / name / f'{simulator}.json').is_file()
        }
        for name in (*_CELLS, *_CANTILEVERS)
    }
    versions = {name: importlib.metadata.version(name) for name in SIMULATORS}
    write('exported_meshes', {'versions': versions, **found})
    return 0


def _scene(name: str, data: Path | None, folder: Path) -> Path:
    """Return the scene file of a case, written to the folder where there is none yet."""
    if name in _CELLS:
        return (
            _finer_sample(_CELLS[name], folder) if _CELLS[name] else _SAMPLE / 'sample/scene.yaml'
        )
    assert data is not None
    scene = import_case(data, 'h_e_c', folder / 'imported', overwrite=True).scene
    shape = _CANTILEVERS[name]
    if shape is not None:
        (mesh,) = (data / 'CAD_models' / shape).glob('*.tet')
        document = yaml.safe_load(scene.read_text())
        document['mesh']['file'] = str(mesh)
        scene.write_text(yaml.safe_dump(document, sort_keys=False))
    return scene


def _finer_sample(cells: tuple[int, int, int], folder: Path) -> Path:
    maker = runpy.run_path(str(_SAMPLE / 'make_sample.py'))
    sizes = dict(zip(('_STRIP_CELLS', '_RIB_CELLS', '_WIDTH_CELLS'), cells, strict=True))
    finger = maker['finger']
    with patch.dict(finger.__globals__, sizes):
        text = maker['vtk_text'](finger())
    folder.mkdir(parents=True, exist_ok=True)
    (folder / 'finger.vtk').write_text(text)
    document = yaml.safe_load((_SAMPLE / 'sample/scene.yaml').read_text())
    document['bag'] = str(_SAMPLE / 'sample/bag')
    scene = folder / 'scene.yaml'
    scene.write_text(yaml.safe_dump(document, sort_keys=False))
    return scene


def study(path: Path, simulator: str, folder: Path) -> dict[str, Any]:
    """Calibrate a scene, fit what a simulator needs, and return both."""
    inputs = open_inputs(load_scene(path), [])
    begun = time.process_time()
    calibration = Calibration(inputs.scene, inputs.observations)
    result = calibration.run()
    between = time.process_time()
    fitted = folder / 'fitted_scene.yaml'
    save_fitted_scene(inputs.scene, fitted, result.values())
    effective = fit_effective(
        calibration, result, load_scene(fitted), find_simulator(simulator), report=print
    )
    modulus = result['youngs_modulus']
    return {
        'tetrahedra': inputs.scene.mesh.tet_count,
        'fitted_kPa': 1e-3 * modulus.value,
        'calibration_cpu_s': round(between - begun, 1),
        'effective_cpu_s': round(time.process_time() - between, 1),
        **effective.as_dict(),
    }


if __name__ == '__main__':
    sys.exit(main())
