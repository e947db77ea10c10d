# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a result came from: scene, settings and versions."""

import hashlib
from pathlib import Path
import platform
import sys

from diffcal_ros import __version__
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.scene.model import Scene
import numpy as np
import scipy
import warp


def describe_fit(scene: Scene, settings: CalibrationSettings) -> dict[str, object]:
    """Return scene, settings and versions for result.json."""
    return {
        'scene': {
            'name': scene.name,
            'path': str(scene.path) if scene.path else None,
            'sha256': _sha256(scene.path),
            'mesh_sha256': _sha256(scene.file_of('mesh')),
            'modulus_field_sha256': _sha256(scene.file_of('modulus_field')),
            'element': scene.element.value,
            'law': scene.law,
            'lame_convention': scene.convention.value,
            'tet_count': scene.mesh.tet_count,
        },
        'settings': {
            'fit': list(settings.fit or scene.fit),
            'loss': settings.loss,
            'optimizer': settings.optimizer,
            'device': settings.device,
        },
        'versions': {
            'diffcal_ros': __version__,
            'python': platform.python_version(),
            'numpy': np.__version__,
            'scipy': scipy.__version__,
            'warp': warp.config.version,
            'platform': sys.platform,
        },
    }


def _sha256(path: Path | None) -> str | None:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path and path.is_file() else None
