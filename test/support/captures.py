# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The public captures, read through the project's own importer."""

from dataclasses import replace
from functools import cache
from pathlib import Path
import tempfile

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
import numpy as np

from support.scenes import EXACT_POSE

RENDERED_CASES = ('h_e_c', 'h_e_s', 'h_em_c', 'h_em_c_tetwise', 't_em_c', 't_em_c_tetwise')


@cache
def imported(data: Path, case: str) -> Path:
    """Import a case once; return its folder, which lives as long as the tests."""
    folder = Path(tempfile.mkdtemp(prefix=f'diffcal_{case}_'))
    import_case(data, case, folder)
    return folder


@cache
def load_case(data: Path, case: str, pose_source: str) -> tuple[Scene, tuple[Observation, ...]]:
    """Return a case's scene and observations."""
    folder = imported(data, case)
    scene = load_scene(folder / 'scene.yaml')
    if pose_source == 'stored':
        # The authors' implementation, which these are compared with, takes them as exact.
        exact = tuple(replace(setup, pose=EXACT_POSE) for setup in scene.observations)
        scene = replace(scene, observations=exact)
    inputs = open_inputs(scene, [folder / 'bag'], pose_source=pose_source)
    return scene, inputs.observations


def reference(data: Path, case: str, name: str) -> np.ndarray:
    """Load what the authors' implementation computed."""
    return np.load(data / 'reference' / case / f'{name}.npy').astype(np.float64)
